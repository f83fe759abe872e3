"""A tour of two stops, and the floor with its visitors on which TourGuide leads it."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path
from typing import Any

from app.base.geometry import Pose2
from app.tours.model import Tour
from tests.modules.motivations.tour_guide.led_lab import LedLab, Visitor
from tests.modules.motivations.tour_guide.run import LAB

PLACES = {"one": Pose2(4.0, 0.0, 0.0), "two": Pose2(4.0, 4.0, math.pi / 2), "dock": Pose2(0.0, 0.0, 0.0)}


def tour(**more: Any) -> Tour:
    """Two stops; the second listens, and answers a question. It looks back on every leg."""
    return LAB.model_validate(LAB.model_dump(by_alias=True) | {"pace": {"look_back_m": 1.5}} | more)


async def lab(folder: Path, *visitors: Visitor, **more: Any) -> LedLab:
    """The floor with these visitors."""
    made = await asyncio.to_thread(LedLab, folder, tour(**more), PLACES)
    made.visitors = list(visitors) or [Visitor(1.5, 0.5), Visitor(1.5, -0.5)]
    return made
