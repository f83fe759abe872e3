"""The two visitors of the tour experiment are drawn by the seed."""

from __future__ import annotations

import math

from app.base.geometry import Pose2
from app.experiments.tour.visitors import START_M, START_RAD, start_of, two_visitors
from app.maps.grid_rays import GridRays
from tests.robots.simulated.kinematic.rooms import room


def test_one_lags_and_pauses_and_the_other_only_follows() -> None:
    asking, lagging = two_visitors(Pose2(1.0, 0.0, 0.0), GridRays(room()), 3).people
    assert [step.follow is not None for step in asking.script] == [True]
    assert lagging.repeat
    assert any(step.wait is not None and step.wait >= 6 for step in lagging.script)
    assert all(step.distance is not None and step.distance >= 1.6 for step in lagging.script if step.follow)


def test_the_seed_decides() -> None:
    rays, start = GridRays(room()), Pose2(1.0, 0.0, 0.0)
    assert two_visitors(start, rays, 3) == two_visitors(start, rays, 3) != two_visitors(start, rays, 4)
    started = [start_of(start, seed) for seed in range(20)]
    assert len({(at.x, at.theta) for at in started}) == 20
    assert all(math.dist((at.x, at.y), (1.0, 0.0)) <= START_M * math.sqrt(2) for at in started)
    assert all(abs(at.theta) <= START_RAD for at in started)
