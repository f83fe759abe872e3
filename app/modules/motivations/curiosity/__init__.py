"""Curiosity: the motivation that has the robot explore what its map does not have."""
