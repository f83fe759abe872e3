"""The body in the physics: mass, rest, driving and braking. No process, no camera."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import wrap_angle
from app.robots import guard
from app.robots.config import RobotConfig, StartPose
from app.robots.guard import BaseVelocity, GuardLimits, GuardState, VelocityCommand
from app.robots.simulated.body import TIMESTEP_S, RobotSimulation, build_simulation
from app.robots.simulated.odometry import TrueBase
from app.robots.simulated.world_config import WorldConfig

PERFECT = TrueBase(0.10, 0.10, 0.44)


@pytest.fixture
def simulation(robot: RobotConfig, hall: WorldConfig) -> RobotSimulation:
    start = StartPose(x=5, y=10, heading_deg=0)
    return build_simulation(robot.model_copy(update={"start": start}), hall, PERFECT)


def run(
    simulation: RobotSimulation, velocity: BaseVelocity, seconds: float, state: GuardState, limits: GuardLimits
) -> tuple[GuardState, np.ndarray]:
    """Hold ``velocity`` through the guard; returns its state and true (linear, angular) speeds, one row a step."""
    speeds = []
    for _ in range(round(seconds / TIMESTEP_S)):
        now = simulation.time_s
        state = guard.accept(state, VelocityCommand(now, velocity))
        state = guard.step(state, guard.decide(now, state, {}, limits), limits, TIMESTEP_S)
        simulation.drive(state.applied)
        simulation.step()
        true = simulation.true_velocity()
        speeds.append((true.linear_mps, true.angular_radps))
    return state, np.array(speeds)


def smooth_acceleration(speeds: np.ndarray, window_s: float = 0.1) -> np.ndarray:
    n = round(window_s / TIMESTEP_S)
    return (speeds[n:] - speeds[:-n]) / window_s


def test_it_weighs_about_70_kg_and_is_1_4_m_tall(simulation: RobotSimulation) -> None:
    model = simulation.model
    assert model.body_subtreemass[simulation.base_body] == pytest.approx(70, abs=2)
    tops = [
        simulation.data.geom_xpos[g][2] + np.abs(simulation.data.geom_xmat[g].reshape(3, 3)[2]) @ model.geom_aabb[g][3:]
        for g in range(model.ngeom)
        if model.body_rootid[model.geom_bodyid[g]] == simulation.base_body and model.geom_group[g] == 1
    ]
    assert max(tops) == pytest.approx(1.4, abs=0.03)


def test_the_face_takes_no_part_in_the_physics(simulation: RobotSimulation, robot: RobotConfig) -> None:
    assert len(robot.kinematic_joints) == 9
    assert not set(simulation.joints).intersection(robot.kinematic_joints)
    assert simulation.model.njnt == 1 + len(simulation.joints)
    assert simulation.model.neq == 0
    bodies = [simulation.model.body(number).name for number in range(simulation.model.nbody)]
    assert not [name for name in bodies if "eye" in name or "mouth" in name or "lip" in name]


def test_it_stands_still_with_arms_hanging_and_head_ahead(simulation: RobotSimulation, robot: RobotConfig) -> None:
    before = simulation.true_pose()
    run(simulation, guard.ZERO, 4.0, GuardState(), robot.limits.guard())
    after = simulation.true_pose()
    assert math.dist((before.x, before.y), (after.x, after.y)) < 0.001
    assert abs(after.theta - before.theta) < 0.001
    assert abs(simulation.data.qpos[simulation.base_address + 2]) < 0.003
    wheels = [n for n in simulation.joints if "wheel" in n]
    for name, position in zip(simulation.joints, simulation.joint_positions(), strict=True):
        if name not in wheels:
            assert abs(position) < 0.01, name


def test_it_drives_a_metre_straight_and_turns_a_quarter(simulation: RobotSimulation, robot: RobotConfig) -> None:
    limits = robot.limits.guard()
    start = simulation.true_pose()
    # 0.4 m/s^2 up and down, 0.4 m/s between: 1 m takes 2.5 s of command and 1 s of braking
    state, _ = run(simulation, BaseVelocity(0.4, 0.0), 2.5, GuardState(), limits)
    state, _ = run(simulation, guard.ZERO, 1.5, state, limits)
    there = simulation.true_pose()
    assert there.x - start.x == pytest.approx(1.0, abs=0.03)
    assert abs(there.y - start.y) < 0.01
    assert abs(there.theta) < 0.02
    # 4 rad/s^2 up and down, 1 rad/s between
    state, _ = run(simulation, BaseVelocity(0.0, 1.0), math.pi / 2, state, limits)
    run(simulation, guard.ZERO, 0.7, state, limits)
    turned = simulation.true_pose()
    assert wrap_angle(turned.theta - there.theta) == pytest.approx(math.pi / 2, abs=0.05)
    assert math.dist((turned.x, turned.y), (there.x, there.y)) < 0.02


def test_the_true_motion_keeps_the_bases_limits(simulation: RobotSimulation, robot: RobotConfig) -> None:
    limits = robot.limits.guard()
    state, up = run(simulation, BaseVelocity(9.0, 0.0), 1.6, GuardState(), limits)
    state, down = run(simulation, guard.ZERO, 1.4, state, limits)
    linear = np.concatenate([up, down])[:, 0]
    assert np.abs(linear).max() <= 0.40 * 1.02
    assert np.abs(smooth_acceleration(linear)).max() <= 0.40 * 1.08
    state, left = run(simulation, BaseVelocity(0.0, -9.0), 0.8, state, limits)
    _, still = run(simulation, guard.ZERO, 0.6, state, limits)
    angular = np.concatenate([left, still])[:, 1]
    assert np.abs(angular).max() <= 1.00 * 1.05
    assert np.abs(smooth_acceleration(angular)).max() <= 4.00 * 1.08


def test_an_emergency_stop_brakes_as_hard_as_configured_and_does_not_topple(
    simulation: RobotSimulation, robot: RobotConfig
) -> None:
    limits = robot.limits.guard()
    state, _ = run(simulation, BaseVelocity(0.4, 0.0), 1.3, GuardState(), limits)
    before = simulation.true_pose()
    _, speeds = run(simulation, guard.ZERO, 1.0, guard.e_stop(state, "test"), limits)
    after = simulation.true_pose()
    braking = -smooth_acceleration(speeds[:, 0], 0.05).min()
    assert 1.5 <= braking <= robot.limits.emergency_mps2 * 1.1
    assert after.x - before.x < 0.08
    assert abs(speeds[-1, 0]) < 0.005
    tilt = simulation.data.xmat[simulation.base_body].reshape(3, 3)[2, 2]
    assert tilt > math.cos(math.radians(1.0))


def test_it_cannot_drive_through_a_wall(robot: RobotConfig, hall: WorldConfig) -> None:
    start = StartPose(x=19.3, y=10, heading_deg=0)
    simulation = build_simulation(robot.model_copy(update={"start": start}), hall, PERFECT)
    run(simulation, BaseVelocity(0.4, 0.0), 3.0, GuardState(), robot.limits.guard())
    assert simulation.true_pose().x < 19.9 - 0.25


@pytest.mark.parametrize("share", [-2, 2])
def test_wheels_of_another_size_carry_it_all_the_same(robot: RobotConfig, hall: WorldConfig, share: int) -> None:
    """It turns as its wheels roll, and not as casters slide that hold them off the floor."""
    radius = robot.base.wheel_radius_m * (1 + share * robot.base.radius_error)
    start = StartPose(x=5, y=10, heading_deg=0)
    base = TrueBase(radius, radius, robot.base.track_m)
    simulation = build_simulation(robot.model_copy(update={"start": start}), hall, base)
    before = simulation.true_pose()
    run(simulation, BaseVelocity(0.4, 0.3), 3.0, GuardState(), robot.limits.guard())
    after = before.inverse() @ simulation.true_pose()
    angles = dict(zip(simulation.joints, simulation.joint_positions(), strict=True))
    rolled = angles[robot.base.right_wheel_joint] - angles[robot.base.left_wheel_joint]
    assert after.theta == pytest.approx(rolled * radius / robot.base.track_m, abs=0.03)


def test_the_heads_servos_do_not_sag_under_its_weight(simulation: RobotSimulation) -> None:
    tilt = simulation.joints.index("tilt_joint")
    for _ in range(round(2.0 / TIMESTEP_S)):
        simulation.step()
    assert simulation.joint_positions()[tilt] == pytest.approx(0.0, abs=math.radians(0.02))


def holonomic(robot: RobotConfig) -> RobotConfig:
    limits = robot.limits.model_copy(update={"lateral_mps": 0.4})
    base = robot.base.model_copy(update={"drive": "holonomic"})
    return robot.model_copy(update={"start": StartPose(x=5, y=10), "limits": limits, "base": base})


def test_a_holonomic_base_moves_sideways_while_it_turns(robot: RobotConfig, hall: WorldConfig) -> None:
    config = holonomic(robot)
    simulation = build_simulation(config, hall, PERFECT)
    state, limits = GuardState(), config.limits.guard()
    start = simulation.true_pose()
    state, _ = run(simulation, BaseVelocity(0.0, 0.0, 0.4), 2.5, state, limits)
    assert simulation.true_velocity().lateral_mps == pytest.approx(0.4, abs=0.01)
    state, _ = run(simulation, guard.ZERO, 1.5, state, limits)
    there = simulation.true_pose()
    assert there.y - start.y == pytest.approx(1.0, abs=0.03)
    assert (there.x, there.theta) == pytest.approx((start.x, start.theta), abs=0.02)
    run(simulation, BaseVelocity(0.2, -0.5, 0.2), 2.0, state, limits)
    moving = simulation.true_velocity()
    assert (moving.linear_mps, moving.lateral_mps) == pytest.approx((0.2, 0.2), abs=0.02)
    assert moving.angular_radps == pytest.approx(-0.5, abs=0.02)


def test_a_safety_stop_of_a_holonomic_base_brakes_as_hard_as_configured(robot: RobotConfig, hall: WorldConfig) -> None:
    config = holonomic(robot)
    simulation = build_simulation(config, hall, PERFECT)
    run(simulation, BaseVelocity(0.0, 0.0, 0.4), 2.0, GuardState(), config.limits.guard())
    before = simulation.true_velocity().lateral_mps
    for _ in range(20):
        simulation.drive(guard.ZERO)
        simulation.step()
    lost = before - simulation.true_velocity().lateral_mps
    assert lost == pytest.approx(config.limits.emergency_mps2 * 20 * TIMESTEP_S, rel=0.15)
    for _ in range(200):
        simulation.drive(guard.ZERO)
        simulation.step()
    assert simulation.true_velocity().lateral_mps == pytest.approx(0, abs=0.005)


def test_a_differential_base_ignores_the_sideways_part(simulation: RobotSimulation) -> None:
    simulation.drive(BaseVelocity(0.0, 0.0, 0.4))
    assert not simulation.data.ctrl.any()
    assert not simulation.data.qfrc_applied.any()
