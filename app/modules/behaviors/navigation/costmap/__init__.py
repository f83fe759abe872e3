"""Local costmap: obstacle layers, ray tracing, inflation."""
