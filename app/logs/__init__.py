"""Logs: writing them, reading them, and what they hold; knows messages and nothing of modules, bodies or the web."""
