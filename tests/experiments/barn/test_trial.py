"""One world crossed: reached, hit or not reached in time, by a driver that needs no navigation; and the score of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.experiments.barn.result import BarnSummary, WorldResult
from app.experiments.barn.trial import Trial, cross
from app.experiments.barn.worlds import load_worlds
from tests.experiments.barn.conftest import straight_on

JACKAL = paths.config_dir() / "jackal.yaml"


@pytest.mark.slow
def test_a_world_ends_with_the_goal_a_hit_or_its_time(three: Path) -> None:
    reached, hit, late = (cross(Trial(JACKAL, world, 2.0), straight_on) for world in load_worlds(three).worlds)

    assert reached.outcome == "success"
    # 2.5 m to the tolerance, at 1 m/s after 1/4 s of 4 m/s^2
    assert reached.time_s == pytest.approx(2.5 + 0.125, abs=0.15)
    assert reached.optimal_s == 1.5
    assert reached.score == pytest.approx(1.5 / 3.0)  # faster than 2 T*: the most there is
    assert reached.driven_m == pytest.approx(2.5, abs=0.05)
    assert reached.trace[0][1:3] == pytest.approx((0, 0), abs=0.01)
    assert reached.left_m == pytest.approx(0.5, abs=0.05)

    assert hit.outcome == "collision"
    assert "touched cylinder" in hit.reason
    # Its front edge, 0.254 m ahead, is at the post
    assert hit.trace[-1][2] == pytest.approx(1.5 - 0.075 - 0.254, abs=0.03)
    assert hit.score == 0.0

    assert late.outcome == "timeout"
    assert late.time_s == pytest.approx(0.5, abs=0.05)


@pytest.mark.slow
def test_a_crossing_is_the_same_each_time_and_goes_to_json_and_back(three: Path) -> None:
    world = load_worlds(three).worlds[0]
    one, two = (cross(Trial(JACKAL, world, 2.0, seed=3), straight_on) for _ in range(2))
    assert replace(one, wall_s=0) == replace(two, wall_s=0)
    assert msgspec.convert(one.document(), WorldResult) == one


def test_a_setting_of_a_module_that_is_not_there_is_refused(three: Path) -> None:
    world = load_worlds(three).worlds[0]
    with pytest.raises(ConfigError, match="there is no module Nobody"):
        cross(Trial(JACKAL, world, 2.0, overrides={"Nobody": {"controller": "x"}}), straight_on)


def result(outcome: str, time_s: float, optimal_s: float = 5.0) -> WorldResult:
    return WorldResult("1", outcome, time_s, optimal_s, 0.0, "", 0, 0.0, 0.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("time_s", "score"), [(1.0, 0.5), (10.0, 0.5), (20.0, 0.25), (40.0, 0.125), (99.0, 0.125)])
def test_the_score_is_the_challenges(time_s: float, score: float) -> None:
    assert result("success", time_s).score == pytest.approx(score)
    assert result("collision", time_s).score == 0.0


def test_a_summary_counts_all_and_times_successes() -> None:
    summary = BarnSummary.of(
        [result("success", 10.0), result("success", 20.0), result("collision", 3.0), result("timeout", 99.0)]
    )
    assert summary.shares == {"success": 0.5, "collision": 0.25, "timeout": 0.25, "failed": 0.0}
    assert summary.mean_time_s == 15.0
    assert summary.score == pytest.approx((0.5 + 0.25) / 4)
    assert BarnSummary.of([result("timeout", 1.0)]).document()["mean_time_s"] is None
