"""Results of goals: clearances, summaries, JSON, the table."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.experiments.goals.report import failures, table
from app.experiments.goals.result import GoalResult, GoalsSummary, clearance

SQUARE = ((0.3, -0.2), (0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2))


def went(number: int, **more: object) -> GoalResult:
    result = GoalResult(
        number,
        (1.0, 2.0, 0.5),
        (1.1, 2.0, 0.6),
        "reached",
        10.0,
        3.0,
        4.0,
        0.1,
        0.1,
        0,
        (),
        0.8,
        "",
        ((0.1, "planning"),),
    )
    return replace(result, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("x", "y", "expected"),
    [(1.0, 0.0, 0.7), (0.0, -0.5, 0.3), (0.6, 0.6, 0.5), (0.0, 0.0, -0.2), (0.29, 0.0, -0.01), (0.3, 0.1, 0.0)],
)
def test_clearance_is_to_the_nearest_edge(x: float, y: float, expected: float) -> None:
    assert clearance(SQUARE, x, y, 0.0) == pytest.approx(expected)
    assert clearance(SQUARE, x, y, 0.25) == pytest.approx(expected - 0.25)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0, 6.28))
def test_clearance_turns_with_the_outline(x: float, y: float, angle: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    turned = tuple((c * px - s * py, s * px + c * py) for px, py in SQUARE)
    assert clearance(turned, c * x - s * y, s * x + c * y, 0.1) == pytest.approx(clearance(SQUARE, x, y, 0.1), abs=1e-9)


def test_a_summary_counts_what_matters_and_a_table_reports_it() -> None:
    results = [
        went(1),
        went(2, time_s=30.0, driven_m=8.0, error_m=0.2, people_m=0.3, recoveries=2),
        went(3, outcome="given up", touched=("person0/trunk", "crate3.0"), reason="unreachable: no way"),
        went(4, outcome="missed", people_m=None),
    ]
    summary = GoalsSummary.of(results)
    assert (summary.goals, summary.reached, summary.with_contact, summary.people_touched) == (4, 2, 1, 1)
    assert summary.least_people_m == 0.3
    assert summary.mean_time_s == 20.0
    assert summary.mean_speed_mps == pytest.approx(12.0 / 40.0)
    assert summary.worst_error_m == 0.2
    lines = table(results).splitlines()
    assert "| reached | 2 (50 %) |" in lines
    assert "| not reached: missed | 1 |" in lines
    events = failures(results)
    assert events[0] == "goal 3 at (1.00, 2.00): given up after 10 s, 0.10 m off (unreachable: no way)"
    assert events[1] == "goal 3 at (1.00, 2.00): touched person0/trunk, crate3.0"
    assert len(events) == 3
    assert GoalsSummary.of([went(1, outcome="timeout", people_m=None)]).mean_time_s is None


def test_results_go_to_json_and_back() -> None:
    result = went(7, touched=("a wall",))
    assert msgspec.convert(json.loads(json.dumps(result.document(), allow_nan=False)), GoalResult) == result
