"""Mapping and localization with a planar laser: keyframes, surfel submaps, loop closure, pose graph.

All of it is functional core: no event loop, no clock, no module. ``mapper.Slam`` is what the rest of the program uses.
Files with kernels (``scans``, ``surfels``, ``matching``, ``search``) load numba: import them late.
"""
