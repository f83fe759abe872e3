"""Looking for the robot on a whole map: found where it is, and never where it is not."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.messages import OccupancyGrid
from app.modules.perception.slam.likelihood_field import LikelihoodField, _solved
from app.modules.perception.slam.occupancy import view_of
from app.modules.perception.slam.relocalization import PoseSearch, SearchScan, spread
from tests.modules.perception.slam.places import HALL, Segment, box, drawn, polygon, scan, way

#: Where odometry is in the world: nothing that a map could know.
X_WO = Pose2(-3.0, 7.0, 2.0)


def sighting(walls: Sequence[Segment], X_WB: Pose2, seed: int, drift: Pose2 | None = None) -> SearchScan:
    view = view_of(scan(walls, X_WB, seed=seed))
    X_OB = X_WO.inverse() @ X_WB
    return SearchScan(view.ends[view.met].astype(np.float64), np.array(view.sensor_xy), X_OB @ drift if drift else X_OB)


def sought(grid: OccupancyGrid, walls: Sequence[Segment], poses: Sequence[Pose2]) -> tuple[float, Pose2] | None:
    """How far the robot went until it believed a place, and where it believed to be; None if it never did."""
    search = PoseSearch(LikelihoodField(grid))
    gone = 0.0
    for number, (before, pose) in enumerate(zip((poses[0], *poses), poses, strict=False)):
        gone += math.dist((before.x, before.y), (pose.x, pose.y))
        seen = sighting(walls, pose, number)
        if (X_MO := search.see(seen)) is not None:
            return gone, X_MO @ seen.X_OB
    return None


@pytest.fixture(scope="module")
def hall() -> OccupancyGrid:
    return drawn(HALL, (12, 8))


WAYS = {
    "along": way((1.0, 3.5), (8.0, 3.5)),
    "back": way((8.0, 1.0), (1.0, 4.0)),
    "room": way((1.0, 7.0), (5.0, 6.5), (3.6, 4.0)),
    "far end": way((11.0, 7.0), (8.0, 6.0), (8.0, 1.0)),
    "niche": way((11.0, 1.0), (11.5, 3.0), (8.0, 1.0)),
}


@pytest.mark.parametrize("name", WAYS)
def test_it_is_found_where_it_is_within_a_few_metres(hall: OccupancyGrid, name: str) -> None:
    found = sought(hall, HALL, WAYS[name])
    assert found is not None
    gone, X_MB = found
    assert gone < 2.5
    nearest = min(WAYS[name], key=lambda p: math.dist((p.x, p.y), (X_MB.x, X_MB.y)))
    assert math.dist((nearest.x, nearest.y), (X_MB.x, X_MB.y)) < 0.06
    assert any(
        math.dist((p.x, p.y), (X_MB.x, X_MB.y)) < 0.1 and abs(math.remainder(p.theta - X_MB.theta, math.tau)) < 0.05
        for p in WAYS[name]
    )


def test_nothing_is_believed_before_it_moved(hall: OccupancyGrid) -> None:
    search = PoseSearch(LikelihoodField(hall))
    pose = WAYS["along"][0]
    for number in range(50):
        assert search.see(sighting(HALL, pose, number)) is None
    assert search.hypotheses, "though it has an idea"
    best = search.hypotheses[0].X_MO @ (X_WO.inverse() @ pose)
    assert math.dist((best.x, best.y), (pose.x, pose.y)) < 0.1


def test_a_place_that_is_not_on_the_map_is_never_believed(hall: OccupancyGrid) -> None:
    elsewhere = [*polygon((0, 0), (9, 0), (6, 7), (0, 4)), *box(4, 2, 0.8, 0.8), *box(1, 1, 0.3, 1.4)]
    assert sought(hall, elsewhere, way((3.0, 3.5), (3.0, 0.5), (7.0, 1.0), (5.5, 5.0))) is None


#: Two corridors alike but for the box at the far end of one.
TWINS = [
    *box(0, 0, 14, 2),
    *box(0, 4, 14, 2),
    *box(13.2, 1.2, 0.5, 0.5),
    *box(0.4, 0, 0.4, 0.6),
    *box(0.4, 4, 0.4, 0.6),
]


def test_of_two_corridors_that_look_alike_none_is_believed_until_they_differ() -> None:
    grid = drawn(TWINS, (14, 6))
    # Facing away from where they differ, all the way.
    westward = [Pose2(x, y, math.pi) for x, y in ((12.0 - 0.2 * n, 5.0) for n in range(50))]
    search = PoseSearch(LikelihoodField(grid))
    for number, pose in enumerate(westward):
        assert search.see(sighting(TWINS, pose, number)) is None
    at = [place.X_MO @ (X_WO.inverse() @ westward[-1]) for place in search.hypotheses]
    assert {round(pose.y) for pose in at[:4]} >= {1, 5}, "both stay possible"
    # Turning round, it sees the far end: there is no box.
    turn = [Pose2(westward[-1].x, 5.0, math.pi - 0.4 * n) for n in range(8)]
    eastward = [Pose2(westward[-1].x + 0.2 * n, 5.0, 0.0) for n in range(40)]
    for number, pose in enumerate([*turn, *eastward]):
        seen = sighting(TWINS, pose, 1000 + number)
        if (X_MO := search.see(seen)) is not None:
            X_MB = X_MO @ seen.X_OB
            assert (X_MB.x, X_MB.y) == pytest.approx((pose.x, pose.y), abs=0.1)
            return
    pytest.fail("never found")


def test_people_around_it_do_not_hide_where_it_is(hall: OccupancyGrid) -> None:
    rng = np.random.default_rng(5)
    search = PoseSearch(LikelihoodField(hall))
    for number, pose in enumerate(WAYS["along"]):
        legs = [piece for x, y in rng.uniform((1, 2), (10, 5), (3, 2)) for piece in box(x, y, 0.3, 0.3)]
        seen = sighting([*HALL, *legs], pose, number)
        if (X_MO := search.see(seen)) is not None:
            X_MB = X_MO @ seen.X_OB
            assert math.dist((X_MB.x, X_MB.y), (pose.x, pose.y)) < 0.1
            return
    pytest.fail("never found")


def test_an_empty_map_has_no_places() -> None:
    grid = OccupancyGrid(0.0, "map", np.full((100, 100), -1, np.int8), 0.05, (0.0, 0.0), 1)
    search = PoseSearch(LikelihoodField(grid))
    assert search.see(sighting(HALL, WAYS["along"][0], 0)) is None
    assert search.hypotheses == ()


def test_spread_points_stand_for_the_near_and_the_far() -> None:
    near = np.random.default_rng(1).normal((1.0, 0.0), 0.02, (900, 2))
    far = np.stack((np.full(50, 8.0), np.linspace(-4, 4, 50)), axis=1)
    kept = spread(np.concatenate((near, far)), 40)
    assert len(kept) <= 40
    assert (kept[:, 0] > 7).sum() > 25


def test_a_step_of_the_descent_solves_its_equations() -> None:
    rng = np.random.default_rng(4)
    for scale in (1e-3, 1.0, 1e3):
        slopes = scale * rng.standard_normal((3, 20))
        h, g = np.eye(3) + slopes @ slopes.T, rng.standard_normal(3)
        np.testing.assert_allclose(_solved(h, g), np.linalg.solve(h, g), rtol=1e-9)
