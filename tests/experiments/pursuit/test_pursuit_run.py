"""A short course in the lab, driven by the program's own way of commands over a link with delay."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from app.base import paths
from app.base.geometry import Pose2
from app.experiments.pursuit.courses import Course
from app.experiments.pursuit.experiment import conditions_of, plan
from app.experiments.pursuit.pursuit_run import MAP, PursuitRun, work
from app.experiments.pursuit.result import Condition, PursuitResult
from app.experiments.tour.laboratory import drawn
from app.maps.library import MapLibrary

SHORT = Course("a metre ahead", Pose2(11.1, 4.6, math.pi / 2), ((11.1, 5.6),))


@pytest.mark.slow
def test_a_late_operator_drives_slower_and_reaches_the_end(tmp_path: Path) -> None:
    config = paths.config_dir() / "lab.yaml"
    what = plan(1, 0, config)
    MapLibrary(tmp_path).keep(MAP, drawn(what.world, what.robot, Pose2()))
    found: list[PursuitResult] = []
    late = Condition("course", 1, 300.0, 50.0, prediction=True)
    work(PursuitRun(config, tmp_path, late, SHORT, seed=5), found.append)
    (result,) = found
    assert result.ended
    assert result.contacts == 0
    assert result.late == 0
    assert 0.7 < result.late_share < 1.0
    assert result.distance_m is None
    assert 0.4 < result.driven_m < 1.2
    assert result.speed_mps < 0.4


def test_a_plan_has_all_conditions_for_each_seed() -> None:
    conditions = conditions_of()
    assert len(conditions) == len(set(conditions)) == 18
    what = plan(2, 4)
    trials = what.trials(Path("maps"))
    assert len(trials) == what.total == 36
    assert {trial.seed for trial in trials} == {4, 5}
    assert replace(what, conditions=conditions_of(["course"])).total == 12
