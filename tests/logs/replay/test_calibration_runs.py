"""The plan of runs, the lines through their results, and taking up what was interrupted."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.calibration import CostCalibration
from app.attention.strategies import CLOSED, Strategy, StrategyTable
from app.logs.replay.calibration_plot import plot
from app.logs.replay.calibration_runs import CalibrationProgress, Measurement, Run, fit, measure_all, plan, relations

TABLE = StrategyTable(
    (
        Strategy("one", "See", 8, filters={"Eye.images": 1, "Hand.twist": 1}),
        Strategy("four", "See", 2, filters={"Eye.images": 4}),
        Strategy("again", "Look", 2, filters={"Eye.images": 4, "Ear.sound": 2}),
        Strategy("shut", "Rest", 1, filters={"Eye.images": CLOSED}),
    ),
    {},
)


def test_each_filtered_input_is_measured_at_each_of_its_divisors() -> None:
    inputs = {"Eye": ["images", "odometry"], "Hand": ["operator"]}
    assert plan(TABLE, inputs) == [Run("Eye", "images", 1), Run("Eye", "images", 4)]
    every = plan(TABLE, inputs, every_offset=True)
    assert [(run.phi, run.offset) for run in every] == [(1, 0), (4, 0), (4, 1), (4, 2), (4, 3)]
    twice = plan(TABLE, inputs, repeats=2)
    assert [(run.phi, run.repeat) for run in twice] == [(1, 0), (4, 0), (1, 1), (4, 1)]


def test_each_set_of_parameters_is_measured_by_itself() -> None:
    table = StrategyTable(
        (
            Strategy("two", "Hear", 4, filters={"Ear.sound": 1}, parameters={"Ear": {"microphones": 2}}),
            Strategy("eight", "Hear", 8, filters={"Ear.sound": 1}, parameters={"Ear": {"microphones": 8}}),
        ),
        {},
    )
    runs = plan(table, {"Ear": ["sound"]})
    assert [run.relation for run in runs] == ["Ear.sound with microphones=2", "Ear.sound with microphones=8"]
    results = {run: Measurement(0.6 * (number + 1), 60, 60) for number, run in enumerate(runs)}
    calibration = CostCalibration(host="here", made="now", relations=relations(results))
    costs = [calibration.cost(s.filters, s.parameters) for s in table.strategies]
    assert costs == [1.0, 2.0]
    assert calibration.cost({"Ear.sound": 1}) is None


def test_a_sweep_asks_for_its_own_divisors_alone() -> None:
    runs = plan(TABLE, {"Eye": ["images"], "Ear": ["sound"]}, sweep={"Eye.images": range(2, 5), "Nose.smell": [1]})
    assert runs == [Run("Eye", "images", phi) for phi in (2, 3, 4)]


@given(
    st.floats(-5, 50, allow_nan=False),
    st.floats(0, 50),
    st.lists(st.integers(1, 64), min_size=2, max_size=8, unique=True),
)
def test_points_on_a_line_give_that_line(base: float, slope: float, divisors: list[int]) -> None:
    found = fit((phi, base + slope / phi) for phi in divisors)
    assert found.residual == pytest.approx(0, abs=1e-4)
    assert all(found.at(phi) == pytest.approx(base + slope / phi, abs=1e-3) for phi in divisors)


def test_one_divisor_alone_is_taken_as_proportional() -> None:
    assert (fit([(2, 3.0)]).base, fit([(2, 3.0)]).slope) == (0, 6)


def test_one_busy_moment_does_not_move_a_point_but_its_spread_is_reported() -> None:
    found = relations(
        {
            Run("Eye", "images", 1): Measurement(2.4, 600, 60),
            Run("Eye", "images", 4, 0): Measurement(0.9, 150, 60),
            Run("Eye", "images", 4, 1): Measurement(0.6, 120, 60),
            Run("Eye", "images", 4, 1, 1): Measurement(6.0, 120, 60),
        }
    )["Eye.images"]
    assert [(p.phi, p.cpu, p.events, p.runs, p.cpu_spread) for p in found.points] == [
        (1, 4.0, 10.0, 1, 0.0),
        (4, 1.5, 2.1667, 3, 9.0),
    ]
    assert found.cost(2) == pytest.approx(found.cpu.at(2))


def test_what_was_interrupted_goes_on_where_it_was(tmp_path: Path) -> None:
    runs = plan(TABLE, {"Eye": ["images"], "Ear": ["sound"]}, every_offset=True)
    made: list[Run] = []

    def measure(batch: Sequence[Run]) -> list[Measurement]:
        if len(made) == 4:
            raise KeyboardInterrupt
        made.extend(batch)
        return [Measurement(1 / run.phi, run.offset, 60) for run in batch]

    def pairs(of: Sequence[Run]) -> list[Sequence[Run]]:
        return [of[at : at + 2] for at in range(0, len(of), 2)]

    path = tmp_path / "cache" / "brain.json"
    with pytest.raises(KeyboardInterrupt):
        measure_all(runs, measure, CalibrationProgress(path, {"log": "a"}), pairs)
    later = CalibrationProgress(path, {"log": "a"})
    assert later.load() == 4
    done = list(made)
    made.clear()
    results = measure_all(runs[:7], measure, later, pairs)
    assert made == runs[4:7]
    assert done == runs[:4]
    assert list(results) == runs[:7]
    assert results[runs[0]] == Measurement(1 / runs[0].phi, runs[0].offset, 60)
    later.discard()
    assert not path.exists()


@pytest.mark.parametrize("content", ["", "{", '{"key": {"log": "b"}, "results": []}', '{"key": {"log": "a"}}'])
def test_results_of_something_else_are_not_taken(tmp_path: Path, content: str) -> None:
    path = tmp_path / "brain.json"
    path.write_text(content, encoding="utf-8")
    assert CalibrationProgress(path, {"log": "a"}).load() == 0


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_a_calibration_is_drawn(tmp_path: Path, suffix: str) -> None:
    found = relations({Run("Eye", "images", phi): Measurement(2.0 / phi + 0.1, 900 // phi, 60) for phi in (1, 2, 4, 8)})
    path = tmp_path / f"brain.{suffix}"
    plot(CostCalibration(host="brain", made="2026-11-21", relations=found), path)
    assert path.stat().st_size > 10_000
