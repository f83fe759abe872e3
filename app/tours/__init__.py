"""Guided tours as data: model, checks, files, history, codes on posters and posters to print."""
