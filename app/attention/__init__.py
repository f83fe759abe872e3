"""Attention: what the robot desires, and which strategies, filters and parameters follow from it.

Everything here is pure but :mod:`app.attention.translator`, the only file that knows an event loop.
"""
