"""The base of a kinematic body: where velocities take it, and what stops it. No clock."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.maps.grid_rays import GridRays
from app.robots import guard
from app.robots.guard import BaseVelocity, GuardAction, GuardLimits, GuardState, VelocityCommand

#: So near one another, two stops are at the same obstacle (m, rad).
_SAME_M, _SAME_RAD = 0.1, 0.3

Discs = Sequence[tuple[float, float, float]]
"""Discs on the floor: x, y, radius (m)."""


def moved(pose: Pose2, velocity: BaseVelocity, seconds: float) -> Pose2:
    """``pose`` after ``seconds`` at a constant ``velocity``: along an arc."""
    turn = velocity.angular_radps * seconds
    way = complex(velocity.linear_mps, velocity.lateral_mps) * seconds
    if abs(turn) > 1e-9:
        way *= cmath.rect(math.sin(turn / 2) / (turn / 2), turn / 2)
    way *= cmath.rect(1.0, pose.theta)
    return Pose2(pose.x + way.real, pose.y + way.imag, wrap_angle(pose.theta + turn))


class Outline:
    """The floor that a footprint (corners in ``base_link``, m, convex, counter-clockwise) covers."""

    def __init__(self, corners: Sequence[tuple[float, float]], spacing_m: float) -> None:
        self._corners = np.array(corners)
        self._edges = np.roll(self._corners, -1, axis=0) - self._corners
        self.radius_m = float(np.hypot(*self._corners.T).max())
        steps = np.arange(-self.radius_m, self.radius_m + spacing_m, spacing_m)
        inner = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        along = [self._edge(number, spacing_m) for number in range(len(self._corners))]
        self._points = np.concatenate((inner[self._depths(inner) >= 0], *along))

    def meets(self, pose: Pose2, rays: GridRays, discs: Discs = ()) -> bool:
        """Whether it covers an obstacle of the map, or part of one of ``discs`` on it, at ``pose`` on the map."""
        if rays.clear_m(pose.x, pose.y) <= self.radius_m and rays.occupied(pose.transform(self._points)).any():
            return True
        near = [disc for disc in discs if math.hypot(disc[0] - pose.x, disc[1] - pose.y) < disc[2] + self.radius_m]
        if not near:
            return False
        middles = pose.inverse().transform(np.array([disc[:2] for disc in near]))
        gaps = np.hypot(*(middles[:, None] - self._points).transpose(2, 0, 1)).min(axis=1)
        return bool((gaps < np.array([disc[2] for disc in near])).any())

    def _edge(self, number: int, spacing_m: float) -> NDArray[np.float64]:
        parts = max(1, math.ceil(float(np.hypot(*self._edges[number])) / spacing_m))
        return np.asarray(self._corners[number] + np.arange(parts)[:, None] / parts * self._edges[number])

    def _depths(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far inside the nearest edge each of ``points`` (N, 2) is (m), negative outside."""
        away = points[:, None] - self._corners
        cross = self._edges[:, 0] * away[..., 1] - self._edges[:, 1] * away[..., 0]
        return np.asarray((cross / np.hypot(*self._edges.T)).min(axis=1))


class KinematicBase:
    """The base at ``pose`` (``X_WB``), with the rules of the guard; ``touches`` counts how often it was stopped by what
    it would have run into."""

    def __init__(self, pose: Pose2, limits: GuardLimits, outline: Outline, rays: GridRays) -> None:
        self.pose = pose
        self.state = GuardState()
        self.action: GuardAction = guard.decide(0.0, self.state, {}, limits)
        self.velocity = guard.ZERO
        self.touches = 0
        self.driven_m = 0.0
        self._limits = limits
        self._outline = outline
        self._rays = rays
        #: Where it was stopped last.
        self._stopped_at: Pose2 | None = None

    def accept(self, command: VelocityCommand) -> None:
        """Take a command."""
        self.state = guard.accept(self.state, command)

    def e_stop(self, reason: str) -> None:
        """Latch the emergency stop."""
        self.state = guard.e_stop(self.state, reason)

    def clear_e_stop(self) -> None:
        """Release it."""
        self.state = guard.clear_e_stop(self.state)

    def step(self, now: float, seconds: float, discs: Discs = ()) -> None:
        """Move for the ``seconds`` until ``now`` (s, robot's clock), with people who stand on ``discs``."""
        self.action = guard.decide(now, self.state, {}, self._limits)
        self.state = guard.step(self.state, self.action, self._limits, seconds)
        self.velocity = self.state.applied
        if self.velocity.is_zero:
            return
        ahead = moved(self.pose, self.velocity, seconds)
        # What covers an obstacle already (a start beside one) may leave it.
        if self._outline.meets(ahead, self._rays, discs) and not self._outline.meets(self.pose, self._rays, discs):
            self.velocity = guard.ZERO
            self.state = replace(self.state, applied=guard.ZERO)
            if self._stopped_at is None:
                self.touches += 1
                self._stopped_at = self.pose
            return
        self.driven_m += math.hypot(ahead.x - self.pose.x, ahead.y - self.pose.y)
        self.pose = ahead
        if self._stopped_at is not None and _apart(self.pose, self._stopped_at):
            self._stopped_at = None


def _apart(a: Pose2, b: Pose2) -> bool:
    return math.hypot(a.x - b.x, a.y - b.y) > _SAME_M or abs(wrap_angle(a.theta - b.theta)) > _SAME_RAD
