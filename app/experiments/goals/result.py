"""Results of one goal, and of many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

Outcome = Literal["reached", "missed", "given up", "timeout"]
"""``missed``: the robot reported arrival at another place."""


@dataclass(frozen=True, slots=True)
class GoalResult:
    """One goal: ``goal`` and ``end`` are x, y (m) and heading (rad) in the world, by ground truth. ``error_m``,
    ``error_rad``: distance of the end from the goal. ``touched``: objects touched on the way; ``people_m``: least
    distance from the robot's outline to a person's trunk. ``left_m``: straight distance from the start to the goal.
    ``reason``: last status of navigation for a goal that was not reached.
    """

    number: int
    goal: tuple[float, float, float]
    end: tuple[float, float, float]
    outcome: Outcome
    time_s: float
    straight_m: float
    driven_m: float
    error_m: float
    error_rad: float
    recoveries: int
    touched: tuple[str, ...]
    people_m: float | None
    reason: str
    story: tuple[tuple[float, str], ...] = ()

    def document(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True, slots=True)
class GoalsSummary:
    """Summary of many goals. ``with_contact``: number of goals with a contact on the way; times are of the reached
    goals."""

    goals: int
    reached: int
    with_contact: int
    people_touched: int
    least_people_m: float | None
    mean_time_s: float | None
    mean_speed_mps: float | None
    recoveries: int
    worst_error_m: float | None
    worst_error_rad: float | None

    @classmethod
    def of(cls, results: Sequence[GoalResult]) -> GoalsSummary:
        """The summary of ``results``."""
        reached = [result for result in results if result.outcome == "reached"]
        people = [result.people_m for result in results if result.people_m is not None]
        time_s = sum(result.time_s for result in reached)
        return cls(
            goals=len(results),
            reached=len(reached),
            with_contact=sum(bool(result.touched) for result in results),
            people_touched=sum(any(what.startswith("person") for what in result.touched) for result in results),
            least_people_m=min(people, default=None),
            mean_time_s=time_s / len(reached) if reached else None,
            mean_speed_mps=sum(r.driven_m for r in reached) / time_s if time_s > 0 else None,
            recoveries=sum(result.recoveries for result in results),
            worst_error_m=max((result.error_m for result in reached), default=None),
            worst_error_rad=max((abs(result.error_rad) for result in reached), default=None),
        )

    def document(self) -> dict[str, Any]:
        return asdict(self)


def clearance(outline: Sequence[tuple[float, float]], x: float, y: float, radius_m: float) -> float:
    """Distance (m) from a convex ``outline`` (counter-clockwise, m) to a disc at (``x``, ``y``), negative where they
    overlap."""
    inside, least = True, math.inf
    for (ax, ay), (bx, by) in zip(outline, (*outline[1:], outline[0]), strict=True):
        ex, ey, px, py = bx - ax, by - ay, x - ax, y - ay
        inside = inside and ex * py - ey * px >= 0
        along = min(max((px * ex + py * ey) / (ex * ex + ey * ey), 0.0), 1.0)
        least = min(least, math.hypot(px - along * ex, py - along * ey))
    return (-least if inside else least) - radius_m
