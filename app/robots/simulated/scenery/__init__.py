"""Scenery of the simulated lab: furniture, textures, people and their scripts."""
