"""Low things are remembered on the map until seen to be gone; people and what the laser sees are not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.modules.behaviors.navigation.costmap.persistent_obstacle_file import PersistentObstacles
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import (
    PersistentObstacleLayer,
    PersistentObstacleSettings,
)
from app.modules.behaviors.navigation.kernel_loading import load_kernels
from tests.modules.behaviors.navigation.boxes import World, looking
from tests.modules.behaviors.navigation.maps import ROUND

EYE = looking(0.0, 1.38)
#: Lower than the laser, which is at 0.4 m; a camera at 1.38 m that looks ahead sees it from 3 m on.
BOX = (3.0, -0.2, 3.3, 0.2, 0.0, 0.22)


@pytest.fixture(scope="module", autouse=True)
def _kernels() -> None:
    """Compiled before, and loaded once: no test's own time."""
    load_kernels()


def memory() -> PersistentObstacleLayer:
    return PersistentObstacleLayer(ROUND, 1.4, PersistentObstacleSettings(depth_step=1))


def seen_by_laser(world: World, stamp: float, pose: Pose2) -> NDArray[np.float64]:
    scan = world.scan(stamp, pose)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    met = np.isfinite(scan.ranges)
    at = pose @ Pose2(0.2, 0.0, 0.0)
    directions = np.stack((np.cos(at.theta + angles[met]), np.sin(at.theta + angles[met])), axis=-1)
    return np.asarray(np.array([at.x, at.y]) + scan.ranges[met, None] * directions, dtype=np.float64)


def look(things: PersistentObstacleLayer, world: World, poses: list[Pose2], stamp: float = 0.0) -> float:
    for pose in poses:
        things.look(world.depth(stamp, pose, EYE), pose, seen_by_laser(world, stamp, pose))
        stamp += 0.2
    return stamp


def approach(begin: float, end: float) -> list[Pose2]:
    return [Pose2(float(x), 0.0, 0.0) for x in np.arange(begin, end, 0.12)]


def about(things: PersistentObstacleLayer, x: float, y: float, within_m: float = 0.3) -> int:
    return int((np.hypot(*(things.points - np.array([x, y])).T) < within_m).sum())


def test_a_low_box_seen_on_the_way_is_there_an_hour_later_and_from_anywhere() -> None:
    things, world = memory(), World((BOX,))
    stamp = look(things, world, approach(-1.0, 0.8))
    assert about(things, 3.0, 0.0) > 5
    assert np.abs(things.points - np.array([3.05, 0.0])).max() < 0.35, "nothing else was seen"
    elsewhere = [Pose2(-6.0, 4.0, math.pi)] * 3
    stamp = look(things, world, elsewhere, stamp + 3600.0)
    beside = [Pose2(2.0, 0.0, 0.0)] * 3  # from where the camera looks over it
    look(things, world, beside, stamp)
    assert about(things, 3.0, 0.0) > 5
    X_MO = Pose2(1.0, 2.0, 0.5)
    X_OB = X_MO.inverse() @ Pose2(2.0, 0.0, 0.0)
    near = things.near(X_MO, X_OB, 2.0)
    ahead = np.array([(X_OB.inverse() @ Pose2(*point)).x for point in near])
    assert ahead.min() == pytest.approx(1.0, abs=0.12)
    assert not len(things.near(X_MO, X_MO.inverse() @ Pose2(-6.0, 4.0, 0.0), 2.0))


