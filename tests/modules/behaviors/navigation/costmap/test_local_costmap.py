from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import FisheyeModel, Pose2, Pose3
from app.messages import Image
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings, CostmapWindow, LocalCostmap
from tests.modules.behaviors.navigation.boxes import CAMERA, World, looking
from tests.modules.behaviors.navigation.maps import ROUND

HERE = Pose2(0.0, 0.0, 0.0)
WALL = (1.5, -3.0, 1.7, 3.0, 0.0, 2.5)
PERSON = (1.0, -0.15, 1.2, 0.15, 0.0, 1.7)
#: Lower than the laser.
BOX = (3.0, -0.2, 3.3, 0.2, 0.0, 0.3)
SETTINGS = CostmapSettings(depth_step=1)


def costmap(settings: CostmapSettings = SETTINGS) -> LocalCostmap:
    return LocalCostmap(ROUND, 1.5, settings)


def occupied(around: CostmapWindow) -> NDArray[np.float64]:
    rows, columns = np.nonzero(around.cells == 100)
    return (
        np.stack((columns, rows), axis=-1) * around.resolution_m + np.array(around.origin) + 0.5 * around.resolution_m
    )


def near(around: CostmapWindow, x: float, y: float, within_m: float = 0.4) -> int:
    """How many occupied cells, remembered anywhere, are near a place."""
    away = np.hypot(around.obstacles[:, 0] - x, around.obstacles[:, 1] - y)
    return int((away < within_m).sum())


def at(around: CostmapWindow, x: float, y: float) -> tuple[int, int]:
    corner, resolution = around.origin, around.resolution_m
    return math.floor((y - corner[1]) / resolution), math.floor((x - corner[0]) / resolution)


def test_a_wall_stands_where_it_is_with_free_space_before_it_and_none_known_behind() -> None:
    here = costmap()
    here.add_scan(World((WALL,)).scan(1.0, HERE), HERE)
    seen = here.around(HERE, 1.0)
    assert seen.cells.shape == seen.distance.shape == (160, 160)
    assert seen.distance.dtype == np.float32
    assert np.abs(occupied(seen)[:, 0] - 1.5).max() < 0.05
    assert (seen.cells[at(seen, 1.0, 0.0)], seen.cells[at(seen, 1.8, 0.0)]) == (0, -1)
    for x, y in ((0.5, 0.0), (1.2, 1.0), (0.0, -1.5)):
        assert seen.distance[at(seen, x, y)] == pytest.approx(1.5 - x, abs=0.04)
    message = seen.to_message(7)
    assert (message.frame, message.version, message.cells.shape) == ("odom", 7, (160, 160))


def test_every_part_of_a_wall_is_seen() -> None:
    here = costmap()
    for k in range(3):
        here.add_scan(World((WALL,)).scan(k / 40, HERE), HERE)
    rows = np.unique(np.nonzero(here.around(HERE, 0.1).cells == 100)[0])
    assert len(rows) == 160, "at every height of the window"


@pytest.mark.parametrize("rate_hz", [40.0, 2.0])
def test_who_walked_away_leaves_nothing(rate_hz: float) -> None:
    here, with_person, without = costmap(), World((WALL, PERSON)), World((WALL,))
    for k in range(4):
        here.add_scan(with_person.scan(k / rate_hz, HERE), HERE)
    left = 3 / rate_hz
    assert near(here.around(HERE, left), 1.0, 0.0) > 5
    stamps = left + np.arange(1, math.ceil(rate_hz) + 1) / rate_hz
    for stamp in stamps[stamps <= left + 1.0]:
        here.add_scan(without.scan(float(stamp), HERE), HERE)
    gone = here.around(HERE, left + 1.0)
    assert near(gone, 1.0, 0.0) == 0
    assert near(gone, 1.5, 0.0) > 5, "the wall behind is there"


def test_who_was_seen_in_passing_is_forgotten_soon_and_what_stood_there_later() -> None:
    here = costmap()
    here.add_scan(World((PERSON,)).scan(0.0, HERE), HERE)
    back = Pose2(0.0, 0.0, math.pi)
    assert near(here.around(back, 2.9), 1.0, 0.0) > 0
    assert near(here.around(back, 3.2), 1.0, 0.0) == 0
    here = costmap()
    for k in range(6):
        here.add_scan(World((PERSON,)).scan(0.25 * k, HERE), HERE)
    assert near(here.around(back, 21.0), 1.0, 0.0) > 0
    assert near(here.around(back, 21.6), 1.0, 0.0) == 0


