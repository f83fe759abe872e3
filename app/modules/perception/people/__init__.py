"""Tracking of persons by their faces, voices, legs and the colours of what they wear: pure, on values."""
