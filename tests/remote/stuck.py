"""Modules for nodes: a detector that never comes to an end with some images, one of the robot's own, one for sound."""

from __future__ import annotations

import asyncio

from app.messages import Audio, Darkness, Image
from app.modules.perception.darkness_detector import DETECT_DARKNESS, DarknessDetector
from app.runtime.module import Module, ModuleContext

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


class SampleCounter(Module):
    """Answers each frame of sound with the number of its first sample."""

    desire_classes = (DETECT_DARKNESS,)
    runs_elsewhere = True

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.sound = self.input("images", Audio, capacity=94, lossless=True)
        self.counted = self.output("darkness", Darkness)
        self.on(self.sound, self._count)

    def _count(self, audio: Audio) -> None:
        self.counted.publish(Darkness(audio.stamp, audio.frame, float(audio.first_sample), False))