def test_a_box_under_the_lasers_plane_is_seen_from_afar_and_kept_while_the_camera_looks_over_it() -> None:
    world, eye = World((BOX, (6.0, -3.0, 6.2, 3.0, 0.0, 2.5))), looking(10.0)
    here = costmap()
    pose, stamp = Pose2(-1.0, 0.0, 0.0), 0.0
    while pose.x < 2.2:
        here.add_scan(world.scan(stamp, pose), pose)
        here.add_depth(world.depth(stamp, pose, eye), pose)
        stamp, pose = stamp + 0.1, Pose2(pose.x + 0.06, 0.0, 0.0)
    seen = here.around(pose, stamp)
    inside = occupied(seen)
    front = inside[np.abs(inside[:, 1]) < 0.15]
    assert front[:, 0].min() == pytest.approx(3.0, abs=0.06)
    assert seen.distance[at(seen, 2.5, 0.0)] == pytest.approx(0.5, abs=0.06)
    image = world.depth(stamp, pose, eye)
    assert image.depth is not None
    bottom = eye.translation[2] - (3.0 - pose.x - 0.05) * math.tan(math.radians(10 + 21.5))
    assert bottom > 0.3, "the camera sees it no more"


def test_without_depth_the_laser_does_not_see_that_box() -> None:
    here = costmap()
    here.add_scan(World((BOX,)).scan(0.0, HERE), HERE)
    assert not len(here.around(HERE, 0.0).obstacles)


def test_a_table_top_is_an_obstacle_though_the_laser_passes_under_it() -> None:
    table = (1.4, -0.5, 2.2, 0.5, 0.71, 0.74)
    world, here = World((table, (4.0, -3.0, 4.2, 3.0, 0.0, 2.5))), costmap()
    for k in range(20):
        here.add_scan(world.scan(k / 15, HERE), HERE)
        here.add_depth(world.depth(k / 15, HERE, looking(15.0)), HERE)
        seen = occupied(here.around(HERE, k / 15))
        assert ((seen[:, 0] > 1.35) & (seen[:, 0] < 1.5)).sum() > 10, "its near edge, all the time"


def test_the_floor_a_lamp_and_single_pixels_are_no_obstacles() -> None:
    lamp = (1.5, -0.2, 1.9, 0.2, 1.6, 1.8)
    world, here = World((lamp,)), costmap()
    for k in range(10):
        image = world.depth(k / 15, HERE, looking(12.0))
        assert image.depth is not None
        depth = image.depth.copy()
        depth[50, 50 + 2 * k] = 1200
        here.add_depth(Image(image.stamp, "kinect", image.color, depth, CAMERA, image.X_BC), HERE)
    assert not len(here.around(HERE, 0.6).obstacles)


@pytest.mark.parametrize("reach_m", [5.0, 9.0])
def test_what_the_camera_saw_it_clears_where_it_looks_through(reach_m: float) -> None:
    walls = (4.2, -4.0, 4.4, 4.0, 0.0, 2.5)
    here, eye = costmap(), looking(10.0)
    for k in range(30):
        here.add_depth(World((BOX, PERSON, walls)).depth(k / 15, HERE, eye, reach_m=reach_m), HERE)
    assert near(here.around(HERE, 2.0), 1.0, 0.0) > 5
    for k in range(30, 45):
        here.add_depth(World((BOX, walls)).depth(k / 15, HERE, eye, reach_m=reach_m), HERE)
    seen = here.around(HERE, 3.0)
    assert near(seen, 1.0, 0.0) == 0
    assert near(seen, 3.0, 0.0, 0.3) > 5, "the box behind has come into sight"


def test_what_a_person_covers_is_not_looked_through() -> None:
    wall = (4.2, -4.0, 4.4, 4.0, 0.0, 2.5)
    screen = (1.9, -0.3, 2.0, 0.3, 0.0, 1.3)
    here, eye = costmap(), looking(5.0)
    for k in range(20):
        here.add_depth(World((screen, wall)).depth(k / 15, HERE, eye), HERE)
    before = near(here.around(HERE, 1.3), 1.9, 0.0, 0.2)
    # Right before it, and wider than it
    for k in range(20, 32):
        here.add_depth(World((screen, wall, (1.6, -0.6, 1.7, 0.6, 0.0, 1.7))).depth(k / 15, HERE, eye), HERE)
    assert near(here.around(HERE, 2.1), 1.9, 0.0, 0.2) == before > 5


