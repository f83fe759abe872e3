"""Attention: what the robot desires, and which strategies, filters and parameters follow from it.

Everything here is pure but :mod:`app.attention.translator` and :mod:`app.attention.lanes`, which know an event loop.
"""
