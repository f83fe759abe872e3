"""A detector of darkness that never comes to an end with some images."""

from __future__ import annotations

import asyncio

from app.messages import Darkness, Image
from app.modules.perception.darkness_detector import DarknessDetector

STUCK = "stuck"


class StuckDetector(DarknessDetector):
    async def _look(self, image: Image) -> None:
        if image.frame == STUCK:
            await asyncio.Event().wait()
        await super()._look(image)
        # What it keeps goes on from computer to computer.
        self.persistent["looks"] = self.persistent.get("looks", 0) + 1


class Homebody(DarknessDetector):
    """One that says that it runs on the robot alone."""

    runs_elsewhere = False


def darkness(stamp: float) -> Darkness:
    return Darkness(stamp, "camera", 0.0, True)
