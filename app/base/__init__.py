"""Foundations for all rooms: geometry, errors, files of unknown origin, compiled kernels, child processes, logging."""
