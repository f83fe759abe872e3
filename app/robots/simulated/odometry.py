"""Wheel odometry with realistic errors: from encoders, with wheels that differ from their nominal geometry.

For a differential drive with travels d_l and d_r of the wheels and track b: distance d = (d_l + d_r) / 2, turn
a = (d_r - d_l) / b, pose advanced along the arc's chord (Siegwart and Nourbakhsh, *Autonomous Mobile Robots*, 5.2.4).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from numpy.random import Generator

from app.base.geometry import Pose2
from app.robots.config import BaseConfig

SLIP_LENGTH_M = 0.5
"""Correlation length of a wheel's slip (m)."""
TWIST_STEPS = 4
"""Number of readings averaged for the measured twist: one encoder tick in one period would be 8 mm/s."""


@dataclass(frozen=True, slots=True)
class TrueBase:
    """True geometry of the wheels: radii and track (m)."""

    left_radius_m: float
    right_radius_m: float
    track_m: float


def draw_true_base(config: BaseConfig, rng: Generator) -> TrueBase:
    """A base that differs from its nominal values by random errors as configured."""
    left, right, track = (float(x) for x in rng.standard_normal(3).clip(-2, 2))
    return TrueBase(
        config.wheel_radius_m * (1 + config.radius_error * left),
        config.wheel_radius_m * (1 + config.radius_error * right),
        config.track_m * (1 + config.track_error * track),
    )


class EncoderOdometry:
    """Integrates encoder readings with the *nominal* geometry; starts at (0, 0, 0) in ``odom``."""

    def __init__(self, config: BaseConfig, rng: Generator) -> None:
        self._config = config
        self._rng = rng
        self._tick_rad = 2 * math.pi / config.encoder_ticks
        self._last: tuple[float, float] | None = None
        self._slip = [0.0, 0.0]
        self._recent: deque[tuple[float, float, float]] = deque(maxlen=TWIST_STEPS)
        self.X_OB = Pose2()
        self.linear_mps = 0.0
        self.angular_radps = 0.0

    def update(self, left_rad: float, right_rad: float, dt_s: float) -> None:
        """Take the true wheel angles (rad, unwrapped) ``dt_s`` after the last call; sets pose and measured twist."""
        reading = (self._read(left_rad), self._read(right_rad))
        if self._last is None:
            self._last = reading
            return
        left = self._slipped(0, (reading[0] - self._last[0]) * self._config.wheel_radius_m)
        right = self._slipped(1, (reading[1] - self._last[1]) * self._config.wheel_radius_m)
        self._last = reading
        distance, turn = (left + right) / 2, (right - left) / self._config.track_m
        heading = self.X_OB.theta + turn / 2
        self.X_OB = Pose2(
            self.X_OB.x + distance * math.cos(heading), self.X_OB.y + distance * math.sin(heading), 0.0
        ) @ Pose2(theta=self.X_OB.theta + turn)
        self._recent.append((distance, turn, dt_s))
        span = sum(step[2] for step in self._recent)
        if span > 0:
            self.linear_mps = sum(step[0] for step in self._recent) / span
            self.angular_radps = sum(step[1] for step in self._recent) / span

    def _read(self, angle: float) -> float:
        return math.floor(angle / self._tick_rad) * self._tick_rad

    def _slipped(self, wheel: int, travel: float) -> float:
        """``travel`` with slip: the slip ratio is a random process over the distance rolled."""
        share = min(abs(travel) / SLIP_LENGTH_M, 1.0)
        kick = self._config.slip * math.sqrt(2 * share) * float(self._rng.standard_normal())
        self._slip[wheel] += kick - share * self._slip[wheel]
        return travel * (1 + self._slip[wheel])
