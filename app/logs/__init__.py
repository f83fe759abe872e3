"""Logs: writing and reading them; depends on messages, not on modules, bodies or the web."""
