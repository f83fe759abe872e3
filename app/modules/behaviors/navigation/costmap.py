"""What stands around the robot just now: a grid that rolls along in ``odom``, from laser and depth (thesis 4.2.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.geometry import Pose2
from app.messages import Image, LaserScan, OccupancyGrid
from app.modules.behaviors.navigation.footprint import Footprint


@dataclass(frozen=True, slots=True)
class CostmapSettings:
    """``size_m`` is the side of what is given out; within ``memory_m`` obstacles are kept, so that what a camera saw
    from afar is still there when it looks over it. ``clear_s`` after the last hit, a ray that passes clears a cell;
    unseen, it is forgotten after ``forget_s``, or ``keep_s`` if it stood there for ``steady_s`` at least. Depth counts
    between ``floor_m`` + ``floor_slope`` * distance above the floor and the body's height, up to ``depth_m`` away, on
    every ``depth_step``-th pixel. With ``drop_m`` an edge counts, beyond which the floor is further below than that.
    """

    size_m: float = 4.0
    memory_m: float = 8.0
    resolution_m: float = 0.025
    clear_s: float = 0.25
    forget_s: float = 3.0
    steady_s: float = 1.0
    keep_s: float = 20.0
    floor_m: float = 0.05
    floor_slope: float = 0.015
    depth_m: float = 4.5
    depth_step: int = 4
    drop_m: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What stands around the robot at ``stamp``, in ``odom``.

    ``cells`` (N, N) int8: -1 never seen, 0 free, 100 occupied. ``distance`` (N, N) float32: m from each cell's middle
    to that of the nearest occupied cell (0 in one), ``size_m`` where there is none. ``origin``: x, y (m) of the lower
    left corner, of cell [0, 0].
    """

    stamp: float
    origin: tuple[float, float]
    resolution_m: float
    cells: NDArray[np.int8]
    distance: NDArray[np.float32]

    def to_message(self, version: int) -> OccupancyGrid:
        """As a message in ``odom``."""
        raise NotImplementedError


class LocalCostmap:
    """Remembers obstacles around the robot. Not for two threads at once; every method computes for at most a few ms."""

    def __init__(self, footprint: Footprint, height_m: float, settings: CostmapSettings | None = None) -> None:
        raise NotImplementedError

    def add_scan(self, scan: LaserScan, X_OB: Pose2, X_OB_end: Pose2 | None = None) -> None:
        """Mark and clear by a scan. ``X_OB``: the robot at its stamp; ``X_OB_end`` when its last ray was measured
        (default: the same), between which each ray is placed."""
        raise NotImplementedError

    def add_depth(self, image: Image, X_OB: Pose2) -> None:
        """Mark and clear by a depth picture, ``X_OB`` being the robot at its stamp. Raises ValueError without depth."""
        raise NotImplementedError

    def around(self, X_OB: Pose2, stamp: float) -> Surroundings:
        """What stands around the robot now, the window's middle within a cell of ``X_OB``."""
        raise NotImplementedError

    def clear(self) -> None:
        """Forget everything: a recovery."""
        raise NotImplementedError
