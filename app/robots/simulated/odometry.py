"""Wheel odometry with realistic errors: from encoders, with wheels that differ from their nominal geometry.

For a differential drive with travels d_l and d_r of the wheels and track b: distance d = (d_l + d_r) / 2, turn
a = (d_r - d_l) / b, pose advanced along the arc's chord (Siegwart and Nourbakhsh, *Autonomous Mobile Robots*, 5.2.4).
A holonomic drive measures its travel in the plane and its turn, each with errors of its own.
"""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import dataclass

from numpy.random import Generator

from app.base.geometry import Pose2
from app.robots.stream_config import BaseConfig

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


class _Integration:
    """Pose and twist from travels: starts at (0, 0, 0) in ``odom``."""

    def __init__(self, config: BaseConfig, rng: Generator) -> None:
        self._config = config
        self._rng = rng
        self._slip = [0.0, 0.0]
        self._recent: deque[tuple[complex, float, float]] = deque(maxlen=TWIST_STEPS)
        self.X_OB = Pose2()
        self.linear_mps = 0.0
        self.angular_radps = 0.0
        self.lateral_mps = 0.0

    def _advance(self, travel: complex, turn: float, dt_s: float) -> None:
        """Add ``travel`` (m, forward + i sideways) along the chord of a ``turn`` (rad) within ``dt_s``."""
        step = travel * cmath.rect(1.0, self.X_OB.theta + turn / 2)
        self.X_OB = Pose2(self.X_OB.x + step.real, self.X_OB.y + step.imag, 0.0) @ Pose2(theta=self.X_OB.theta + turn)
        self._recent.append((travel, turn, dt_s))
        span = sum(recent[2] for recent in self._recent)
        if span > 0:
            velocity = sum((recent[0] for recent in self._recent), 0j) / span
            self.linear_mps, self.lateral_mps = velocity.real, velocity.imag
            self.angular_radps = sum(recent[1] for recent in self._recent) / span

    def _slipped(self, wheel: int, travel: float) -> float:
        """``travel`` with slip: the slip ratio is a random process over the distance rolled."""
        share = min(abs(travel) / SLIP_LENGTH_M, 1.0)
        kick = self._config.slip * math.sqrt(2 * share) * float(self._rng.standard_normal())
        self._slip[wheel] += kick - share * self._slip[wheel]
        return travel * (1 + self._slip[wheel])


class EncoderOdometry(_Integration):
    """Integrates encoder readings of a differential drive with the *nominal* geometry."""

    def __init__(self, config: BaseConfig, rng: Generator) -> None:
        super().__init__(config, rng)
        self._tick_rad = 2 * math.pi / config.encoder_ticks
        self._last: tuple[float, float] | None = None

    def update(self, left_rad: float, right_rad: float, dt_s: float) -> None:
        """Take the true wheel angles (rad, unwrapped) ``dt_s`` after the last call; sets pose and measured twist."""
        reading = (self._read(left_rad), self._read(right_rad))
        if self._last is None:
            self._last = reading
            return
        left = self._slipped(0, (reading[0] - self._last[0]) * self._config.wheel_radius_m)
        right = self._slipped(1, (reading[1] - self._last[1]) * self._config.wheel_radius_m)
        self._last = reading
        self._advance((left + right) / 2, (right - left) / self._config.track_m, dt_s)

    def _read(self, angle: float) -> float:
        return math.floor(angle / self._tick_rad) * self._tick_rad


class HolonomicOdometry(_Integration):
    """Integrates the measured motion of a base that moves freely in the plane.

    Its length and its turn are measured wrong by the same share throughout (``radius_error`` and ``track_error``, drawn
    once), and both parts of the travel slip as wheels do.
    """

    def __init__(self, config: BaseConfig, rng: Generator) -> None:
        super().__init__(config, rng)
        length, turn = (float(error) for error in rng.standard_normal(2).clip(-2, 2))
        self._length, self._turn = 1 + config.radius_error * length, 1 + config.track_error * turn
        self._last: Pose2 | None = None

    def update(self, X_WB: Pose2, dt_s: float) -> None:
        """Take the true pose ``dt_s`` after the last call; sets pose and measured twist."""
        last, self._last = self._last, X_WB
        if last is None:
            return
        step = last.inverse() @ X_WB
        travel = complex(step.x, step.y) * cmath.rect(self._length, -step.theta / 2)
        slipped = complex(self._slipped(0, travel.real), self._slipped(1, travel.imag))
        self._advance(slipped, step.theta * self._turn, dt_s)
