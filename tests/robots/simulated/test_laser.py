"""The laser against walls whose distances are known."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import pytest

from app.base.geometry import Pose2, wrap_angle
from app.base.kinematic_model import load_model
from app.messages import LaserScan
from app.robots.config import RobotConfig, StartPose
from app.robots.guard import BaseVelocity
from app.robots.simulated.body import TIMESTEP_S, RobotSimulation, build_simulation
from app.robots.simulated.laser import Laser, _RayTargets
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.world_config import WorldConfig
from app.robots.stream_config import HokuyoConfig
from tests.robots.conftest import make_hall


def setup(
    robot: RobotConfig, world: WorldConfig, seed: int = 3, **hokuyo: float
) -> tuple[RobotSimulation, Laser, HokuyoConfig]:
    config = HokuyoConfig(**hokuyo)
    robot = robot.model_copy(update={"start": StartPose(x=10, y=8, heading_deg=0)})
    simulation = build_simulation(robot, world, TrueBase(0.10, 0.10, 0.44))
    laser = Laser(simulation, config, load_model(robot.model).pose("hokuyo_link"), np.random.default_rng(seed))
    return simulation, laser, config


def sweep(simulation: RobotSimulation, laser: Laser, stamp: float = 100.0) -> LaserScan:
    laser.begin(stamp)
    for i in range(100):
        if (scan := laser.advance(stamp + i * TIMESTEP_S)) is not None:
            return scan
        simulation.step()
    raise AssertionError("the sweep never ended")


def test_ranges_are_the_walls_within_the_noise(robot: RobotConfig, hall: WorldConfig) -> None:
    simulation, laser, config = setup(robot, hall)
    scan = sweep(simulation, laser)
    assert scan.ranges.shape == scan.intensities.shape == (720,)
    assert scan.angle_min == pytest.approx(-math.pi / 2)
    assert scan.angle_min + 719 * scan.angle_increment == pytest.approx(math.pi / 2)
    x, y = 10 + scan.X_BL.translation[0], 8.0
    angles = scan.angle_min + scan.angle_increment * np.arange(720)
    c, s = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_east = (19.9 - x) / np.maximum(c, 1e-9)
        to_side = np.where(s > 0, (19.9 - y) / np.maximum(s, 1e-9), (y - 0.1) / np.maximum(-s, 1e-9))
    error = scan.ranges - np.minimum(to_east, to_side)
    assert np.isfinite(scan.ranges).all()  # and none of its own body
    assert abs(error.mean()) < 0.004
    assert error.std() == pytest.approx(config.noise_m, rel=0.2)


def test_nothing_in_range_is_infinite(robot: RobotConfig, hall: WorldConfig) -> None:
    simulation, laser, _ = setup(robot, hall, range_max_m=5.0)
    scan = sweep(simulation, laser)
    assert np.isinf(scan.ranges).all()
    assert (scan.intensities == 0).all()


def test_low_things_are_under_its_plane_and_high_things_above(robot: RobotConfig) -> None:
    things = [
        {"kind": "box", "at": (13, 8), "size": (0.5, 2, 0.35)},
        {"kind": "box", "at": (14, 8), "size": (0.5, 2, 0.5), "z": 0.6},
        {"kind": "box", "at": (16, 8), "size": (0.5, 0.5, 0.8)},
    ]
    simulation, laser, _ = setup(robot, make_hall(objects=things))
    scan = sweep(simulation, laser)
    assert scan.ranges[359] == pytest.approx(16 - 0.25 - 10 - scan.X_BL.translation[0], abs=0.05)


def test_a_scan_taken_while_turning_is_skewed_by_its_own_duration(robot: RobotConfig, hall: WorldConfig) -> None:
    simulation, laser, config = setup(robot, hall, noise_m=0.0, sweep_s=0.1)
    simulation.drive(BaseVelocity(0.0, 1.0))
    for _ in range(250):
        simulation.step()
    start = simulation.true_pose()
    scan = sweep(simulation, laser)
    corner = int(np.argmax(scan.ranges))
    bearing = scan.angle_min + scan.angle_increment * corner
    laser_at = start @ Pose2(float(scan.X_BL.translation[0]), 0.0, 0.0)
    at_rest = wrap_angle(math.atan2(19.9 - laser_at.y, 19.9 - laser_at.x) - start.theta)
    late_s = config.sweep_s * corner / 720
    assert late_s > 0.05
    assert bearing - at_rest == pytest.approx(-late_s * 1.0, abs=0.012)


def test_the_same_seed_gives_the_same_scan(robot: RobotConfig, hall: WorldConfig) -> None:
    first, second, third = (sweep(*setup(robot, hall, seed)[:2]).ranges for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, second)
    assert not np.array_equal(first, third)


@pytest.mark.parametrize("heading_deg", [37, 260])
def test_shapes_left_out_of_a_fan_are_none_that_it_meets(
    robot: RobotConfig, lab: WorldConfig, heading_deg: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    hokuyo = HokuyoConfig(fov_deg=270, noise_m=0.0, sweep_s=0.01875)
    start = StartPose(x=11.0, y=8.0, heading_deg=heading_deg)
    simulation = build_simulation(robot.model_copy(update={"start": start}), lab, TrueBase(0.10, 0.10, 0.44))
    X_BL = load_model(robot.model).pose("hokuyo_link")
    laser = Laser(simulation, hokuyo, X_BL, np.random.default_rng(1))
    limited = sweep(simulation, laser)
    assert not laser._sight.model.geom_group.any()  # all are asked again afterwards

    simulation = build_simulation(robot.model_copy(update={"start": start}), lab, TrueBase(0.10, 0.10, 0.44))
    with monkeypatch.context() as context:
        context.setattr(_RayTargets, "limited", lambda *_: contextlib.nullcontext())
        everything = sweep(simulation, Laser(simulation, hokuyo, X_BL, np.random.default_rng(1)))
    np.testing.assert_array_equal(limited.ranges, everything.ranges)
    np.testing.assert_array_equal(limited.intensities, everything.intensities)


def test_a_loose_thing_is_met_where_it_is_now(robot: RobotConfig) -> None:
    crate = {"kind": "box", "at": (12.0, 8.0), "size": (0.4, 0.4, 0.9), "mass_kg": 5.0}
    simulation, laser, _ = setup(robot, make_hall(objects=[crate]), noise_m=0.0)
    ahead = 360
    reach = 10 + sweep(simulation, laser).X_BL.translation[0]
    assert sweep(simulation, laser).ranges[ahead] == pytest.approx(11.8 - reach, abs=0.02)
    place = simulation.model.joint(simulation.model.body("box0").jntadr[0]).qposadr[0]
    simulation.data.qpos[place] += 1.0
    assert sweep(simulation, laser).ranges[ahead] == pytest.approx(12.8 - reach, abs=0.02)
    simulation.data.qpos[place + 1] += 2.0
    assert sweep(simulation, laser).ranges[ahead] == pytest.approx(19.9 - reach, abs=0.02)
