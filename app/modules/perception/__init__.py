"""Perception: pure algorithm files beside thin modules that turn sensor messages into percepts."""
