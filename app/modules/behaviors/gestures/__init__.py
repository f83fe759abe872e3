"""Behaviors of the arms: where a hand goes and points, and what it grips."""
