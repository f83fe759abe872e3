"""Geometry of a microphone array, and the directions it can resolve."""

from __future__ import annotations

import itertools
from functools import cached_property
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, model_validator

from app.base.yaml_source import parse

#: Least distance between two microphones (m).
_NEAREST_M = 0.005
#: Greatest size (m): sound must cross the array within a frame.
_FARTHEST_M = 5.0
#: Extents below this share of the largest count as zero.
_FLAT = 0.05


class MicrophoneArray:
    """Microphones at ``positions`` (M, 3) float64, m, x forward, y left, z up; M from 2 to 32.

    ``channels`` (M,): their columns in the sound: 0, 1, ... except in a :meth:`subset`. ``body_m``: radius of the rigid
    body among them, modelled as a sphere about their middle that diffracts sound; 0: free field. Raises ValueError for
    fewer than two, two at one place, or two more than 5 m apart.
    """

    def __init__(
        self, positions: NDArray[np.floating], channels: tuple[int, ...] | None = None, body_m: float = 0.0
    ) -> None:
        placed = np.array(positions, dtype=np.float64)
        if placed.ndim != 2 or placed.shape[1] != 3 or not 2 <= len(placed) <= 32:
            raise ValueError(f"positions are (M, 3) of 2 to 32 microphones, not {placed.shape}")
        placed.flags.writeable = False
        self.positions = placed
        self.channels = tuple(range(len(placed))) if channels is None else channels
        self.body_m = body_m
        self.first, self.second = np.triu_indices(len(placed), 1)
        apart = np.linalg.norm(placed[self.first] - placed[self.second], axis=1)
        if not np.isfinite(placed).all() or apart.min() < _NEAREST_M:
            near = int(apart.argmin())
            raise ValueError(f"microphones {self.first[near]} and {self.second[near]} are at one place")
        if apart.max() > _FARTHEST_M:
            far = int(apart.argmax())
            raise ValueError(
                f"microphones {self.first[far]} and {self.second[far]} are {apart[far]:.4g} m apart, more than "
                f"{_FARTHEST_M:g} m: positions are in metres"
            )

    def __len__(self) -> int:
        return len(self.positions)

    @cached_property
    def middle(self) -> NDArray[np.float64]:
        """The mean of the positions (3,): origin of all directions."""
        return np.asarray(self.positions.mean(axis=0))

    @cached_property
    def offsets(self) -> NDArray[np.float64]:
        """The positions about the middle (M, 3)."""
        return self.positions - self.middle

    @cached_property
    def extents(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """RMS extents (3,) m, largest first, and their axes (3, 3), one unit vector a row."""
        _, sizes, axes = np.linalg.svd(self.offsets)
        full = np.zeros(3)
        full[: len(sizes)] = sizes / np.sqrt(len(self))
        return full, axes

    @property
    def dimensions(self) -> int:
        """1: a line, resolves only the angle to it (a cone); 2: a plane, mirror images are alike; 3: all directions."""
        sizes, _ = self.extents
        return int((sizes > _FLAT * sizes[0]).sum())

    def subset(self, count: int) -> MicrophoneArray:
        """The ``count`` microphones that resolve directions best, with their ``channels``.

        Two: the pair farthest apart from left to right, else the pair nearest to it; among equals the one in front and
        above. More: those spread most evenly over all axes (of a box's corners, four without a common edge); among
        equals the first. Raises ValueError unless 2 <= count <= M.
        """
        if not 2 <= count <= len(self):
            raise ValueError(f"a subset has 2 to {len(self)} microphones, not {count}")
        if count == len(self):
            return self
        chosen = self._best_pair() if count == 2 else self._best_spread(count)
        return MicrophoneArray(
            self.positions[list(chosen)], tuple(self.channels[index] for index in chosen), self.body_m
        )

    def _best_pair(self) -> tuple[int, ...]:
        across = self.positions[self.first] - self.positions[self.second]
        between = (self.positions[self.first] + self.positions[self.second]) / 2
        lateral = np.abs(across[:, 1]) - 2 * np.hypot(across[:, 0], across[:, 2])
        best = np.lexsort((-between[:, 2], -between[:, 0], -np.round(lateral, 6)))[0]
        return int(self.first[best]), int(self.second[best])

    def _best_spread(self, count: int) -> tuple[int, ...]:
        def spread(chosen: tuple[int, ...]) -> tuple[float, ...]:
            placed = self.positions[list(chosen)]
            sizes = np.linalg.svd(placed - placed.mean(axis=0), compute_uv=False)
            return tuple(np.round(np.sort(sizes), 9))

        return max(itertools.combinations(range(len(self)), count), key=spread)


class ArrayConfig(BaseModel, extra="forbid", frozen=True):
    """A file of ``config/arrays``: ``positions``, m, x forward, y left, z up, in any frame, one per channel.

    ``body_m``: see :class:`MicrophoneArray`.
    """

    body_m: Annotated[float, Field(ge=0, le=1)] = 0.0
    positions: Annotated[tuple[tuple[float, float, float], ...], Field(min_length=2, max_length=32)]

    @model_validator(mode="after")
    def _apart(self) -> ArrayConfig:
        MicrophoneArray(np.array(self.positions))
        return self


def load_array(path: Path | str) -> MicrophoneArray:
    """Read ``config/arrays/<name>.yaml``; raises ConfigError (file, line, key)."""
    config = parse(path, ArrayConfig)
    return MicrophoneArray(np.array(config.positions), body_m=config.body_m)