def test_what_was_taken_off_a_box_leaves_the_box_though_it_is_out_of_sight() -> None:
    wall, carton = (4.8, -4.0, 5.0, 4.0, 0.0, 2.5), (3.0, -0.2, 3.3, 0.2, 0.3, 0.9)
    here, eye, there = costmap(), looking(10.0), Pose2(1.5, 0.0, 0.0)
    for k in range(20):
        here.add_depth(World((BOX, carton, wall)).depth(k / 15, HERE, eye), HERE)
    for k in range(20, 40):
        here.add_depth(World((BOX, wall)).depth(k / 15, there, eye), there)
    assert near(here.around(there, 2.7), 3.0, 0.0, 0.25) > 5
    for k in range(40, 60):
        here.add_depth(World((wall,)).depth(k / 15, HERE, eye), HERE)
    assert near(here.around(HERE, 4.0), 3.0, 0.0, 0.4) == 0, "seen to be gone from where it can be seen"


def test_a_hole_in_the_picture_clears_nothing() -> None:
    here, eye = costmap(), looking(10.0)
    for k in range(20):
        here.add_depth(World((PERSON,)).depth(k / 15, HERE, eye), HERE)
    before = near(here.around(HERE, 1.3), 1.0, 0.0)
    for k in range(20, 40):
        image = World(()).depth(k / 15, HERE, eye)
        here.add_depth(Image(image.stamp, "kinect", image.color, np.zeros((120, 160), np.uint16), CAMERA, eye), HERE)
    assert near(here.around(HERE, 2.6), 1.0, 0.0) == before > 5


def test_an_edge_counts_where_that_is_wanted() -> None:
    world, eye = World((), hole=(1.6, -5.0, 9.0, 5.0)), looking(25.0)
    for drop_m, there in ((None, False), (0.15, True)):
        here = costmap(CostmapSettings(depth_step=1, drop_m=drop_m))
        here.add_depth(world.depth(0.0, HERE, eye), HERE)
        seen = here.around(HERE, 0.0).obstacles
        assert (len(seen) > 0) is there
        if there:
            assert seen[:, 0].min() == pytest.approx(1.6, abs=0.06)


def test_the_robot_itself_is_no_obstacle_and_where_it_stands_nothing_else_is() -> None:
    arm = (0.22, -0.1, 0.26, 0.1, 0.3, 1.2)
    here = costmap()
    scan = World(((0.15, 0.13, 0.25, 0.15, 0.3, 0.5),)).scan(0.0, HERE)
    assert np.isfinite(scan.ranges).any()
    here.add_scan(scan, HERE)
    image = World((arm,)).depth(0.0, HERE, looking(60.0))
    assert image.depth is not None
    assert ((image.depth > 0) & (image.depth < 800)).sum() > 20
    here.add_depth(image, HERE)
    assert not len(here.around(HERE, 0.0).obstacles)
    here.add_scan(World((PERSON,)).scan(0.1, HERE), HERE)
    there = Pose2(1.0, 0.0, 0.0)
    here.add_scan(World(()).scan(0.2, there), there)
    seen = here.around(there, 0.2).obstacles
    assert not ROUND.contains(seen - np.array([1.0, 0.0])).any()


def test_it_rolls_along_and_what_it_keeps_stays_in_its_place() -> None:
    pillars = tuple((x, y, x + 0.2, y + 0.2, 0.0, 2.0) for x in np.arange(-3.0, 14.0, 1.0) for y in (-1.0, 0.9))
    world, here = World(pillars), costmap()
    pose = HERE
    for k in range(60):
        pose = Pose2(0.2 * k, 0.1 * math.sin(0.3 * k), 0.3 * math.sin(0.2 * k))
        here.add_scan(world.scan(0.1 * k, pose), pose)
        seen = here.around(pose, 0.1 * k)
        row, column = at(seen, pose.x, pose.y)
        assert abs(row - 80) <= 1
        assert abs(column - 80) <= 1
        x, y = seen.obstacles.T
        gaps = [np.max([x0 - x, x - x1, y0 - y, y - y1], axis=0) for x0, y0, x1, y1, _, _ in pillars]
        assert np.min(gaps, axis=0).max() < 0.06
    behind = here.around(pose, 6.0).obstacles[:, 0]
    assert (behind < pose.x - 1.0).any(), "what was passed a moment ago is remembered"
    assert (behind > pose.x - 4.6).all()


