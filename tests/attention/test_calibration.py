"""What was measured on a computer decides what its strategies cost."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.calibration import CostCalibration, CostFit, Point, Relation, load_cost_calibration
from app.attention.strategies import StrategyTable
from app.attention.strategy_file import load_strategies
from app.base.errors import ConfigError

FILE = """\
host: brain
made: 2026-11-21T12:00:00+00:00
relations:
  Eye.images:
    points:
      - {phi: 1, cpu: 4.0005, events: 15}
      - {phi: 4, cpu: 1.5, events: 4}
    cpu: {base: 0.5, slope: 3.5, residual: 0.1}
    events: {base: 0, slope: 15, residual: 0.2}
"""
TABLE = """\
resources:
  cpu: {capacity: 100}
  disk: {capacity: 5}
strategies:
  - {name: one, class: See, utility: 8, filters: {Eye.images: 1, Ear.sound: 1}, costs: {cpu: {calibrated_or: 7}}}
  - {name: two, class: See, utility: 4, filters: {Eye.images: 2}, costs: {cpu: {calibrated_or: 3}, disk: 1}}
  - {name: off, class: See, utility: 1, filters: {Ear.sound: 2}, costs: {cpu: {calibrated_or: 2.5}}}
"""


@pytest.fixture
def calibration(tmp_path: Path) -> CostCalibration:
    (tmp_path / "brain.yaml").write_text(FILE, encoding="utf-8")
    found = load_cost_calibration(tmp_path, "brain")
    assert found is not None
    return found


def table(folder: Path, text: str, calibration: CostCalibration | None) -> StrategyTable:
    file = folder / "table.yaml"
    file.write_text(text, encoding="utf-8")
    return load_strategies([file], classes=["See"], calibration=calibration)


def test_a_calibrated_cost_is_the_measured_one_then_the_lines_then_the_tables(
    tmp_path: Path, calibration: CostCalibration
) -> None:
    costs = [s.costs for s in table(tmp_path, TABLE, calibration).strategies]
    # Rounded up to the thousandth that the solver counts in; φ = 2 was not measured: 0.5 + 3.5 / 2.
    assert costs == [{"cpu": 4.001}, {"cpu": 2.25, "disk": 1}, {"cpu": 2.5}]
    assert [s.costs["cpu"] for s in table(tmp_path, TABLE, None).strategies] == [7, 3, 2.5]


def test_a_computer_that_was_not_calibrated_has_none(tmp_path: Path) -> None:
    assert load_cost_calibration(tmp_path, "other") is None
    assert load_cost_calibration(tmp_path / "nowhere", "other") is None


def test_mistakes_name_file_line_and_what_is_allowed(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"table\.yaml:5: .*calibration measures cpu, not 'disk'"):
        table(tmp_path, TABLE.replace("{cpu: {calibrated_or: 7}}", "{disk: {calibrated_or: 1}}"), None)
    with pytest.raises(ConfigError, match=r"table\.yaml:5: .*decimals"):
        table(tmp_path, TABLE.replace("calibrated_or: 7", "calibrated_or: 7.00001"), None)
    with pytest.raises(ConfigError, match=r"table\.yaml:5: "):
        table(tmp_path, TABLE.replace("calibrated_or: 7", "calibrated: 7"), None)
    (tmp_path / "brain.yaml").write_text(FILE.replace("phi: 4", "phi: 0"), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"brain\.yaml:7: .*phi"):
        load_cost_calibration(tmp_path, "brain")


@given(st.floats(0, 50), st.floats(0, 50), st.lists(st.integers(1, 64), min_size=1, unique=True))
def test_a_cost_is_never_negative_and_agrees_with_what_was_measured(
    base: float, slope: float, divisors: list[int]
) -> None:
    line = CostFit(base=base, slope=slope, residual=0)
    points = tuple(Point(phi=phi, cpu=line.at(phi), events=0) for phi in divisors)
    relation = Relation(points=points, cpu=CostFit(base=-1, slope=0, residual=0), events=line)
    assert all(relation.cost(phi) == line.at(phi) for phi in divisors)
    assert relation.cost(1000) == 0
