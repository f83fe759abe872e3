"""Costs by what is measured: right where the work is a line, bounded, and deaf to a single strange window."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.attention.cost_estimation import CostEstimator, Work
from app.attention.strategies import CLOSED, Strategy


def eyes(phi: int, cost: float, *, fine: bool = True) -> Strategy:
    name = f"{'fine' if fine else 'coarse'}-{phi}"
    return Strategy(name, "See", 8 / phi, {}, {"Eye.images": phi}, {"Eye": {"fine": fine}}, {"cpu": cost})


TABLE = (
    *(eyes(phi, 16 / phi) for phi in (1, 2, 4)),
    *(eyes(phi, 8 / phi, fine=False) for phi in (1, 2)),
    Strategy("walk", "Walk", 8, {}, {"Legs.scans": 4, "Eye.shut": CLOSED}, {}, {"cpu": 5}),
    Strategy("free", "Free", 8, {}, {"Hand.twist": 1}, {}, {"cpu": 0}),
)


def fed(windows: int, name: str, cpu: Mapping[str, float], taken: Mapping[str, float] | None = None) -> CostEstimator:
    estimator = CostEstimator(TABLE, most=5)
    for _ in range(windows):
        estimator.take({name}, Work(cpu, taken or {}), 1.0)
    return estimator


def test_before_anything_is_measured_costs_are_as_declared() -> None:
    assert CostEstimator(TABLE, most=5).costs() == {s.name: s.costs["cpu"] for s in TABLE if s.costs["cpu"]}


def test_one_window_says_most_of_a_first_measurement_and_it_holds_at_every_phi() -> None:
    costs = fed(1, "fine-2", {"Eye": 24.0}).costs()
    assert costs["fine-2"] == pytest.approx(24, rel=0.1)
    assert costs["fine-1"] == pytest.approx(48, rel=0.15)
    assert costs["coarse-1"] == pytest.approx(24, rel=0.2), "the same module, with other parameters"
    assert costs["walk"] == 5, "another module"


def test_a_line_with_a_base_is_found_from_two_phis() -> None:
    estimator = CostEstimator(TABLE, most=5)
    for _ in range(30):  # 10 + 20 / φ
        for name, cpu in (("fine-1", 30.0), ("fine-4", 15.0)):
            estimator.take({name}, Work({"Eye": cpu}, {}), 1.0)
    costs = estimator.costs()
    assert [costs["fine-1"], costs["fine-2"], costs["fine-4"]] == pytest.approx([30, 20, 15], rel=0.05)


def test_work_that_was_not_done_is_not_taken_for_cheap() -> None:
    """Half of the messages came, and cost half."""
    assert fed(5, "fine-2", {"Eye": 4.0}, {"Eye.images": 0.25}).costs()["fine-2"] == pytest.approx(8, rel=0.1)
    assert fed(5, "fine-2", {"Eye": 0.1}, {"Eye.images": 0.0}).costs()["fine-2"] == 8, "it had nothing to do"


def test_one_strange_window_hardly_matters_and_two_are_a_change() -> None:
    estimator = fed(30, "fine-2", {"Eye": 8.0})
    estimator.take({"fine-2"}, Work({"Eye": 80.0}, {}), 1.0)
    assert estimator.costs()["fine-2"] < 10
    assert estimator.suspects
    estimator.take({"fine-2"}, Work({"Eye": 30.0}, {}), 1.0)
    assert estimator.costs()["fine-2"] > 25


def test_a_window_in_which_the_strategy_changed_says_nothing() -> None:
    estimator = CostEstimator(TABLE, most=5)
    estimator.take(set(), Work({"Eye": 24.0}, {}), 1.0, {"fine-1", "fine-2"})
    assert estimator.costs()["fine-2"] == 8
    assert estimator.measured() == {}


def test_what_is_not_at_work_is_slowly_tried_again() -> None:
    estimator = fed(10, "fine-1", {"Eye": 48.0})
    for _ in range(1200):
        estimator.take(set(), Work({}, {}), 1.0)
    assert 16 < estimator.costs()["fine-1"] < 22


def test_where_everything_is_dearer_what_was_never_measured_is_too() -> None:
    many = [Strategy(f"s{n}", f"C{n}", 8, {}, {f"M{n}.x": 1}, {}, {"cpu": 4}) for n in range(8)]
    estimator = CostEstimator(many, most=5)
    measured = {s.name for s in many[:6]}
    estimator.take(measured, Work({f"M{n}": 12.0 for n in range(6)}, {}), 1.0)
    assert estimator.costs()["s7"] == pytest.approx(12, rel=0.1)


def test_measured_cpu_is_of_those_at_work() -> None:
    estimator = fed(1, "fine-2", {"Eye": 24.0, "Legs": 3.0})
    assert estimator.measured() == {"fine-2": 24.0}
    assert estimator.used() == 24.0


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from([s.name for s in TABLE]), st.floats(0, 1000)), max_size=30))
def test_no_measurement_takes_a_cost_out_of_its_bounds(windows: list[tuple[str, float]]) -> None:
    estimator = CostEstimator(TABLE, most=5)
    for name, cpu in windows:
        estimator.take({name}, Work({"Eye": cpu, "Legs": cpu}, {}), 0.5)
    declared = {s.name: s.costs["cpu"] for s in TABLE}
    assert all(declared[n] / 5 - 1e-9 <= cost <= 5 * declared[n] + 1e-9 for n, cost in estimator.costs().items())


def test_a_bound_below_one_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        CostEstimator(TABLE, most=0.5)
