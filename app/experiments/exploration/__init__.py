"""The exploration experiment: a place that the robot maps by itself, in virtual time."""
