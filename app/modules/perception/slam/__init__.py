"""Mapping and localization with a planar laser: keyframes, surfel submaps, loop closure, pose graph.

A functional core: no event loop, no clock, no module. Its interface is ``mapper.Slam``. Files with kernels (``scans``,
``surfels``, ``scan_matching``, ``correlative_matching``) load numba: import them late.
"""
