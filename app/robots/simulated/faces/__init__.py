"""Photographs of faces that people in the simulated world wear; sources and licences in ``README.md`` beside."""

from __future__ import annotations

FACES = ("engineer", "officer", "researcher")
