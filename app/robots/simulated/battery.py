"""The simulated battery: energy drawn by what runs, and put in by a charger.

Its voltage without a load rises linearly with the charge; the current follows from the power and the inner resistance.
An empty battery stays at 0 and switches nothing off.
"""

from __future__ import annotations

import math

from app.messages import BatteryState
from app.robots.battery_config import BatteryConfig

MEAN_S = 60.0
"""Time constant (s) of the mean power that the remaining time follows from."""


class Battery:
    """A battery at the charge that ``config`` begins with."""

    def __init__(self, config: BatteryConfig) -> None:
        self._config = config
        self._capacity_j = 3600.0 * config.capacity_wh
        self.charge = config.charge
        self.charging = False
        #: Into the battery, W, in the last step, and its mean.
        self._power_w = 0.0
        self._mean_w: float | None = None

    def advance(self, seconds: float, load_w: float, *, charging: bool) -> None:
        """Draw ``load_w`` for ``seconds``; ``charging``: the charger supplies its power meanwhile."""
        supplied_w = self._config.charger_w if charging else 0.0
        power_w = supplied_w - load_w
        before = self.charge
        self.charge = min(max(before + power_w * seconds / self._capacity_j, 0.0), 1.0)
        # What a full battery cannot take, and an empty one cannot give, does not flow.
        self._power_w = (self.charge - before) * self._capacity_j / seconds
        if charging != self.charging or self._mean_w is None:
            self._mean_w = power_w
        else:
            self._mean_w += (power_w - self._mean_w) * min(1.0, seconds / MEAN_S)
        self.charging = charging

    def state(self, stamp: float) -> BatteryState:
        """The message at ``stamp`` (s, robot's clock)."""
        config = self._config
        open_v = config.empty_v + self.charge * (config.full_v - config.empty_v)
        current_a = _current(self._power_w, open_v, config.resistance_ohm)
        return BatteryState(
            stamp,
            charge=self.charge,
            voltage_v=open_v + current_a * config.resistance_ohm,
            current_a=current_a,
            charging=self.charging,
            remaining_s=self._remaining_s(),
        )

    def _remaining_s(self) -> float | None:
        mean_w = self._mean_w or 0.0
        if mean_w < 0:
            return self.charge * self._capacity_j / -mean_w
        if mean_w > 0 and self.charge < 1.0:
            return (1.0 - self.charge) * self._capacity_j / mean_w
        return None


def _current(power_w: float, open_v: float, resistance_ohm: float) -> float:
    """The current (A) into a battery that takes ``power_w`` at its terminals: of (V + R I) I = P the root near P / V.

    A load beyond what the battery can give draws the current of its greatest power.
    """
    if resistance_ohm == 0.0:
        return power_w / open_v
    root = math.sqrt(max(open_v**2 + 4 * resistance_ohm * power_w, 0.0))
    return (root - open_v) / (2 * resistance_ohm)
