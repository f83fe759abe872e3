"""Strategies generated from one entry: the same as if each were in the file, with mistakes reported at their line."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.attention.calibration import CostCalibration, CostFit, Point, Relation
from app.attention.strategies import Strategy, StrategyTable
from app.attention.strategy_file import load_strategies
from app.base.errors import ConfigError

FAMILY = """\
resources:
  cpu: {capacity: 100}
families:
  - names: slam-{phi}
    class: SLAM
    phis: [1, 4, 40]
    utility: {at_1: 8, per_doubling: 1}
    filters: {SLAM2D.scans: phi, SLAM2D.map: off}
    parameters: {SLAM2D: {rays: 3}}
    requires: {Balance: 1}
    costs: {cpu: {calibrated_or: {base: 0.75, slope: 5}}}
"""
SINGLE = """\
resources:
  cpu: {capacity: 100}
strategies:
  - name: slam-4
    class: SLAM
    utility: 6
    filters: {SLAM2D.scans: 4, SLAM2D.map: off}
    parameters: {SLAM2D: {rays: 3}}
    requires: {Balance: 1}
    costs: {cpu: {calibrated_or: 2}}
"""


def load(tmp_path: Path, text: str, calibration: CostCalibration | None = None) -> StrategyTable:
    (tmp_path / "table.yaml").write_text(text)
    ports = {"SLAM2D": ("scans", "map")}
    return load_strategies([tmp_path / "table.yaml"], classes=("SLAM", "Balance"), ports=ports, calibration=calibration)


def without_place(strategy: Strategy) -> tuple[object, ...]:
    return tuple(getattr(strategy, name) for name in Strategy.__dataclass_fields__ if name != "location")


def test_a_member_is_what_would_stand_in_the_file(tmp_path: Path) -> None:
    family = load(tmp_path, FAMILY)
    assert [s.name for s in family.strategies] == ["slam-1", "slam-4", "slam-40"]
    assert without_place(family["slam-4"]) == without_place(load(tmp_path, SINGLE)["slam-4"])
    assert family["slam-40"].utility == pytest.approx(8 - 5.322, abs=1e-9)
    assert [s.costs["cpu"] for s in family.strategies] == [5.75, 2.0, 0.875]
    assert family["slam-4"].location is not None
    assert family["slam-4"].location.line == 4


def test_without_per_doubling_utility_goes_with_the_rate_and_filters_may_be_multiples(tmp_path: Path) -> None:
    text = FAMILY.replace(", per_doubling: 1", "").replace("SLAM2D.map: off", "SLAM2D.map: 3 phi")
    strategies = load(tmp_path, text).strategies
    assert [s.utility for s in strategies] == [8, 2, 0.2]
    assert [s.filters for s in strategies] == [{"SLAM2D.scans": phi, "SLAM2D.map": 3 * phi} for phi in (1, 4, 40)]


def test_what_was_measured_on_this_computer_comes_first(tmp_path: Path) -> None:
    line = CostFit(base=0.5, slope=8.0, residual=0.0)
    relation = Relation(points=(Point(phi=4, cpu=2.25, events=10),), cpu=line, events=line)
    measured = CostCalibration(host="here", made="", relations={"SLAM2D.scans with rays=3": relation})
    costs = [s.costs["cpu"] for s in load(tmp_path, FAMILY, measured).strategies]
    assert costs == [8.5, 2.25, 0.7], "the line, the point, the line"


def test_what_is_not_calibrated_is_given_by_its_line(tmp_path: Path) -> None:
    text = FAMILY.replace("slope: 5}}}", "slope: 5}}, power: {base: 1, slope: 2}}")
    strategies = load(
        tmp_path, text.replace("cpu: {capacity: 100}", "cpu: {capacity: 100}\n  power: {capacity: 9}")
    ).strategies
    assert [s.costs["power"] for s in strategies] == [3.0, 1.5, 1.05]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "per_doubling: 1",
            "per_doubling: 2",
            "strategy 'slam-40': utility: should be greater than 0, not -2.6",
        ),
        ("phis: [1, 4, 40]", "phis: [1, 0]", "greater than or equal to 1"),
        ("phis: [1, 4, 40]", "phis: [4, 4]", "'slam-4' is already declared"),
        (
            "names: slam-{phi}",
            "names: slam",
            "names: should have {phi} in it once, in place of which each strategy's φ is written, not 'slam'",
        ),
        (
            "SLAM2D.scans: phi",
            "SLAM2D.scans: 0 phi",
            "a multiple of it such as 2 phi, an integer of at least 1, or off",
        ),
        ("SLAM2D.scans: phi", "SLAM2D.scans: true", "a multiple of it such as 2 phi, an integer of at least 1, or off"),
        ("class: SLAM", "class: SLAN", "unknown class 'SLAN'"),
        ("slope: 5}", "slope: -5}", "greater than or equal to 0"),
        ("{calibrated_or: {base: 0.75, slope: 5}}", "{base: 0.75, slope: -5}", "greater than or equal to 0"),
    ],
)
def test_mistakes_are_reported_with_their_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(ConfigError) as mistake:
        load(tmp_path, FAMILY.replace(old, new))
    assert words in str(mistake.value)
    assert "table.yaml:" in str(mistake.value)
