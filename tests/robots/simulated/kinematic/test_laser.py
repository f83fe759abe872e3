"""The laser of a kinematic body: the map and people's legs, as a scan of the real one has them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.maps.grid_rays import GridRays
from app.robots.simulated.kinematic.config import KinematicLaserConfig
from app.robots.simulated.kinematic.laser import KinematicLaser, legs, met
from app.robots.simulated.scenery.actor import Actor
from app.robots.simulated.scenery.scenario_config import PersonConfig
from tests.robots.simulated.kinematic.rooms import CELL_M, room

CONFIG = KinematicLaserConfig(link="laser")
AHEAD = 180


def laser(X_BL: Pose3 | None = None, **settings: float) -> KinematicLaser:
    config = CONFIG.model_copy(update=settings)
    return KinematicLaser(config, X_BL or Pose3.from_translation_rpy((0.1, 0.0, 0.4)), GridRays(room()), seed=3)


def test_walls_are_where_the_map_has_them_from_where_the_laser_is() -> None:
    scan = laser().scan(5.0, Pose2(0.0, 1.0))
    assert scan.stamp == 5.0
    assert len(scan.ranges) == 361
    assert scan.angle_min == pytest.approx(-math.pi / 2)
    assert scan.ranges[AHEAD] == pytest.approx(4.85, abs=CELL_M)
    assert scan.ranges[-1] == pytest.approx(0.95, abs=CELL_M)
    assert scan.ranges[0] == pytest.approx(2.95, abs=CELL_M)
    turned = laser().scan(5.0, Pose2(0.0, 1.0, math.pi / 2))
    assert turned.ranges[AHEAD] == pytest.approx(0.85, abs=CELL_M)
    backward = laser(Pose3.from_translation_rpy((-0.1, 0.0, 0.4), (0.0, 0.0, math.pi))).scan(5.0, Pose2(0.0, 1.0))
    assert backward.ranges[AHEAD] == pytest.approx(0.85, abs=CELL_M)


def test_scans_are_read_only_and_have_nothing_beyond_the_range() -> None:
    scan = laser(range_max_m=2.0).scan(0.0, Pose2(0.0, 1.0))
    assert math.isinf(scan.ranges[AHEAD])
    assert scan.intensities[AHEAD] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        scan.ranges[0] = 1.0


def test_noise_is_as_configured_and_the_same_for_the_same_seed() -> None:
    quiet = laser().scan(0.0, Pose2(0.0, 1.0)).ranges
    noisy = laser(noise_m=0.02).scan(0.0, Pose2(0.0, 1.0)).ranges
    assert 0.015 < float(np.std(noisy - quiet)) < 0.025
    assert np.array_equal(noisy, laser(noise_m=0.02).scan(0.0, Pose2(0.0, 1.0)).ranges)


def test_a_person_has_two_legs_before_the_wall() -> None:
    person = Actor(PersonConfig(name="one", face="pilot", at=(2.0, 1.0), heading_deg=180), 1.7)
    discs = legs([person])
    assert [radius for _, _, radius in discs] == pytest.approx([0.0544, 0.0544])
    assert sorted(y for _, y, _ in discs) == pytest.approx([1.0 - 0.0816, 1.0 + 0.0816])
    scan = laser().scan(0.0, Pose2(0.0, 1.0), discs)
    near = np.flatnonzero(scan.ranges < 2.0)
    bearings = near[np.abs(near - AHEAD) < 12] - AHEAD
    assert (bearings < 0).any()
    assert (bearings > 0).any()
    assert 0 not in bearings
    assert scan.ranges[AHEAD + bearings].min() == pytest.approx(2.0 - 0.1 - 0.054, abs=0.02)


def test_rays_meet_the_near_side_of_a_disc_and_none_behind() -> None:
    angles = np.array([0.0, 0.5, math.pi])
    assert met(Pose2(), angles, [(2.0, 0.0, 0.5)]).tolist() == [1.5, math.inf, math.inf]
    assert met(Pose2(1.0, 0.0, math.pi), angles, [(2.0, 0.0, 0.5)]).tolist()[2] == pytest.approx(0.5)
    assert np.isinf(met(Pose2(), angles, [])).all()
