"""Replays: the program on a recorded body, and measurements on it."""
