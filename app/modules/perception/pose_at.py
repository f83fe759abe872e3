"""The robot's pose at a message's own stamp, awaited if odometry has not come that far yet."""

from __future__ import annotations

import asyncio

from app.geometry import Pose2
from app.messages import Odometry
from app.pose_buffer import PoseBuffer


class PoseAt:
    """Poses X_OB by stamp: ``add`` each odometry message, ``await at(stamp)`` for the pose of that very instant.

    Never the pose of another instant: not the newest, not the nearest. Between two odometry messages the pose is
    interpolated.
    """

    def __init__(self, span_s: float = 10.0) -> None:
        self._buffer = PoseBuffer(span_s, tolerance_s=0.0)
        self._newest = float("-inf")
        self._arrived = asyncio.Event()

    def add(self, odometry: Odometry) -> None:
        """Remember a pose and wake whoever waits for it."""
        self._buffer.add(odometry.stamp, odometry.X_OB)
        self._newest = max(self._newest, odometry.stamp)
        arrived, self._arrived = self._arrived, asyncio.Event()
        arrived.set()

    async def at(self, stamp: float, patience_s: float = 0.5) -> Pose2 | None:
        """X_OB at ``stamp``; None if odometry did not reach it within ``patience_s``, or begins later than it."""
        try:
            async with asyncio.timeout(patience_s):
                while self._newest < stamp:
                    await self._arrived.wait()
        except TimeoutError:
            return None
        return self._buffer.at(stamp)
