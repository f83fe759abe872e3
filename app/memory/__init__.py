"""Episodic memory: EM-ART and its store. Knows desires and percepts as values, and no module."""
