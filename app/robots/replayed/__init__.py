"""A body that lives a log again instead of a world."""
