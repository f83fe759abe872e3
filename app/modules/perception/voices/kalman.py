"""Kalman filter of a direction with constant velocity on the sphere."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class DirectionState:
    """Constant velocity on the sphere; both tangent axes share one covariance (rad^2, rad^2/s, rad^2/s^2)."""

    direction: Vector
    velocity: Vector
    position_variance: float
    covariance: float
    velocity_variance: float

    def ahead(self, seconds: float) -> tuple[Vector, Vector]:
        """Direction and velocity in ``seconds``, along the great circle."""
        return along(self.direction, self.velocity, seconds)

    def predicted(self, seconds: float, jerk: float, rest_s: float = math.inf) -> DirectionState:
        """The state after ``seconds``. ``jerk``: change of the velocity in one second (rad/s, standard deviation,
        random walk); ``rest_s``: time constant with which the velocity decays (inf: constant)."""
        direction, velocity = self.ahead(seconds)
        noise = jerk**2
        keep = math.exp(-seconds / rest_s)
        a, b, c = self.position_variance, self.covariance, self.velocity_variance
        return DirectionState(
            direction,
            velocity * keep,
            a + 2 * seconds * b + seconds**2 * c + noise * seconds**3 / 3,
            b + seconds * c + noise * seconds**2 / 2,
            c + noise * seconds,
        )

    def corrected(self, seen: Vector, variance: float) -> DirectionState:
        """The state after a measured direction of ``variance`` (rad^2) on each tangent axis."""
        offset = seen - (seen @ self.direction) * self.direction
        gain = self.position_variance / (self.position_variance + variance)
        gain_velocity = self.covariance / (self.position_variance + variance)
        direction, velocity = along(self.direction, offset, gain)
        velocity = carried(self.velocity, self.direction, direction) + gain_velocity * carried(
            offset, self.direction, direction
        )
        return DirectionState(
            direction,
            velocity,
            (1 - gain) * self.position_variance,
            (1 - gain) * self.covariance,
            self.velocity_variance - gain_velocity * self.covariance,
        )

    def going_on_as(self, old: DirectionState) -> DirectionState:
        """This direction with the velocity of ``old`` (near by), for a track found again: too few measurements for a
        velocity of its own."""
        velocity = carried(old.velocity, old.direction, self.direction)
        return DirectionState(self.direction, velocity, self.position_variance, 0.0, old.velocity_variance)


def along(direction: Vector, velocity: Vector, seconds: float) -> tuple[Vector, Vector]:
    """Direction and velocity after ``seconds`` along the great circle."""
    pace = math.sqrt(float(velocity @ velocity))
    angle = pace * seconds
    if angle < 1e-9:
        return direction, velocity
    heading = velocity / pace
    moved = math.cos(angle) * direction + math.sin(angle) * heading
    return moved / math.sqrt(float(moved @ moved)), pace * (math.cos(angle) * heading - math.sin(angle) * direction)


def carried(tangent: Vector, old: Vector, new: Vector) -> Vector:
    """``tangent`` at ``old`` as a tangent at ``new``, near by: parallel transport along the great circle."""
    return tangent - (tangent @ new) / (1 + float(old @ new)) * (old + new)


def angle_deg(a: Vector, b: Vector) -> float:
    """The angle between two unit vectors."""
    return math.degrees(math.acos(max(-1.0, min(1.0, float(a @ b)))))


def angular_speed(velocity: Vector) -> float:
    """Norm of ``velocity``, rad/s."""
    return math.sqrt(float(velocity @ velocity))
