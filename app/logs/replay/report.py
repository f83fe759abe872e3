"""The report of a replay: messages of each channel, cost of each module, intentions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, slots=True)
class ReplayedChannel:
    """``messages`` published on a channel, and their ``MessageHash`` in hexadecimal ("" without one)."""

    messages: int
    digest: str


@dataclass(frozen=True, slots=True)
class InputReport:
    """A module's input: the ``channel`` it takes from, φ at the end, and counters as a subscription has them."""

    channel: str
    divisor: float
    received: int
    passed: int
    taken: int
    dropped: int


@dataclass(frozen=True, slots=True)
class ReplayedModule:
    """``cpu_s``: thread CPU time (s) charged to the module during the log; ``outputs``: messages published by output
    port; ``restarts``: number of failures."""

    cpu_s: float
    inputs: Mapping[str, InputReport]
    outputs: Mapping[str, int]
    restarts: int


@dataclass(frozen=True, slots=True)
class IntentionLine:
    """One intention as it was put in force: ``stamp`` (robot's clock, s), ``divisors`` of every attended filter."""

    stamp: float
    strategies: tuple[str, ...]
    fulfilled: tuple[str, ...]
    relaxed: tuple[str, ...]
    omega: float
    divisors: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class ReplaySummary:
    """A replay from ``begin`` to ``end`` (robot's clock, s).

    ``delivered``: messages of the log that had a receiver. ``channels``: every output of a module, and attention's own
    records. ``wall_s`` and ``cpu_s``: real time and CPU time of the process for ``log_s`` of the log.
    """

    file: Path
    format: str
    begin: float
    end: float
    delivered: int
    channels: Mapping[str, ReplayedChannel]
    modules: Mapping[str, ReplayedModule]
    intentions: tuple[IntentionLine, ...]
    notes: tuple[str, ...]
    wall_s: float
    cpu_s: float
    #: Name of the replay's own recording; "" without one.
    recorded: str = ""

    @property
    def log_s(self) -> float:
        """Seconds of the log that were replayed."""
        return self.end - self.begin

    @property
    def times_real_time(self) -> float:
        """Speed relative to real time."""
        return self.log_s / self.wall_s if self.wall_s > 0 else math.inf

    def outcome(self) -> dict[str, Any]:
        """Everything that must be equal in two replays of one log, without times of this computer."""
        whole = asdict(self)
        for name in ("file", "format", "wall_s", "cpu_s", "recorded"):
            del whole[name]
        for module in whole["modules"].values():
            del module["cpu_s"]
        return whole

    def document(self) -> dict[str, Any]:
        """The result, the file, and the cost, of what JSON has; the φ of a closed filter is infinite."""
        cost = {
            "wall_s": round(self.wall_s, 3),
            "cpu_s": round(self.cpu_s, 3),
            "times_real_time": round(self.times_real_time, 2),
            "modules": {name: round(module.cpu_s, 6) for name, module in self.modules.items()},
        }
        whole = {"file": str(self.file), "format": self.format, **self.outcome()}
        return {**whole, "recorded": self.recorded or None, "cost": cost}
