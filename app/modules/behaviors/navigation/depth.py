"""Depth pictures as obstacles on the floor: compiled kernels of the local costmap."""
