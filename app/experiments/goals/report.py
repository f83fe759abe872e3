"""The experiment's table, and the reasons of failed goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from app.experiments.goals.result import GoalResult, GoalsSummary


def table(results: Sequence[GoalResult]) -> str:
    s = GoalsSummary.of(results)
    outcomes = Counter(result.outcome for result in results)
    rows = [
        ("goals", str(s.goals)),
        ("reached", f"{s.reached} ({100 * s.reached / max(s.goals, 1):.0f} %)"),
        *((f"not reached: {outcome}", str(count)) for outcome, count in outcomes.items() if outcome != "reached"),
        ("goals on whose way something was touched", str(s.with_contact)),
        ("… of these, people", str(s.people_touched)),
        ("least distance to a person, m", _figure(s.least_people_m)),
        ("mean time of those reached, s", _figure(s.mean_time_s, 1)),
        ("mean speed, m/s", _figure(s.mean_speed_mps)),
        ("recoveries", str(s.recoveries)),
        ("greatest true error of those reached, m", _figure(s.worst_error_m, 3)),
        ("greatest true error of those reached, rad", _figure(s.worst_error_rad, 3)),
    ]
    return "\n".join(["| | |", "|---|---|", *(f"| {what} | {value} |" for what, value in rows)])


def failures(results: Sequence[GoalResult]) -> list[str]:
    """A line for each failed goal, and for each goal with a contact on its way."""
    lines = []
    for result in results:
        x, y, _ = result.goal
        if result.outcome != "reached":
            why = f" ({result.reason})" if result.reason else ""
            lines.append(
                f"goal {result.number} at ({x:.2f}, {y:.2f}): {result.outcome} after {result.time_s:.0f} s, "
                f"{result.error_m:.2f} m off{why}"
            )
        if result.touched:
            lines.append(f"goal {result.number} at ({x:.2f}, {y:.2f}): touched {', '.join(result.touched)}")
    return lines


def _figure(value: float | None, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
