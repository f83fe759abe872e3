"""Guided tours of the laboratory with simulated visitors, judged by the truth."""
