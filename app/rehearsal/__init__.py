"""Rehearsals: a program played on a kept map, many times faster than life, without the robot."""
