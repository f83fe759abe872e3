"""Result of one world, and the challenge's score."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

Outcome = Literal["success", "collision", "timeout", "failed"]
OUTCOMES: tuple[Outcome, ...] = ("success", "collision", "timeout", "failed")


@dataclass(frozen=True, slots=True)
class WorldResult:
    """One crossing. ``time_s`` since the goal was given; ``optimal_s`` is T*, the path's length at full speed.

    ``reason``: the object hit, or the last status of navigation; ``story``: all statuses, with the time (s).
    ``driven_m``: length of the path; ``trace``: time (s), x, y (m) and heading (rad) in the world at 10 Hz. ``wall_s``:
    real time (s).
    """

    world: str
    outcome: Outcome
    time_s: float
    optimal_s: float
    left_m: float
    reason: str
    recoveries: int
    driven_m: float
    wall_s: float
    story: tuple[tuple[float, str], ...] = ()
    trace: tuple[tuple[float, float, float, float], ...] = ()

    @property
    def score(self) -> float:
        """success · T* / clip(T, 2 T*, 8 T*): 0 to 0.5."""
        if self.outcome != "success":
            return 0.0
        return self.optimal_s / min(max(self.time_s, 2 * self.optimal_s), 8 * self.optimal_s)

    def document(self) -> dict[str, Any]:
        return asdict(self) | {"score": round(self.score, 4)}


@dataclass(frozen=True, slots=True)
class BarnSummary:
    """Summary of many worlds: shares in [0, 1], mean time (s) of the successful ones (NaN if none), mean score."""

    worlds: int
    shares: dict[str, float]
    mean_time_s: float
    score: float

    @classmethod
    def of(cls, results: Sequence[WorldResult]) -> BarnSummary:
        """The summary of ``results``."""
        count = len(results)
        times = [result.time_s for result in results if result.outcome == "success"]
        return cls(
            count,
            {o: sum(r.outcome == o for r in results) / count if count else 0.0 for o in OUTCOMES},
            sum(times) / len(times) if times else math.nan,
            sum(result.score for result in results) / count if count else 0.0,
        )

    def document(self) -> dict[str, Any]:
        return asdict(self) | {"mean_time_s": None if math.isnan(self.mean_time_s) else self.mean_time_s}
