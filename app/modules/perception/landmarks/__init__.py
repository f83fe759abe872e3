"""Landmarks that last: sightings of codes anchored to the map's keyframes."""
