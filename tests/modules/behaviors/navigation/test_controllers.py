"""Every controller: within the body's limits, never into what it could not stop before, and there in the end."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.modules.behaviors.navigation.controller import BodyModel, LocalPath, MotionState
from app.modules.behaviors.navigation.planning.reference_path import ReferencePath
from app.modules.behaviors.navigation.tracking.control_cycle import CONTROLLERS, FORWARD_ONLY, controller_named
from tests.modules.behaviors.navigation.scenes import (
    FAST,
    HOLONOMIC,
    LIMITS,
    LONG,
    SQUARE,
    body_of,
    distance_to,
    driven,
    field_of,
    wall,
    way_along,
)

BODIES = {
    "slow": (LIMITS, SQUARE, 0.1),
    "fast": (FAST, LONG, 0.05),
    "holonomic": (HOLONOMIC, SQUARE, 0.1),
}


@pytest.fixture(params=CONTROLLERS)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(params=BODIES)
def kind(request: pytest.FixtureRequest, name: str) -> str:
    if request.param == "holonomic" and name in FORWARD_ONLY:
        pytest.skip("it is for differential bases")
    return str(request.param)


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_never_into_what_it_could_not_stop_before(name: str, kind: str, data: st.DataObject) -> None:
    """For any obstacles and any motion: if it could still stop before, it can after the next command."""
    limits, footprint, period_s = BODIES[kind]
    half_x, half_y = footprint[0][0], abs(footprint[0][1])
    random = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    obstacles = random.uniform(-2.5, 2.5, (data.draw(st.integers(1, 60)), 2))
    pose = Pose2(0.0, 0.0, data.draw(st.floats(-3, 3)))
    motion = MotionState(
        pose,
        data.draw(st.floats(0, limits.linear_mps)),
        data.draw(st.floats(-1, 1)),
        lateral_mps=data.draw(st.floats(-limits.lateral_mps, limits.lateral_mps)),
    )

    def stopped(start: MotionState) -> float:
        """The least distance while braking from there."""
        least = distance_to(obstacles, start.pose, half_x, half_y)
        while start.speed_mps > 1e-3 or abs(start.angular_radps) > 1e-2:
            start = driven(start, 0.0, 0.0, limits, 0.02)
            least = min(least, distance_to(obstacles, start.pose, half_x, half_y))
        return least

    if stopped(motion) < 0.08:
        return
    way = way_along([(0.0, 0.0), (2.0, 0.5), (4.0, 0.0)], pose, limits)
    choice = controller_named(name).choose(motion, field_of(obstacles), way, body_of(limits, footprint), period_s)
    least = distance_to(obstacles, pose, half_x, half_y)
    after = motion
    for _ in range(round(period_s / 0.01)):
        after = driven(after, choice.linear_mps, choice.angular_radps, limits, 0.01, lateral=choice.lateral_mps)
        least = min(least, distance_to(obstacles, after.pose, half_x, half_y))
    assert min(least, stopped(after)) > -0.005
    assert 0.0 <= choice.linear_mps <= limits.linear_mps + 1e-9
    assert abs(choice.angular_radps) <= limits.angular_radps + 1e-9
    if limits.holonomic:
        share = math.hypot(choice.linear_mps / limits.linear_mps, choice.lateral_mps / limits.lateral_mps)
        assert share <= 1.0 + 1e-9
    else:
        assert choice.lateral_mps == 0.0


def follow(
    name: str, kind: str, obstacles: np.ndarray, points: list[tuple[float, float]], limit_s: float = 60.0
) -> tuple[float, float, list[MotionState]]:
    """Drive along ``points``: time needed (inf: never there), least distance to obstacles, and every cycle's motion."""
    limits, footprint, period_s = BODIES[kind]
    half_x, half_y = footprint[0][0], abs(footprint[0][1])
    controller, field = controller_named(name), field_of(obstacles, 12.0)
    body = BodyModel.of(footprint, limits, padding_m=0.03 if name == "dwa_published" else 0.0)
    track = ReferencePath(np.array(points), speed_mps=limits.linear_mps, braking_mps2=limits.linear_mps2)
    start = points[0]
    motion = MotionState(Pose2(*start, math.atan2(points[1][1] - start[1], points[1][0] - start[0])), 0.0, 0.0)
    least, time, driven_so_far = math.inf, 0.0, [motion]
    while time < limit_s:
        remaining, _ = track.come_to(motion.pose)
        if remaining < 0.15:
            return time, least, driven_so_far
        way = track.ahead(Pose2(), max(2.5, 3.0 * limits.linear_mps))
        choice = controller.choose(motion, field, way, body, period_s)
        motion = driven(motion, choice.linear_mps, choice.angular_radps, limits, period_s, lateral=choice.lateral_mps)
        driven_so_far.append(motion)
        least = min(least, distance_to(obstacles, motion.pose, half_x, half_y))
        time += period_s
    return math.inf, least, driven_so_far


