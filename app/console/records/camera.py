"""What is seen in the camera's picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from app.messages.base import doc


@dataclass(frozen=True, slots=True)
class CameraPoint:
    """A point on the map (m)."""

    x: float
    y: float
    z: Annotated[float, doc("Above the floor.")]
    measured: Annotated[
        bool, doc("By the camera's depth; else it is where the ray meets the floor, at most 4 m from the camera.")
    ]
