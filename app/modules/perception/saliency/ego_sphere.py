"""The ego-sphere: how salient each direction around the head is, feature by feature. Pure.

Each feature has a map on one grid. What was seen or heard there fades exponentially; where it is seen again, the
greater value counts. Saliency is the sum of the maps, weighted with gains, less what is inhibited: a direction that was
looked at is not salient for a while, and recovers (inhibition of return). Gains by motivation: Breazeal and
Scassellati 1999, Kismet; a sphere of several senses: Ruesch et al. 2008.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import azimuth_elevation, unit_vector
from app.modules.perception.saliency.sphere_grid import SphereGrid

Map = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SphereRules:
    """``decay_s`` and ``recovery_s``: time constants of what was perceived, and of inhibition. ``spread_rad``: standard
    deviation of the blur before peaks are sought. ``apart_rad``: two peaks are further from each other than this.
    ``inhibited_rad``: standard deviation of what is inhibited around a direction. ``least``: no peak is below it."""

    decay_s: float = 1.0
    recovery_s: float = 6.0
    spread_rad: float = math.radians(4.0)
    apart_rad: float = math.radians(20.0)
    inhibited_rad: float = math.radians(10.0)
    least: float = 0.05


@dataclass(frozen=True, slots=True)
class Peak:
    """A salient direction (rad, in odom's axes), its ``saliency``, and the ``shares`` of the features, its summands."""

    azimuth: float
    elevation: float
    saliency: float
    shares: Mapping[str, float]


class EgoSphere:
    """The maps of all features on ``grid``, in odom's axes."""

    def __init__(self, grid: SphereGrid, rules: SphereRules | None = None) -> None:
        self.grid = grid
        self.rules = rules or SphereRules()
        self._directions = grid.directions()
        self._stamp = -math.inf
        self._maps: dict[str, Map] = {}
        self._inhibited: Map = self._blank()

    def fade(self, now: float) -> None:
        """Have all fade until ``now`` (s); an earlier time changes nothing."""
        passed = now - self._stamp
        if passed <= 0:
            return
        self._stamp = now
        if math.isinf(passed):
            return
        for values in self._maps.values():
            values *= math.exp(-passed / self.rules.decay_s)
        self._inhibited *= math.exp(-passed / self.rules.recovery_s)

    def add(self, feature: str, values: Map) -> None:
        """What a picture shows of ``feature``: ``values`` (rows, columns) in [0, 1], 0 where it does not reach."""
        self._take(feature, values)

    def add_percept(self, feature: str, v_O: NDArray[np.float64], strength: float, sigma_rad: float) -> None:
        """A percept in the direction ``v_O`` (3,): ``strength`` in its middle, less around it."""
        self._take(feature, strength * self._around(v_O, sigma_rad))

    def inhibit(self, v_O: NDArray[np.float64]) -> None:
        """The direction ``v_O`` (3,) was looked at."""
        self._inhibited = np.maximum(self._inhibited, self._around(v_O, self.rules.inhibited_rad))

    def saliency(self, gains: Mapping[str, float]) -> Map:
        """The weighted sum (rows, columns) of the features, blurred; a feature without a gain counts nothing."""
        return sum(self._weighted(gains).values(), self._blank())

    def peaks(self, gains: Mapping[str, float], most: int = 3) -> tuple[Peak, ...]:
        """The most salient directions, the most salient first: no two near each other, at most ``most``."""
        weighted = self._weighted(gains)
        left = sum(weighted.values(), self._blank())
        found: list[Peak] = []
        while len(found) < most:
            row, column = divmod(int(np.argmax(left)), self.grid.columns)
            saliency = float(left[row, column])
            if saliency < self.rules.least:
                break
            v_O = self._middle(left, row, column)
            shares = {name: float(values[row, column]) for name, values in weighted.items()}
            found.append(Peak(*azimuth_elevation(v_O), saliency=saliency, shares=shares))
            cell_O = unit_vector(float(self.grid.azimuths[column]), float(self.grid.elevations[row]))
            left = np.where(self._directions @ cell_O > math.cos(self.rules.apart_rad), 0.0, left).astype(np.float32)
        return tuple(found)

    def _weighted(self, gains: Mapping[str, float]) -> dict[str, Map]:
        free = 1.0 - self._inhibited
        return {
            name: np.asarray(gain * free * self._blurred(self._maps[name]), np.float32)
            for name, gain in gains.items()
            if gain > 0 and name in self._maps
        }

    def _take(self, feature: str, values: Map) -> None:
        known = self._maps.setdefault(feature, self._blank())
        np.maximum(known, values.astype(np.float32, copy=False), out=known)

    def _around(self, v_O: NDArray[np.float64], sigma_rad: float) -> Map:
        off = np.arccos(np.clip(self._directions @ (v_O / np.linalg.norm(v_O)), -1.0, 1.0))
        return np.exp(-0.5 * (off / sigma_rad) ** 2).astype(np.float32)

    def _blurred(self, values: Map) -> Map:
        sigma = self.rules.spread_rad / self.grid.step_rad
        margin = math.ceil(3 * sigma)
        around = np.concatenate((values[:, -margin:], values, values[:, :margin]), axis=1)
        return np.asarray(cv2.GaussianBlur(around, (0, 0), sigma)[:, margin:-margin], np.float32)

    def _middle(self, values: Map, row: int, column: int) -> NDArray[np.float64]:
        """The mean direction of the cells beside a peak, weighted with their values: finer than a cell."""
        rows = np.arange(max(0, row - 1), min(self.grid.rows, row + 2))
        columns = np.arange(column - 1, column + 2) % self.grid.columns
        near = np.ix_(rows, columns)
        weights = values[near].astype(np.float64)
        # Of a smooth peak the neighbours are nearly as high: what they have more than the least of them counts.
        weights = weights - 0.999 * weights.min()
        mean: NDArray[np.float64] = np.einsum("rc,rcx->x", weights, self._directions[near])
        return mean

    def _blank(self) -> Map:
        return np.zeros((self.grid.rows, self.grid.columns), np.float32)