def test_through_a_doorway(name: str, kind: str) -> None:
    doorway = np.concatenate((wall(0.0, -3.0, 0.0, -0.4), wall(0.0, 0.4, 0.0, 3.0)))
    time, least, _ = follow(name, kind, doorway, [(-2.0, -1.0), (-0.8, 0.0), (0.8, 0.0), (2.0, 1.0)])
    assert time < 60
    assert least > 0.0


@pytest.mark.parametrize("name", ["mppi"])
def test_around_what_stands_on_the_way_by_itself(name: str, kind: str) -> None:
    pillar = np.concatenate((wall(-0.1, -0.1, 0.1, -0.1), wall(-0.1, 0.1, 0.1, 0.1)))
    time, least, _ = follow(name, kind, pillar, [(-2.5, 0.05), (2.5, 0.05)])
    assert time < 40
    assert least > 0.0


@pytest.mark.parametrize("name", ["mppi", "pursuit"])
def test_the_better_ones_are_fast_and_smooth(name: str) -> None:
    corridor = np.concatenate((wall(-4.0, -1.0, 5.0, -1.0), wall(-4.0, 1.0, 5.0, 1.0)))
    time, _, motions = follow(name, "fast", corridor, [(-3.5, 0.0), (4.5, 0.0)])
    assert time < 8.0 / 1.2
    turning = [abs(b.angular_radps - a.angular_radps) for a, b in pairwise(motions)]
    assert np.mean(turning) < 0.1


@pytest.mark.slow
def test_at_a_wall_it_stands_and_says_so(name: str, kind: str) -> None:
    time, least, motions = follow(name, kind, wall(1.0, -5.0, 1.0, 5.0), [(-1.0, 0.0), (3.0, 0.0)], limit_s=12.0)
    assert time == math.inf
    assert least > 0.0
    assert abs(motions[-1].linear_mps) < 0.05


def test_equal_inputs_give_equal_commands(name: str) -> None:
    obstacles = np.random.default_rng(3).uniform(-2.5, 2.5, (40, 2))
    obstacles = obstacles[np.hypot(*obstacles.T) > 0.6]
    runs = []
    for _ in range(2):
        controller, motion = controller_named(name), MotionState(Pose2(), 0.3, 0.0)
        field, body = field_of(obstacles), body_of(LIMITS, SQUARE)
        for _ in range(5):
            choice = controller.choose(
                motion, field, way_along([(0.0, 0.0), (3.0, 0.5)], motion.pose, LIMITS), body, 0.1
            )
            motion = driven(motion, choice.linear_mps, choice.angular_radps, LIMITS, 0.1)
        runs.append(motion)
    assert runs[0] == runs[1]


@pytest.mark.parametrize("name", ["mppi", "pursuit"])
def test_a_path_to_the_side_is_strafed_where_the_body_can(name: str) -> None:
    """The body looks along x, and the path leads to its left and goes on looking along x."""
    limits, controller, motion = HOLONOMIC, controller_named(name), MotionState(Pose2(), 0.0, 0.0)
    field, body = field_of(np.empty((0, 2))), body_of(limits, SQUARE)
    way = np.array([(0.0, y, 0.0, y, 0.3) for y in np.arange(0.0, 1.5, 0.05)])
    for _ in range(20):
        choice = controller.choose(motion, field, LocalPath(way, 0.05), body, 0.1)
        motion = driven(motion, choice.linear_mps, choice.angular_radps, limits, 0.1, lateral=choice.lateral_mps)
    assert motion.lateral_mps > 0.2
    assert motion.pose.y > 0.25
    assert abs(motion.pose.theta) < 0.3


@pytest.mark.parametrize("name", FORWARD_ONLY)
def test_a_controller_for_differential_bases_is_refused_for_a_holonomic_one(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} is for differential bases.*use mppi, pursuit"):
        controller_named(name, holonomic=True)


def test_an_unknown_controller_is_named() -> None:
    with pytest.raises(ValueError, match="'teb'; there are mppi"):
        controller_named("teb")


def test_limits_of_the_type_are_what_the_body_says() -> None:
    body = body_of(BaseLimits(0.4, 1.0, 0.5, 4.0), SQUARE)
    assert body.limits == (0.0, 0.4, 1.0, 0.5, 4.0, 0.5, 0.0)
    assert body.radii == pytest.approx((0.25, math.hypot(0.25, 0.25)))
    assert body.limited(0.5).limits[1:3] == pytest.approx((0.2, 0.5))
