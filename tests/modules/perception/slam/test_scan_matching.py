"""The matcher finds a scan's pose, and knows what it cannot know."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.correlative_matching import Pyramid, sought
from app.modules.perception.slam.scan_matching import fitted
from app.modules.perception.slam.scans import prepared
from app.modules.perception.slam.surfels import SurfelGrid, surfel_grid
from tests.modules.perception.slam.rooms import Walls, corridor, half_circle, room, seen

BEAMS = half_circle(361)
LOOSE = (1.0, 1.0)


def points(walls: Walls, pose: Pose2, noise_m: float = 0.0, seed: int = 0, near_m: float = 25.0) -> np.ndarray:
    ranges = seen(walls, BEAMS, pose) + np.random.default_rng(seed).normal(0.0, noise_m, len(BEAMS.angles))
    return prepared(ranges, BEAMS, (0.0, 0.0, 0.0), 0.0, near_m, 0.03).points


def grid_of(walls: Walls, poses: list[Pose2]) -> SurfelGrid:
    return surfel_grid((points(walls, pose), pose) for pose in poses)


@pytest.fixture(scope="module")
def furnished() -> SurfelGrid:
    """The room seen from its middle, all around."""
    return grid_of(room(), [Pose2(0, 1, turn) for turn in (0, math.pi / 2, math.pi, -math.pi / 2)])


@given(x=st.floats(-0.12, 0.12), y=st.floats(-0.12, 0.12), turn=st.floats(-0.08, 0.08), heading=st.floats(-3.1, 3.1))
@settings(max_examples=25, deadline=None)
def test_a_known_motion_is_found(furnished: SurfelGrid, x: float, y: float, turn: float, heading: float) -> None:
    true = Pose2(0.1, 1.1, heading)
    guess = Pose2(true.x + x, true.y + y, true.theta + turn)
    fit = fitted(furnished, points(room(), true), guess, guess, LOOSE)
    off = true.inverse() @ fit.X_SB
    assert math.hypot(off.x, off.y) < 0.02
    assert abs(off.theta) < 0.01
    assert fit.inliers > 0.5


def test_the_search_finds_what_the_matcher_alone_cannot(furnished: SurfelGrid) -> None:
    true = Pose2(0.3, 0.8, 0.4)
    guess = Pose2(1.1, 0.1, 0.9)
    scan = points(room(), true)
    assert math.dist((0.3, 0.8), (f := fitted(furnished, scan, guess, guess, LOOSE).X_SB, (f.x, f.y))[1]) > 0.1
    found = sought(Pyramid(furnished, 6), scan, guess, 1.5, 0.7, 0.5)
    assert found is not None
    fit = fitted(furnished, scan, found[0], found[0], LOOSE)
    assert math.dist((fit.X_SB.x, fit.X_SB.y), (0.3, 0.8)) < 0.02


def test_the_search_finds_nothing_where_nothing_is_alike() -> None:
    grid = grid_of(corridor(), [Pose2()])
    assert sought(Pyramid(grid, 4), points(room(), Pose2(0, 1, 0)), Pose2(), 1.0, 0.3, 0.7) is None


@given(heading=st.floats(-math.pi, math.pi))
@settings(max_examples=10, deadline=None)
def test_along_a_corridor_the_place_is_not_known_and_across_it_is(heading: float) -> None:
    c, s = math.cos(heading), math.sin(heading)
    walls = corridor()
    turned = np.column_stack([c * walls[:, ::2] - s * walls[:, 1::2], s * walls[:, ::2] + c * walls[:, 1::2]])[
        :, [0, 2, 1, 3]
    ]
    pose = Pose2(0, 0, heading)
    # Farther readings are so far apart that they are no wall.
    grid = surfel_grid([(points(turned, pose, near_m=8.0), pose)])
    fit = fitted(grid, points(turned, pose, 0.01, near_m=8.0), pose, pose, (0.1, 0.1))
    covariance = np.linalg.inv(fit.information + np.diag([1.0, 1.0, 1.0]))
    along = np.array([c, s, 0.0])
    across = np.array([-s, c, 0.0])
    assert along @ covariance @ along > 0.05**2  # noise turns normals a little: not quite unknown
    assert across @ covariance @ across < 0.01**2


def test_a_wall_is_not_taken_for_its_other_side() -> None:
    wall = np.array([(2.0, -10.0, 2.0, 10.0)])
    grid = grid_of(wall, [Pose2(0, 0, 0)])
    beyond = Pose2(4.0, 0, math.pi)
    assert fitted(grid, points(wall, beyond), beyond, beyond, LOOSE).inliers < 0.01


def test_a_grid_grows_to_all_sides_and_keeps_what_it_has() -> None:
    grid = SurfelGrid()
    walls = room()
    grid.insert(points(walls, Pose2(0, 1, 0)), Pose2(0, 1, 0))
    before = int((grid.surfels[..., 0] < 1e3).sum())
    for place in (Pose2(30, 0, 0), Pose2(-30, 0, 0), Pose2(0, 30, 0), Pose2(0, -30, 0)):
        grid.insert(points(walls, Pose2(0, 1, 0)), place)
    assert int((grid.surfels[..., 0] < 1e3).sum()) > 4 * before
    fit = fitted(grid, points(walls, Pose2(0, 1, 0)), Pose2(0, 1.05, 0), Pose2(0, 1.05, 0), LOOSE)
    assert math.dist((fit.X_SB.x, fit.X_SB.y), (0, 1)) < 0.01


def test_noise_reports_nothing_along_a_bare_corridor_and_does_not_carry_the_robot() -> None:
    ahead = half_circle(180)
    rng = np.random.default_rng(5)

    def noisy(pose: Pose2) -> np.ndarray:
        ranges = seen(corridor(), ahead, pose) + rng.uniform(-0.05, 0.05, 180)
        return prepared(ranges, ahead, (0.0, 0.0, 0.0), 0.0, 25.0, 0.03).points

    grid = surfel_grid((noisy(pose), pose) for pose in (Pose2(0.3 * k, 0.0, 0.0) for k in range(12)))
    pulls, along, across = [], [], []
    for k in range(30):
        true = Pose2(3.3 + 0.01 * k, 0.1, 0.02)
        fit = fitted(grid, noisy(true), true, true, (0.06, 0.04))
        pulls.append(fit.X_SB.x - true.x)
        along.append(fit.information[0, 0])
        across.append(fit.information[1, 1])
    assert abs(np.mean(pulls)) < 0.006
    assert np.mean(along) < 0.01 * np.mean(across)
