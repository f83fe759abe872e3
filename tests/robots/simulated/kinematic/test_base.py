"""The base of a kinematic body: it moves as commanded, within its limits, and stops before what the map has."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.maps.grid_rays import GridRays
from app.robots.actuator_config import circle
from app.robots.guard import BaseVelocity, GuardLimits, GuardMode, VelocityCommand
from app.robots.simulated.kinematic.base import KinematicBase, Outline, moved
from tests.robots.simulated.kinematic.rooms import CELL_M, room

LIMITS = GuardLimits(BaseLimits(0.4, 1.0, linear_mps2=0.4, angular_radps2=4.0))
DT = 0.05
LONG = ((0.3, -0.1), (0.3, 0.1), (-0.3, 0.1), (-0.3, -0.1))


HERE = Pose2()


def base(pose: Pose2 = HERE, corners: tuple[tuple[float, float], ...] = circle(0.28)) -> KinematicBase:
    return KinematicBase(pose, LIMITS, Outline(corners, CELL_M), GridRays(room()))


def drive(body: KinematicBase, velocity: BaseVelocity, seconds: float, begin: float = 0.0, **more: Any) -> float:
    now = begin
    for _ in range(round(seconds / DT)):
        body.accept(VelocityCommand(now, velocity))
        now += DT
        body.step(now, DT, **more)
    return now


@settings(max_examples=40)
@given(
    linear=st.floats(-1, 1), angular=st.floats(-2, 2), lateral=st.floats(-1, 1), theta=st.floats(-3, 3),
    seconds=st.floats(0.01, 2),
)  # fmt: skip
def test_an_arc_is_what_many_small_straight_steps_come_to(
    linear: float, angular: float, lateral: float, theta: float, seconds: float
) -> None:
    velocity, slowly = BaseVelocity(linear, angular, lateral), Pose2(1.0, 2.0, theta)
    steps = 200
    for _ in range(steps):
        part = seconds / steps
        slowly = slowly @ Pose2(linear * part, lateral * part, angular * part)
    found = moved(Pose2(1.0, 2.0, theta), velocity, seconds)
    assert (found.x, found.y) == pytest.approx((slowly.x, slowly.y), abs=0.02)
    assert math.cos(found.theta - slowly.theta) == pytest.approx(1.0, abs=1e-6)


def test_it_speeds_up_within_its_limits_and_stands_without_a_fresh_command() -> None:
    body = base()
    now = drive(body, BaseVelocity(2.0), 0.5)
    assert body.velocity.linear_mps == pytest.approx(0.2)
    now = drive(body, BaseVelocity(2.0), 1.0, now)
    assert body.velocity.linear_mps == pytest.approx(0.4)
    for _ in range(5):
        now += DT
        body.step(now, DT)
    assert body.velocity.is_zero
    assert body.action.mode is GuardMode.STALE_COMMAND


def test_a_wall_stops_it_once_without_overlap_and_it_can_leave() -> None:
    body = base(Pose2(0.0, 1.0))
    now = drive(body, BaseVelocity(0.4), 20.0)
    assert body.touches == 1
    assert body.pose.x == pytest.approx(4.95 - 0.28, abs=CELL_M)
    assert not Outline(circle(0.28), CELL_M).meets(body.pose, GridRays(room()))
    driven_m = body.driven_m
    now = drive(body, BaseVelocity(-0.4), 3.0, now)
    assert body.driven_m > driven_m + 0.9
    drive(body, BaseVelocity(0.4), 20.0, now)
    assert body.touches == 2


def test_turning_swings_a_long_body_against_the_wall() -> None:
    body = base(Pose2(0.0, 1.79), LONG)
    drive(body, BaseVelocity(0.0, 1.0), 3.0)
    assert body.touches == 1
    assert 0.0 < body.pose.theta < 0.8


def test_people_on_the_floor_stop_it_as_walls_do() -> None:
    body = base(Pose2(0.0, 1.0))
    drive(body, BaseVelocity(0.4), 10.0, discs=[(2.0, 1.1, 0.22)])
    assert body.touches == 1
    assert body.pose.x == pytest.approx(2.0 - math.sqrt(0.5**2 - 0.1**2), abs=0.03)


def test_what_begins_in_an_obstacle_can_leave_it() -> None:
    body = base(Pose2(3.0, 0.0, math.pi / 2))
    drive(body, BaseVelocity(0.4), 3.0)
    assert body.pose.y > 0.9


def test_an_emergency_stop_holds_it_until_a_command_after_its_release() -> None:
    body = base()
    now = drive(body, BaseVelocity(0.4), 1.0)
    body.e_stop("test")
    now = drive(body, BaseVelocity(0.4), 0.5, now)
    assert body.velocity.is_zero
    body.clear_e_stop()
    body.step(now + DT, DT)
    assert body.velocity.is_zero
    drive(body, BaseVelocity(0.4), 0.5, now + DT)
    assert body.velocity.linear_mps > 0.1


def test_the_outline_covers_its_whole_floor() -> None:
    rays, rng = GridRays(room()), np.random.default_rng(2)
    outline = Outline(LONG, CELL_M)
    for x, y, theta in rng.uniform((-1, -2, -3.1), (5, 2, 3.1), (300, 3)):
        pose = Pose2(x, y, theta)
        inner = rng.uniform((-0.3, -0.1), (0.3, 0.1), (200, 2))
        if rays.occupied(pose.transform(inner)).any():
            # A corner of a cell between two of its points may escape it.
            near = [pose @ Pose2(dx, dy) for dx in (-0.03, 0.0, 0.03) for dy in (-0.03, 0.0, 0.03)]
            assert any(outline.meets(each, rays) for each in near)
