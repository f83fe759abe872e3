"""What is known of one open 3D view."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from app.console.view.budget import PointBudget
from app.console.view.viewpoints import Choice

if TYPE_CHECKING:
    from app.console.view.viewer_camera import CameraState


@dataclass(slots=True, eq=False)
class ViewerSession:
    """One open view. ``drain_s`` is how long its last frame waited for room towards it. ``costmap``: whether it shows
    the local costmap; None: if any page does. ``camera``: from where it looks; ``changed`` is set when that is new.
    ``stamp``: of the robot as it was sent last (s, the robot's clock)."""

    viewer: str
    budget: PointBudget = field(default_factory=PointBudget)
    drain_s: float = 0.0
    sent_bytes: int = 0
    connections: int = 0
    costmap: bool | None = None
    choice: Choice = field(default_factory=Choice)
    camera: CameraState | None = None
    stamp: float | None = None
    changed: asyncio.Event = field(default_factory=asyncio.Event)
