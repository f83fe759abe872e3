"""A map made on a tour, and goals given on it by the whole program: the Jackal before its field of cylinders."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.base import paths
from app.base.geometry import Pose2
from app.experiments.goals.goal_run import MAP, GoalRun, work
from app.experiments.goals.result import GoalResult
from app.experiments.goals.tour import make_map

TOUR = """
name: a short tour
drive:
  - {go: [3.0, 2.8]}
"""
PERSON = """
name: somebody stands there
people:
  - {name: one, face: pilot, at: [1.6, 2.6]}
"""


@pytest.mark.slow
def test_goals_are_given_on_a_map_made_before_and_the_truth_is_reported(tmp_path: Path) -> None:
    jackal = paths.config_dir() / "jackal.yaml"
    (tmp_path / "tour.yaml").write_text(TOUR)
    (tmp_path / "person.yaml").write_text(PERSON)
    maps = tmp_path / "maps"
    maps.mkdir()
    legs: list[str] = []
    origin = make_map(jackal, tmp_path / "tour.yaml", maps, legs.append)
    assert legs == ["mapping on a tour, leg 1 of 1"]
    assert (maps / MAP / "map.yaml").is_file()
    assert (origin.x, origin.y) == pytest.approx((3.0, 2.0), abs=0.01)

    near, inside = Pose2(3.6, 3.0, 0.0), Pose2(0.7, 2.0, 0.0)
    run_spec = GoalRun(
        config=jackal,
        scenario=tmp_path / "person.yaml",
        maps=maps,
        origin=origin,
        start=origin,
        goals=((1, near), (2, inside)),
        seed=5,
        cameras=False,
        tolerance_m=0.25,
        tolerance_rad=0.2,
        slack_m=0.05,
        patience_s=12.0,
    )
    results: list[GoalResult] = []
    work(run_spec, results.append)
    reached, not_reached = results
    assert (reached.number, reached.outcome, reached.touched) == (1, "reached", ())
    assert reached.error_m <= 0.3
    assert abs(reached.error_rad) <= 0.25
    assert reached.driven_m >= 0.8
    assert reached.people_m is not None
    assert 0.3 < reached.people_m < 2.0
    assert reached.story
    assert not_reached.outcome != "reached"  # it lies in a wall
    assert not_reached.reason
