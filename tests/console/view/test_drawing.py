"""From messages to what is drawn."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.console.view.drawing import FAR_M, colors_along_x, moved, point_size, pose_arrays, scan_points, thinned
from app.messages import LaserScan


def test_scan_points_are_where_the_rays_hit() -> None:
    ranges = np.array([2.0, np.inf, 3.0, 0.05, 4.0], np.float32)
    X_BL = Pose3.from_translation_rpy((0.2, 0.0, 0.4))
    scan = LaserScan(1.0, "hokuyo_link", ranges, ranges, -math.pi / 2, math.pi / 4, 0.1, 30.0, 0.0125, X_BL)
    expected = [[0.2, -2.0, 0.4], [3.2, 0.0, 0.4], [0.2, 4.0, 0.4]]
    points = scan_points(scan)
    assert points.dtype == np.float32
    np.testing.assert_allclose(points, expected, atol=1e-5)


def test_laser_points_go_from_red_to_blue_along_x() -> None:
    x = np.linspace(-1, 2 * FAR_M, 50)
    colors = colors_along_x(np.stack([x, 0 * x, 0 * x], axis=1))
    red, blue = colors[:, 0].astype(int), colors[:, 2].astype(int)
    assert red[0] > 200 > blue[0]
    assert blue[-1] > 200 > red[-1]
    assert (np.diff(red) <= 0).all()
    assert (np.diff(blue) >= 0).all()


@given(st.integers(0, 100_000), st.integers(1, 80_000))
def test_a_cloud_is_thinned_evenly(count: int, most: int) -> None:
    chosen = thinned(count, most)
    assert len(chosen) == min(count, most)
    assert (np.diff(chosen) > 0).all(), "in order, none twice"
    taken = np.zeros(count, np.intp)
    taken[chosen] = 1
    for bits in range(1, max(count - 1, 1).bit_length()):
        size = 1 << bits
        stretches = taken[: count - count % size].reshape(-1, size).sum(axis=1)
        assert np.ptp(stretches) <= 1 if len(stretches) else True, f"stretches of {size}"


@given(st.integers(1, 30_000), st.integers(1, 30_000), st.integers(1, 30_000))
def test_a_smaller_budget_takes_of_what_a_larger_one_takes(count: int, a: int, b: int) -> None:
    assert set(thinned(count, min(a, b)).tolist()) <= set(thinned(count, max(a, b)).tolist())


@pytest.mark.parametrize("most", [400, 1200, 4_000, 9_000])
def test_a_thinned_picture_has_no_stripes(most: int) -> None:
    """Rows of 160 pixels, 120 of them: no direction repeats itself, as it does where every n-th pixel is taken."""

    def strongest_wave(chosen: NDArray[np.intp]) -> float:
        picture = np.zeros(19_200)
        picture[chosen] = 1.0
        power = np.abs(np.fft.fft2(picture.reshape(120, 160) - picture.mean())) ** 2
        return float(power.max() / power.mean())

    regular = strongest_wave(np.linspace(0, 19_199, most).astype(np.intp))
    assert strongest_wave(thinned(19_200, most)) < 40 < regular


def test_few_points_are_drawn_larger() -> None:
    sizes = [point_size(count) for count in (0, 400, 4_000, 19_200, 76_800)]
    assert sizes == sorted(sizes, reverse=True)
    assert 0.01 < sizes[-1] < sizes[0] < 0.07


def test_a_pose_is_the_same_in_the_scene() -> None:
    pose = Pose2(1.0, -2.0, 2.5)
    wxyz, position = pose_arrays(pose)
    assert position == (1.0, -2.0, 0.0)
    np.testing.assert_allclose(np.abs(wxyz), np.abs(pose.to_pose3().quaternion_wxyz()), atol=1e-12)


@pytest.mark.parametrize(
    ("now", "seen"),
    [(Pose2(), False), (Pose2(5e-4, 0, 0), False), (Pose2(0.01, 0, 0), True), (Pose2(0, 0, 0.01), True)],
)
def test_what_no_eye_could_see_is_not_sent(now: Pose2, seen: bool) -> None:
    assert moved(Pose2(0, 0, math.tau), now) is seen
    assert moved(None, now)
