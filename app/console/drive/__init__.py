"""Commanding the robot from the page: the drive lease, goals, desires of telepresence."""
