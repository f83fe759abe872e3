"""The outline of where the robot will be when a viewer's command arrives: where, when, and for whom."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.base.motion_prediction import Motion, Velocity
from app.console.view.floor import PATH_WIDTH_M
from app.console.view.foreseen import HEIGHT_M, Motions, foreseen, motions, pickets
from app.console.view.foreseen_node import Foreseen
from app.console.view.scene_state import World
from app.link import BaseLimits
from app.messages import Odometry, TeleopCommand
from tests.console.view.viewer_client import Client

LIMITS = BaseLimits(0.4, 1.0, 0.4, 4.0)
SQUARE = np.array([(0.3, -0.3), (0.3, 0.3), (-0.3, 0.3), (-0.3, -0.3)])
NODE = "/odom/foreseen"


def driving(linear: float, angular: float = 0.0) -> Motions:
    """On and on at one velocity, from (1, 2), along y."""
    velocity = Velocity(linear, angular)
    return Motions(Motion(10.0, Pose2(1.0, 2.0, math.pi / 2), velocity), velocity, 10.02)


def test_it_is_where_the_robot_will_be_after_the_viewers_round_trip() -> None:
    after = foreseen(driving(0.4), 0.3, LIMITS)
    assert after is not None
    assert (after.x, after.y, after.theta) == pytest.approx((1.0, 2.0 + 0.4 * 0.32, math.pi / 2))


@pytest.mark.parametrize(
    ("linear", "angular", "round_trip_s", "there"),
    [
        (0.4, 0.0, 0.05, False),  # 3 cm
        (0.4, 0.0, 0.15, True),  # 7 cm
        (0.0, 0.3, 0.1, False),  # 2 degrees
        (0.0, 0.3, 0.25, True),  # 5 degrees
        (0.0, 0.0, 1.0, False),
    ],
)
def test_only_what_is_far_enough_is_seen(linear: float, angular: float, round_trip_s: float, there: bool) -> None:
    assert (foreseen(driving(linear, angular), round_trip_s, LIMITS) is not None) == there


def test_the_drivers_command_counts_while_it_is_fresh() -> None:
    odometry = Odometry(10.0, Pose2(), 0.4, 0.0)
    applied = Velocity(0.4)
    released = TeleopCommand(10.0, "me", 1, held=False, linear=0.0, angular=0.0)
    left = TeleopCommand(10.0, "me", 2, held=True, linear=1.0, angular=0.5)
    assert motions(odometry, applied, None, LIMITS, now=10.05).commanded == applied
    assert motions(odometry, applied, released, LIMITS, now=10.05).commanded == Velocity()
    assert motions(odometry, applied, left, LIMITS, now=10.05).commanded == Velocity(0.4, 0.5)
    assert motions(odometry, applied, left, LIMITS, now=10.5).commanded == applied
    braking = foreseen(motions(odometry, applied, released, LIMITS, now=10.0), 0.3, LIMITS)
    going = foreseen(motions(odometry, applied, None, LIMITS, now=10.0), 0.3, LIMITS)
    assert braking is not None
    assert going is not None
    assert going.x - braking.x == pytest.approx(0.5 * 0.4 * 0.3**2, rel=0.1)


def test_pickets_stand_on_the_outline_with_gaps_between() -> None:
    vertices, faces = pickets(SQUARE)
    assert faces.max() == len(vertices) - 1
    assert np.abs(vertices[:, :2]).max() < 0.3 + PATH_WIDTH_M
    assert (vertices[:, 2].min(), vertices[:, 2].max()) == pytest.approx((0.0, HEIGHT_M))
    corners = vertices[faces].astype(float)
    standing = np.ptp(corners[:, :, 2], axis=1) > 0.0
    assert np.abs(np.abs(corners[standing][:, :, :2]).max(axis=2) - 0.3).max() < 0.01
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert 0.4 < areas[standing].sum() / (4 * 0.6 * HEIGHT_M) < 0.65


def test_each_viewer_has_an_outline_by_the_own_round_trip() -> None:
    near, far = Client(), Client()
    world = World(robot=Pose2(1.0, 2.0, math.pi / 2), motions=driving(0.4))
    here = Foreseen(near, "/odom", SQUARE, LIMITS)  # type: ignore[arg-type]
    away = Foreseen(far, "/odom", SQUARE, LIMITS)  # type: ignore[arg-type]
    assert here.draw(world, 0.02) == 0
    assert away.draw(world, 0.5) == 1
    assert NODE not in near.nodes
    node = far.nodes[NODE]
    assert tuple(node.position)[:2] == pytest.approx((1.0, 2.0 + 0.4 * 0.52))
    assert away.draw(world, 0.5) == 0
    assert away.draw(World(motions=driving(0.0)), 0.5) == 1
    assert node.visible is False
    assert away.draw(world, 0.3) == 1
    assert node.visible is True
    assert tuple(node.position)[1] == pytest.approx(2.0 + 0.4 * 0.32)


@pytest.mark.parametrize(("world", "round_trip_s"), [(World(), 0.5), (World(motions=driving(0.4)), None)])
def test_what_is_not_known_is_not_drawn(world: World, round_trip_s: float | None) -> None:
    client = Client()
    assert Foreseen(client, "/odom", SQUARE, LIMITS).draw(world, round_trip_s) == 0  # type: ignore[arg-type]
    assert not client.nodes
