"""Pose of the robot at a message's own stamp, awaited until odometry reaches it."""

from __future__ import annotations

import asyncio
import logging

from app.base.geometry import Pose2
from app.base.pose_buffer import PoseBuffer
from app.messages import Odometry
from app.runtime.clock import Clock


class PoseAt:
    """Poses X_OB by stamp: ``add`` each odometry message, ``await at(stamp)`` for the pose at exactly that instant.

    Never the newest or nearest pose instead: between two odometry messages the pose is interpolated. ``log`` gets
    ``lost``, what is lost without a pose, when odometry ceases to reach ``stamps``, and a line when it does again.
    """

    def __init__(
        self,
        clock: Clock,
        log: logging.Logger | None = None,
        lost: str = "",
        stamps: str = "the stamps of the images",
    ) -> None:
        self._clock = clock
        self._log = log
        self._lost = lost
        self._stamps = stamps
        #: Whether odometry did not reach the last stamp of :meth:`logged_at`.
        self.late = False
        self._buffer = PoseBuffer(span_s=10.0, tolerance_s=0.0)
        self._newest = float("-inf")
        #: Set by the next message; None while nothing waits for one.
        self._arrived: asyncio.Event | None = None

    def add(self, odometry: Odometry) -> None:
        """Add a pose and wake the waiting calls of :meth:`at`."""
        self._buffer.add(odometry.stamp, odometry.X_OB)
        self._newest = max(self._newest, odometry.stamp)
        if self._arrived is not None:
            self._arrived.set()
            self._arrived = None

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

    async def logged_at(self, stamp: float, patience_s: float = 0.5) -> Pose2 | None:
        """As :meth:`at`, with a line in the log when odometry ceases or begins to reach the stamps."""
        X_OB = await self.at(stamp, patience_s)
        if (X_OB is None) != self.late and self._log is not None:
            self.late = X_OB is None
            if self.late:
                self._log.warning("%s: odometry does not reach %s", self._lost, self._stamps)
            else:
                self._log.info("odometry reaches %s again", self._stamps)
        return X_OB

    async def _reached(self, stamp: float) -> None:
        while self._newest < stamp:
            self._arrived = self._arrived or asyncio.Event()
            await self._arrived.wait()
