"""A body that replays a log."""
