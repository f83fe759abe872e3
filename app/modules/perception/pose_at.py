"""Pose of the robot at a message's own stamp, awaited until odometry reaches it."""

from __future__ import annotations

import asyncio

from app.base.geometry import Pose2
from app.base.pose_buffer import PoseBuffer
from app.messages import Odometry
from app.runtime.clock import Clock


class PoseAt:
    """Poses X_OB by stamp: ``add`` each odometry message, ``await at(stamp)`` for the pose at exactly that instant.

    Never the newest or nearest pose instead: between two odometry messages the pose is interpolated.
    """

    def __init__(self, clock: Clock, span_s: float = 10.0) -> None:
        self._clock = clock
        self._buffer = PoseBuffer(span_s, tolerance_s=0.0)
        self._newest = float("-inf")
        self._arrived = asyncio.Event()

    def add(self, odometry: Odometry) -> None:
        """Add a pose and wake the waiting calls of :meth:`at`."""
        self._buffer.add(odometry.stamp, odometry.X_OB)
        self._newest = max(self._newest, odometry.stamp)
        arrived, self._arrived = self._arrived, asyncio.Event()
        arrived.set()

    async def at(self, stamp: float, patience_s: float = 0.5) -> Pose2 | None:
        """X_OB at ``stamp``; None if odometry did not reach it within ``patience_s`` of the robot's clock, or begins
        later than it."""
        if self._newest < stamp:
            reached = asyncio.create_task(self._reached(stamp), name="odometry reaches a stamp")
            too_late = asyncio.create_task(self._clock.sleep(patience_s), name="odometry is late")
            try:
                await asyncio.wait({reached, too_late}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                reached.cancel()
                too_late.cancel()
        return self._buffer.at(stamp) if self._newest >= stamp else None

    async def _reached(self, stamp: float) -> None:
        while self._newest < stamp:
            await self._arrived.wait()
