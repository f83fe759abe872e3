"""Submaps under construction: two overlap at any time, and scans are matched on the older one (Hess et al. 2016)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.correlative_matching import Pyramid
from app.modules.perception.slam.surfels import SurfelGrid
from app.modules.perception.slam.types import Submap

_PYRAMID_LEVELS = 4


class ActiveSubmap:
    """``keyframes`` by id; the first defines the frame of ``grid``."""

    def __init__(self, grid: SurfelGrid, keyframe: int) -> None:
        self.grid = grid
        self.keyframes = [keyframe]
        self._pyramid: Pyramid | None = None
        self._pyramid_of = 0

    @property
    def first(self) -> int:
        """The keyframe that defines the frame."""
        return self.keyframes[0]

    def add(self, id: int, points: NDArray[np.float32], X_SB: Pose2) -> None:
        """Enter keyframe ``id`` at ``X_SB`` with its ``points``, as of :class:`Keyframe`."""
        self.grid.insert(points, X_SB)
        self.keyframes.append(id)

    def pyramid(self) -> Pyramid:
        """The grid for searches, made again only when a keyframe was added."""
        if self._pyramid is None or self._pyramid_of != len(self.keyframes):
            self._pyramid, self._pyramid_of = Pyramid(self.grid, _PYRAMID_LEVELS), len(self.keyframes)
        return self._pyramid


class SubmapBuilder:
    """``active``: the submaps under construction, the oldest first; ``finished``: all others.

    ``full``: number of keyframes of a finished submap. ``kept``: keyframes, by id, of the submaps of a saved map.
    """

    def __init__(self, full: int, kept: Iterable[tuple[int, ...]] = ()) -> None:
        self._full = full
        self.active: list[ActiveSubmap] = []
        self.finished = [Submap(number, keyframes) for number, keyframes in enumerate(kept)]
        self._made = len(self.finished)

    def begin_on(self, grid: SurfelGrid, keyframe: int) -> None:
        """Go on with ``grid`` alone, in the frame of ``keyframe``; what was under construction is dropped."""
        self.active = [ActiveSubmap(grid, keyframe)]

    def begin_if_due(self, id: int, points: NDArray[np.float32]) -> None:
        """Begin a submap with keyframe ``id`` when the newest is half full; then finish the oldest, if full."""
        if self.active and len(self.active[-1].keyframes) < self._full // 2:
            return
        if len(self.active) == 2:
            if len(self.active[0].keyframes) < self._full:
                return
            self._finish(self.active.pop(0))
        grid = SurfelGrid()
        grid.insert(points, Pose2())
        self.active.append(ActiveSubmap(grid, id))

    def finish(self) -> None:
        """Finish all that are under construction."""
        for submap in self.active:
            self._finish(submap)
        self.active = []

    def replace(self, pruned: Sequence[Submap], known: int) -> None:
        """Put ``pruned`` in the place of the first ``known`` finished submaps."""
        self.finished = [*pruned, *self.finished[known:]]

    def _finish(self, submap: ActiveSubmap) -> None:
        self.finished.append(Submap(self._made, tuple(submap.keyframes)))
        self._made += 1
