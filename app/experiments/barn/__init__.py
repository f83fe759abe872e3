"""Worlds of the BARN challenge, crossed one after another by the robot on its own."""
