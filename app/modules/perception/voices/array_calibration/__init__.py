"""Positions and gains of an array's microphones, measured with claps around it."""
