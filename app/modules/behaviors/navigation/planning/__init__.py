"""Global planning: A* over the map's costs, smoothing, goals."""
