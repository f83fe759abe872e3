"""A map of another program, made into keyframes."""

from __future__ import annotations

import math

import numpy as np

from app.base.geometry import Pose2
from app.messages import OccupancyGrid
from app.modules.perception.slam.grid_views import state_of
from app.modules.perception.slam.mapper import Slam
from app.modules.perception.slam.scans import BeamGeometry
from tests.modules.perception.slam.places import ANGLES, HALL, drawn, scan, way


def test_the_robot_is_followed_on_it_within_the_size_of_its_cells() -> None:
    state = state_of(drawn(HALL, (12, 8)))
    assert len(state.keyframes) > 30
    slam = Slam(state=state, X_MB=Pose2(1.1, 3.4, 0.05), frozen=True)
    beams = BeamGeometry(ANGLES, 0.1, 30.0, Pose2(0.2, 0.0, 0.0))
    errors = []
    for number, pose in enumerate(way((1.0, 3.5), (8.0, 3.5), (8.0, 6.5), (11.0, 6.5))):
        match = slam.add(0.1 * number, scan(HALL, pose, seed=number).ranges, beams, pose)
        errors.append(math.dist((match.X_MB.x, match.X_MB.y), (pose.x, pose.y)))
        assert match.inliers > 0.6
    assert np.mean(errors[5:]) < 0.05
    assert max(errors[5:]) < 0.1


def test_a_map_without_floor_has_none() -> None:
    walls = OccupancyGrid(0.0, "map", np.full((20, 20), 100, np.int8), 0.05, (0.0, 0.0), 1)
    assert state_of(walls).keyframes == ()
