from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3, wrap_angle
from app.messages import LaserScan
from app.modules.perception.laser_ray import WallPoint, scan_points, wall_on_ray

HERE = Pose2()
SPACING = math.pi / 719
X_BL = Pose3.from_translation_rpy((0.2, 0.0, 0.4))
#: The camera, in base_link.
CAMERA = np.array([0.05, 0.0, 1.3])

Wall = tuple[tuple[float, float], tuple[float, float]]


def scan_of(
    walls: list[Wall], begin: Pose2 = HERE, end: Pose2 | None = None, noise_m: float = 0.0, seed: int = 0
) -> LaserScan:
    """What a laser that moves from ``begin`` to ``end`` (X_OB) during its sweep sees of upright ``walls`` in odom."""
    angles = -math.pi / 2 + SPACING * np.arange(720)
    ranges = np.full(720, np.inf)
    poses = [begin] * 720 if end is None else [begin.interpolate(end, i / 719) for i in range(720)]
    theta = np.array([pose.theta for pose in poses])
    offset = X_BL.translation[0]
    x = np.array([pose.x for pose in poses]) + offset * np.cos(theta)
    y = np.array([pose.y for pose in poses]) + offset * np.sin(theta)
    dx, dy = np.cos(theta + angles), np.sin(theta + angles)
    for (ax, ay), (bx, by) in walls:
        wx, wy = bx - ax, by - ay
        with np.errstate(divide="ignore", invalid="ignore"):
            det = dy * wx - dx * wy
            r = ((ay - y) * wx - (ax - x) * wy) / det
            share = (dx * (ay - y) - dy * (ax - x)) / det
        ranges = np.where((r > 0.1) & (share >= 0) & (share <= 1), np.minimum(ranges, r), ranges)
    ranges += np.random.default_rng(seed).normal(0, noise_m, 720)
    return LaserScan(
        0.0, "laser", ranges.astype(np.float32), np.ones(720, np.float32), angles[0], SPACING, 0.1, 30.0, 0.0125, X_BL
    )


def meet(scan: LaserScan, direction: tuple[float, float, float], X_OB: Pose2 = HERE) -> WallPoint | None:
    points = scan_points(scan, X_OB, X_OB)
    x, y, _ = (X_OB.to_pose3() @ X_BL).translation
    ray = np.array(direction) / np.linalg.norm(direction)
    return wall_on_ray(points, (x, y), SPACING, X_OB.to_pose3().transform(CAMERA).astype(np.float64), ray, 0.005)


