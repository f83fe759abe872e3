"""The map drawn from keyframes: what moved is drawn again, what did not is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.map_rendering import GLANCES, ExtraView, MapRenderer
from app.modules.perception.slam.occupancy import OccupancyCounts, ScanView, view_of
from app.modules.perception.slam.types import Keyframe
from tests.modules.perception.slam.places import HALL, scan, way

WAY = way((1.5, 3.0), (10.0, 3.0), step_m=0.5)


def keyframe(number: int, pose: Pose2) -> Keyframe:
    view = view_of(scan(HALL, pose, seed=number))
    points = np.zeros((0, 4), np.float32)
    return Keyframe(number, 0.0, points, view.ends, view.met, np.array(view.sensor_xy, np.float32), 0.0)


KEYFRAMES = {number: keyframe(number, pose) for number, pose in enumerate(WAY)}
POSES = dict(enumerate(WAY))


def drawing() -> MapRenderer:
    return MapRenderer(OccupancyCounts(side_m=30))


def fresh(poses: dict[int, Pose2]) -> MapRenderer:
    made = drawing()
    assert not made.update(KEYFRAMES, poses, 1000)
    return made


def same(one: MapRenderer, other: MapRenderer) -> bool:
    return np.array_equal(one.counts.hits, other.counts.hits) and np.array_equal(one.counts.misses, other.counts.misses)


@settings(max_examples=15)
@given(st.lists(st.dictionaries(st.sampled_from(list(POSES)), st.floats(-0.5, 0.5)), max_size=3))
def test_however_it_came_about_it_is_the_map_of_where_keyframes_are_now(shifts: list[dict[int, float]]) -> None:
    made = drawing()
    poses = POSES
    for shift in shifts:
        # Half a cell and more, or none at all: less is not drawn again.
        poses = {id: Pose2(p.x, p.y + shift.get(id, 0.0), p.theta) for id, p in POSES.items() if id % 3 or id in shift}
        while made.update(KEYFRAMES, poses, 4):
            pass
    exact = drawing()
    exact.update(KEYFRAMES, {id: drawn.pose for id, drawn in made._drawn.items()}, 1000)
    assert same(made, exact)
    assert all(abs(made._drawn[id].pose.y - pose.y) <= 0.025 for id, pose in poses.items() if id in made._drawn)
    assert not shifts or made._drawn.keys() == poses.keys()


def test_it_stops_after_so_many_and_says_that_more_is_left() -> None:
    made = drawing()
    rounds = 0
    while made.update(KEYFRAMES, POSES, 5):
        rounds += 1
    assert rounds == (len(POSES) - 1) // 5
    assert same(made, fresh(POSES))


def test_less_than_half_a_cell_is_not_drawn_again_unless_it_turns() -> None:
    made = fresh(POSES)
    made.counts.refresh()
    made.update(KEYFRAMES, {id: Pose2(p.x + 0.01, p.y, p.theta) for id, p in POSES.items()})
    assert not made.counts.refresh()
    assert not made.update(KEYFRAMES, {id: Pose2(p.x, p.y, p.theta + 0.02) for id, p in POSES.items()}, 1000)
    assert made.counts.refresh()


def test_glances_move_with_their_keyframe_and_the_oldest_goes() -> None:
    made = fresh(POSES)
    before = made.counts.hits.sum()
    one = ScanView(np.array([[0.5, 0.0]], np.float32), np.array([True]), (0.0, 0.0))
    for _ in range(GLANCES + 5):
        made.extra_view(ExtraView(3, Pose2(0.1), one))
    made.extra_view(ExtraView(999, Pose2(), one))
    assert made.counts.hits.sum() - before == GLANCES
    shifted = {id: Pose2(p.x, p.y + 1.0, p.theta) for id, p in POSES.items()}
    made.update(KEYFRAMES, shifted, 1000)
    at = shifted[3] @ Pose2(0.6)
    column, row = (int(np.floor(v / 0.05)) - low for v, low in zip((at.x, at.y), made.counts.lowest, strict=True))
    assert made.counts.hits[row, column] >= GLANCES
    made.update(KEYFRAMES, {}, 1000)
    assert not made.counts.hits.any()


def test_the_map_is_the_place() -> None:
    made = fresh(POSES)
    made.counts.refresh()
    cells, (left, low) = made.counts.cells, made.counts.lowest
    rows, columns = np.nonzero(cells >= 65)
    x, y = (columns + left + 0.5) * 0.05, (rows + low + 0.5) * 0.05
    off = [min(_distance(px, py, wall) for wall in HALL) for px, py in zip(x, y, strict=True)]
    assert np.mean(off) == pytest.approx(0.0, abs=0.03)
    assert max(off) < 0.1


def _distance(x: float, y: float, wall: tuple[tuple[float, float], tuple[float, float]]) -> float:
    a, b = np.array(wall)
    along = b - a
    share = min(1.0, max(0.0, float(np.dot((x, y) - a, along) / np.dot(along, along))))
    return float(np.hypot(*((x, y) - (a + share * along))))
