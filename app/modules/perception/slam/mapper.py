"""Slam: scan by scan, where the robot is and what the map is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2
from app.modules.perception.slam.scans import Beams
from app.modules.perception.slam.settings import SlamSettings
from app.modules.perception.slam.values import Keyframe, Match, SlamState


class Outcome(Protocol):
    """What a job found; for :meth:`Slam.take`."""


class Job(Protocol):
    """Work off the critical path: ``run`` may be called in any thread, and touches nothing of the Slam it is from."""

    def run(self) -> Outcome: ...


class Slam:
    """Follows the robot and, unless ``frozen``, maps as it goes. Not to be called from two threads at once.

    The map begins with the robot at ``X_MB``; with ``state``, it is the one that was kept, and the robot is about
    at ``X_MB`` on it. ``frozen``: the map stays as it is, memory too.
    """

    def __init__(
        self,
        settings: SlamSettings | None = None,
        *,
        state: SlamState | None = None,
        X_MB: Pose2 | None = None,
        frozen: bool = False,
    ) -> None: ...

    def add(
        self,
        stamp: float,
        ranges: NDArray[np.float32],
        beams: Beams,
        X_OB: Pose2,
        twist: tuple[float, float] = (0.0, 0.0),
        sweep_s: float = 0.0,
    ) -> Match:
        """Take one sweep, begun at ``stamp`` with the body at ``X_OB`` and moving with ``twist`` (m/s, rad/s)."""
        raise NotImplementedError

    def place(self, X_MB: Pose2) -> None:
        """The robot is about at ``X_MB``: the next scan is matched around there."""

    def pending(self) -> Job | None:
        """Work that is due (loops to look for, a graph to correct); None while one is out, or nothing is due."""
        raise NotImplementedError

    def take(self, outcome: Outcome) -> None:
        """Take over what a job found: quick."""

    @property
    def version(self) -> int:
        """Grows whenever a keyframe is added, removed or moved."""
        raise NotImplementedError

    @property
    def keyframes(self) -> Mapping[int, Keyframe]:
        """All keyframes by id, in the order of their making."""
        raise NotImplementedError

    def pose(self, id: int) -> Pose2:
        """Where keyframe ``id`` is on the map (``X_MK``)."""
        raise NotImplementedError

    def poses(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Ids (N,) and poses (N, 3) x, y, theta on the map of all keyframes, in the order of ``keyframes``."""
        raise NotImplementedError

    def state(self) -> SlamState:
        """What must be kept to go on mapping from here."""
        raise NotImplementedError
