"""Saying what is desired to be said."""