@example(3.0, 23.0, -43.0, 0.0, 0.0, 0.0, 0.0)
@given(
    st.floats(0.6, 3.0),
    st.floats(-65, 65),
    st.floats(-60, 60),
    st.floats(-50, 20),
    st.floats(-3, 3),
    st.floats(-3, 3),
    st.floats(-3, 3),
)
def test_a_long_wall_at_a_known_pose_is_met_where_the_ray_meets_its_plane(
    distance: float, turn_deg: float, azimuth_deg: float, elevation_deg: float, x: float, y: float, theta: float
) -> None:
    """Whatever the robot's pose, the wall's and the ray's: the point is the plane's, exactly."""
    X_OB = Pose2(x, y, theta)
    turn, azimuth, elevation = (math.radians(a) for a in (turn_deg, azimuth_deg, elevation_deg))
    # The wall lies across the direction `turn` from the laser, in base_link.
    normal = np.array([math.cos(turn), math.sin(turn), 0.0])
    foot = X_BL.translation + distance * normal
    across = np.array([-normal[1], normal[0], 0.0])
    ends = X_OB.to_pose3().transform(np.stack((foot - 20 * across, foot + 20 * across)))
    ray = np.array(
        [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
    )
    sine = float(ray @ normal) / math.cos(elevation)
    assume(sine > 0.3)
    range_m = float((foot - CAMERA) @ normal) / float(ray @ normal)
    expected = CAMERA + range_m * ray
    # Seen by the laser well within its half circle, and above the ground.
    seen = expected - X_BL.translation
    assume(abs(math.atan2(seen[1], seen[0])) < math.radians(80) and expected[2] > 0.01)
    scan = scan_of([(tuple(ends[0][:2]), tuple(ends[1][:2]))], X_OB)
    hit = meet(scan, tuple(X_OB.to_pose3().rotation @ ray), X_OB)
    assert hit is not None
    np.testing.assert_allclose(hit.point, X_OB.to_pose3().transform(expected), atol=2e-3)
    assert abs(wrap_angle(hit.heading - (theta + turn + math.pi))) < hit.heading_sigma
    assert hit.range_m == pytest.approx(range_m, abs=2e-3)
    assert hit.sigma_m >= 0.005 * range_m


def test_noise_is_averaged_and_the_sigma_reports_it() -> None:
    errors, sigmas = [], []
    for seed in range(40):
        hit = meet(scan_of([((1.5, -3), (1.5, 3))], noise_m=0.01, seed=seed), (1.0, 0.3, 0.0))
        assert hit is not None
        errors.append(hit.point[0] - 1.5)
        sigmas.append(hit.sigma_m)
    assert np.std(errors) < 0.004
    assert np.std(errors) < np.mean(sigmas) < 0.02


def test_a_slanting_wall_is_less_certain() -> None:
    straight = meet(scan_of([((1.5, -5), (1.5, 5))]), (1.0, 0.0, 0.0))
    slanting = meet(scan_of([((0.5, -1.0), (4.5, 2.0))]), (1.0, 0.0, 0.0))
    assert straight is not None
    assert slanting is not None
    assert slanting.sigma_m / slanting.range_m > 1.3 * straight.sigma_m / straight.range_m


@pytest.mark.parametrize(
    ("walls", "direction"),
    [
        pytest.param([], (1, 0, 0), id="nothing there"),
        pytest.param([((2, -3), (2, -0.2)), ((2, 0.2), (2, 3))], (1, 0, 0), id="an open door"),
        pytest.param([((1.2, -3), (1.2, 0)), ((2.2, -3), (2.2, 3))], (1, 0.005, 0), id="the edge of a cupboard"),
        pytest.param([((0, 0.4), (20, 0.4))], (1, 0.05, 0), id="nearly along the wall"),
        pytest.param([((2, -3), (2, 3))], (0.2, 0, 1), id="towards the ceiling"),
        pytest.param([((2, -3), (2, 3))], (1, 0, -1.2), id="below the ground"),
        pytest.param([((2, -3), (2, 3))], (-1, 0, 0), id="behind"),
        pytest.param([((1.5, -0.03), (1.5, 0.03))], (1, 0, 0), id="too narrow"),
        pytest.param([((1.4, 0.6), (2, 0)), ((2, 0), (1.4, -0.6))], (1, 0, 0), id="into a corner"),
    ],
)
def test_where_it_is_not_clear_there_is_no_place(walls: list[Wall], direction: tuple[float, float, float]) -> None:
    assert meet(scan_of(walls, noise_m=0.003), direction) is None


def test_the_nearest_wall_counts() -> None:
    hit = meet(scan_of([((1.2, -0.5), (1.2, 0.5)), ((3, -3), (3, 3))]), (1.0, 0.1, -0.2))
    assert hit is not None
    assert hit.point[0] == pytest.approx(1.2, abs=1e-3)


def test_echoes_too_near_or_too_far_are_none() -> None:
    scan = scan_of([((1.5, -5), (1.5, 5))])
    ranges: NDArray[np.float32] = scan.ranges.copy()
    ranges[300:420] = 0.02
    ranges[100] = np.inf
    points = scan_points(
        LaserScan(0, "laser", ranges, ranges, scan.angle_min, SPACING, 0.1, 30.0, 0.0, X_BL), Pose2(), Pose2()
    )
    assert np.isnan(points[300:420]).all()
    assert np.isnan(points[100]).all()
    assert wall_on_ray(points, (0.2, 0.0), SPACING, CAMERA, np.array([1.0, 0.0, 0.0]), 0.0) is None


@given(st.floats(-3, 3), st.floats(-0.02, 0.02), st.floats(-0.02, 0.02))
def test_each_ray_is_placed_by_its_own_pose(theta: float, moved: float, turned: float) -> None:
    """A wall seen by a robot that drives and turns during the sweep comes out straight, where it is."""
    begin = Pose2(1.0, 2.0, theta)
    end = begin @ Pose2(moved, 0.3 * moved, turned)
    a, b = (begin.to_pose3().transform(np.array([1.5, y, 0.0])) for y in (-4.0, 4.0))
    points = scan_points(scan_of([(tuple(a[:2]), tuple(b[:2]))], begin, end), begin, end)
    assert abs(wrap_angle(end.theta - begin.theta) - turned) < 1e-9
    normal = np.array([math.cos(theta), math.sin(theta)])
    off = (points - a[:2]) @ normal
    assert np.nanmax(np.abs(off)) < 1e-4