@pytest.mark.parametrize("pan_deg", [60.0, -90.0])
def test_what_a_turned_head_sees_is_where_it_is_and_seen_to_be_gone(pan_deg: float) -> None:
    """The body looks away by as much as the head is turned, so that the eye sees what one ahead would."""
    pan = math.radians(pan_deg)
    turned = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (0.0, 0.0, pan)) @ EYE
    things, ahead = memory(), memory()
    poses, stamp = approach(-1.0, 0.8), 0.0
    for world, eye_poses in ((World((BOX,)), poses), (World(()), poses[:4])):
        for pose in eye_poses:
            away = Pose2(pose.x, pose.y, -pan)
            things.look(world.depth(stamp, away, turned), away, seen_by_laser(world, stamp, away))
            ahead.look(world.depth(stamp, pose, EYE), pose, seen_by_laser(world, stamp, pose))
            stamp += 0.2
        if world.boxes:
            assert about(things, 3.0, 0.0) > 5
            assert about(things, 3.0, 0.0) == pytest.approx(about(ahead, 3.0, 0.0), abs=2)
            assert np.abs(things.points - np.array([3.05, 0.0])).max() < 0.35
            stamp += 60.0
    assert not len(things.points)


def test_it_is_forgotten_once_seen_to_be_gone() -> None:
    things = memory()
    stamp = look(things, World((BOX,)), approach(-1.0, 0.8))
    before = things.version
    look(things, World(()), approach(-1.0, -0.6), stamp + 60.0)
    assert not len(things.points)
    assert things.version > before


def test_neither_who_stands_there_nor_a_wall_is_kept_nor_what_passes() -> None:
    things = memory()
    person = (2.9, -0.2, 3.1, 0.2, 0.0, 1.7)
    shoe = (2.7, -0.2, 2.9, 0.0, 0.0, 0.1)
    wall = (4.2, -3.0, 4.4, 3.0, 0.0, 2.5)
    look(things, World((person, shoe, wall)), [Pose2(-0.5, 0.0, 0.0)] * 20)
    assert not len(things.points)
    stamp = 0.0
    for k in range(12):  # something low that rolls by
        world = World(((2.8, -1.2 + 0.2 * k, 3.0, -1.0 + 0.2 * k, 0.0, 0.25),))
        stamp = look(things, world, [Pose2(-0.7, 0.0, 0.0)], stamp)
    assert not len(things.points)


def test_what_was_felt_is_kept_and_where_the_body_stands_nothing_is() -> None:
    things, empty = memory(), World(())
    here = Pose2(1.0, 1.0, 0.3)
    things.add_contacts(np.array([[1.3, 1.1], [1.31, 1.17], [-9.0, -9.0]]), 5.0)
    look(things, empty, [here] * 5, 6.0)
    assert about(things, 1.3, 1.1, 0.2) >= 2
    assert about(things, -9.0, -9.0, 0.1) == 1
    look(things, empty, [Pose2(1.3, 1.1, 0.3)] * 2, 8.0)
    assert about(things, 1.3, 1.1, 0.1) == 0


def test_what_was_kept_counts_until_seen_to_be_gone() -> None:
    things, other = memory(), memory()
    stamp = look(things, World((BOX,)), approach(-1.0, 0.8))
    other.take(things.snapshot())
    assert len(other.points)
    assert (other.points == things.points).all()
    look(other, World(()), approach(-1.0, -0.6), stamp)
    assert not len(other.points), "what was loaded is seen to be gone as well"
    things.take(PersistentObstacles.none())
    assert not len(things.points)


def test_a_year_of_uptime_loses_nothing() -> None:
    things = memory()
    look(things, World((BOX,)), approach(-0.6, 0.4))
    count = about(things, 3.0, 0.0)
    assert count
    look(things, World((BOX,)), [Pose2(2.0, 0.0, 0.0)] * 2, 3.2e7)
    assert about(things, 3.0, 0.0) == count


def test_it_costs_no_more_far_from_the_maps_origin_nor_in_a_large_building() -> None:
    things = memory()
    far = np.array([2.0e4, 3.0e4])
    things.add_contacts(np.array([far, [0.0, 0.0]]), 1.0)
    stamp = look(things, World(()), [Pose2(far[0] + 1.0, far[1] + 1.0, 0.0)], 2.0)
    look(things, World(()), [Pose2(0.0, 100.0, 0.0)], stamp)
    assert things.cells_held < 10 * 64**2
    assert about(things, *far) == 1
    assert about(things, 0.0, 0.0) == 1