def test_far_away_it_begins_again() -> None:
    here = costmap()
    here.add_scan(World((WALL,)).scan(0.0, HERE), HERE)
    assert not len(here.around(Pose2(100.0, -100.0, 0.0), 0.1).obstacles)


def test_scans_of_a_turning_robot_are_straightened() -> None:
    world = World((WALL,))
    begin, end = Pose2(0.0, 0.0, -0.1), Pose2(0.05, 0.0, 0.1)
    scan = world.scan(0.0, begin, end, noise_m=0.0)
    straight, skewed = costmap(), costmap()
    straight.add_scan(scan, begin, end)
    skewed.add_scan(scan, begin)
    assert np.ptp(occupied(straight.around(end, 0.0))[:, 0]) < 0.03
    assert np.ptp(occupied(skewed.around(end, 0.0))[:, 0]) > 0.1


def test_it_does_not_matter_where_odom_begins() -> None:
    wall = (1.01, -3.01, 1.2, 3.0, 0.0, 2.5)
    here = costmap()
    here.add_scan(World((wall,)).scan(0.0, HERE, noise_m=0.0), HERE)
    there = Pose2(-250.0, 400.0, 0.0)
    moved = costmap()
    moved.add_scan(World((wall,)).scan(0.0, HERE, noise_m=0.0), there)
    a, b = here.around(HERE, 0.0), moved.around(there, 0.0)
    assert (
        np.abs(np.sort(a.obstacles, axis=0) + np.array([-250.0, 400.0]) - np.sort(b.obstacles, axis=0)).max() < 0.0251
    )


@pytest.mark.parametrize("after_s", [1e6, 2**31 / 1000, 2**32 / 1000, 1e8])
def test_after_weeks_it_sees_and_forgets_as_on_the_first_day(after_s: float) -> None:
    with_person, without = World((WALL, PERSON)), World((WALL,))
    for begin in (after_s - 0.2, after_s):
        here = costmap()
        here.add_scan(without.scan(0.0, HERE), HERE)
        here.add_scan(with_person.scan(begin, HERE), HERE)
        assert near(here.around(HERE, begin), 1.0, 0.0) > 5
        here.add_scan(without.scan(begin + 0.5, HERE), HERE)
        assert near(here.around(HERE, begin + 0.5), 1.0, 0.0) == 0, "looked through"


def test_measurements_that_are_none_say_nothing() -> None:
    scan = World((WALL,)).scan(0.0, HERE)
    for value in (math.nan, 0.0, 0.05):
        here = costmap()
        scan.ranges[:] = value
        here.add_scan(scan, HERE)
        seen = here.around(HERE, 0.0)
        assert not len(seen.obstacles)
        assert (seen.cells == -1).all()


def test_cleared_it_knows_nothing() -> None:
    here = costmap()
    here.add_scan(World((WALL,)).scan(0.0, HERE), HERE)
    here.clear()
    seen = here.around(HERE, 0.0)
    assert (seen.cells == -1).all()
    assert seen.distance.min() >= 8.0


def test_only_depth_of_a_pinhole_will_do() -> None:
    color = np.zeros((4, 4, 3), np.uint8)
    fisheye = FisheyeModel.from_fov(4, 4, math.pi, math.pi)
    for image in (
        Image(0.0, "panorama", color, np.ones((4, 4), np.uint16), fisheye, looking()),
        Image(0.0, "camera", color, None, CAMERA, looking()),
    ):
        with pytest.raises(ValueError, match=f"{image.frame} gives none"):
            costmap().add_depth(image, HERE)


def test_a_laser_mounted_upside_down_marks_the_same() -> None:
    scan = World(((1.5, 0.3, 1.7, 0.6, 0.0, 1.0),)).scan(0.0, Pose2())
    hung = replace(
        scan,
        ranges=scan.ranges[::-1],
        X_BL=scan.X_BL @ Pose3.from_translation_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0)),
    )
    cells = []
    for each in (scan, hung):
        around = costmap()
        around.add_scan(each, HERE)
        cells.append(around.around(HERE, 0.0).cells)
    assert (cells[0] == 100).sum() > 5
    assert (cells[0] != cells[1]).mean() < 1e-3
