"""Robot models of others, made into bodies."""
