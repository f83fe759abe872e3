"""SLAM2D among walls that a test draws: maps, follows on, says when it does not know."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.base import compiled
from app.base.geometry import Pose2, Pose3
from app.maps.library import MapLibrary
from app.messages import OccupancyGrid, Odometry, read_only
from app.modules.perception.slam_2d import SLAM2D
from app.runtime.filter import CLOSED
from tests.modules.perception.slam.hall_drive import ROUND, Body, live
from tests.modules.perception.slam.places import HALL, drawn, polygon, scan, way


@pytest.fixture(scope="module", autouse=True)
def _kernels() -> None:
    """Virtual time waits for no compiler."""
    compiled.make_ready()


@pytest.fixture
def library(tmp_path: Path) -> MapLibrary:
    return MapLibrary(tmp_path)


@pytest.mark.slow
def test_it_maps_and_knows_where_it_is_though_wheels_slip(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND)
        await body.stand(1.5)

    body = live(script, library)
    assert len(body.explained_each) == len(ROUND) + 15, "one for each scan"
    assert body.states() == ["mapping"]
    assert body.is_within(0.05, 0.02)
    last = body.explained_each[-1]
    graph = body.keyframes[-1]
    assert (graph.X_MO, graph.X_MB, graph.state) == (last.X_MO, last.X_MB, "mapping")
    assert graph.ids.tolist() == sorted(set(graph.ids.tolist()))
    assert graph.keyframe in graph.ids
    assert (len(graph.poses), len(graph.travelled_m)) == (len(graph.ids), len(graph.ids))
    x, y, _ = graph.poses[graph.ids.tolist().index(graph.keyframe)]
    assert math.hypot(x - last.X_MB.x, y - last.X_MB.y) < 2.0
    assert [one.version for one in body.keyframes] == list(range(1, len(ROUND) + 17)), "one at the begin"
    assert last.map == ""
    assert last.overlap > 0.9
    assert 0 < math.sqrt(last.covariance[0, 0]) < 0.05
    off = last.X_MO.inverse() @ (last.X_MB @ body.X_OB.inverse())
    assert (off.x, off.y, off.theta) == pytest.approx((0, 0, 0), abs=1e-9)
    grid = body.maps[-1]
    assert [m.version for m in body.maps] == sorted({m.version for m in body.maps})
    assert (grid.frame, grid.resolution_m, grid.cells.shape, grid.origin) == ("map", 0.05, (1000, 1000), (-25.0, -25.0))
    assert all(b.stamp - a.stamp >= 0.99 for a, b in zip(body.maps[1:], body.maps[2:], strict=False)), "1 s at most"
    true = drawn(HALL, (12, 8))
    walls = grid.cells >= 65
    rows, columns = np.nonzero(walls)
    x, y = ((v + 0.5) * 0.05 - 25.0 for v in (columns, rows))
    x, y = x + ROUND[0].x, y + ROUND[0].y
    near = true.cells >= 65
    at = np.floor((np.stack((y, x), axis=1) + 0.5) / 0.05).astype(int)
    around = [near[max(0, r - 2) : r + 3, max(0, c - 2) : c + 3].any() for r, c in at]
    assert np.mean(around) > 0.97, "what is drawn stands within 0.1 m of a wall"


def test_a_map_is_reported_only_when_it_changed(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND[:20])
        await body.stand(12.0)
        explained_each = len(body.maps)
        await body.stand(10.0)
        assert len(body.maps) == explained_each

    live(script, library)


def test_who_stood_by_fades_after_they_left(library: MapLibrary) -> None:
    person = [((3.4, 2.9), (3.4, 3.1)), ((3.4, 3.1), (3.6, 3.1))]

    def there(grid: OccupancyGrid) -> int:
        column, row = (int((v + 25.0) / 0.05) for v in (3.4 - 1.5 + 0.01, 3.0 - 3.0 + 0.01))
        return int(grid.cells[row - 1 : row + 2, column - 1 : column + 2].max())

    async def script(body: Body) -> None:
        body.walls = [*HALL, *person]
        await body.stand(6.0)
        assert there(body.maps[-1]) == 100
        body.walls = HALL
        await body.stand(15.0)
        assert there(body.maps[-1]) < 30

    live(script, library)


@pytest.mark.parametrize("every", [4, 12])
def test_it_follows_at_a_fraction_of_the_scans(library: MapLibrary, every: int) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND, every=every)
        await body.stand(0.3)

    assert live(script, library).is_within(0.1, 0.04)


def test_closed_scans_leave_it_to_odometry_and_then_it_goes_on(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        filters = body.bench.graph.filters
        await body.go(ROUND[:80])
        explained_each = len(body.explained_each)
        filters.apply({"Tested.scans": CLOSED})
        await body.go(ROUND[80:120])
        assert len(body.explained_each) == explained_each
        off = (ROUND[0] @ body.explained_each[-1].X_MO @ body.X_OB).inverse() @ body.X_WB
        assert math.hypot(off.x, off.y) < 0.2, "its place is known by odometry"
        filters.apply({"Tested.scans": 1})
        await body.go(ROUND[120:])

    body = live(script, library)
    assert body.is_within(0.06, 0.02)
    assert body.states() == ["mapping"]


def test_whatever_begins_or_ends_mapping_the_way_since_the_last_scan_counts(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        filters = body.bench.graph.filters
        await body.go(ROUND[:80])
        explained_each = len(body.explained_each)
        filters.apply({"Tested.scans": CLOSED})
        await body.go(ROUND[80:120])
        body.bench.slot.configure({"mapping": False})
        filters.apply({"Tested.scans": 1})
        await body.go(ROUND[118:121])
        for place in body.explained_each[explained_each:]:
            assert place.state == "tracking"
        assert body.is_within(0.2, 0.05)

    live(script, library)


def test_a_robot_that_was_carried_off_adds_nothing_to_the_map(library: MapLibrary) -> None:
    def keyframes(body: Body) -> int:
        module = body.bench.slot.context.instance
        assert isinstance(module, SLAM2D)
        return len(module.session.snapshot().keyframes)

    async def script(body: Body) -> None:
        await body.go(ROUND[:60])
        at = body.X_WB
        body.walls, body.X_WB = polygon((0, 0), (5, 0), (3, 4)), Pose2(1.5, 1.0)
        await body.stand(8.0)
        assert body.state == "lost"
        known, drawn_then = keyframes(body), body.maps[-1]
        await body.go(way((1.5, 1.0), (3.0, 1.0), (2.0, 1.5)))
        assert body.state == "lost"
        assert keyframes(body) == known
        assert body.maps[-1] is drawn_then
        body.walls, body.X_WB = HALL, at
        await body.control.server.place(ROUND[0].inverse() @ at)
        await body.go(ROUND[60:100])
        assert body.state == "mapping"
        assert keyframes(body) > known

    assert live(script, library).is_within(0.06, 0.02)


def test_a_robot_that_is_placed_where_it_is_not_adds_nothing_to_the_map(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND[:60])
        await body.stand(2.0)
        drawn = body.maps[-1]
        await body.control.server.place(Pose2(100.0, 100.0))
        await body.go(ROUND[60:80])
        await body.stand(2.0)
        assert body.states()[-1] == "lost"
        assert body.maps[-1] is drawn
        await body.control.server.place(ROUND[0].inverse() @ body.X_WB)
        await body.go(ROUND[80:120])
        assert body.state == "mapping"

    assert live(script, library).is_within(0.06, 0.02)


def test_odometry_that_begins_again_moves_no_robot(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND[:60])
        body.X_OB = Pose2(900.0, -3.0, 2.0)
        await body.bench.clock.sleep(0.3)
        await body.go(ROUND[60:90])

    body = live(script, library)
    assert body.states() == ["mapping"]
    assert body.is_within(0.06, 0.02)
    assert body.maps[-1].cells.shape == (1000, 1000)


def test_a_laser_may_hang_upside_down(library: MapLibrary) -> None:
    down = Pose3.from_translation_rpy((0.2, 0.0, 0.4), (math.pi, 0.0, 0.0))

    async def script(body: Body) -> None:
        for pose in ROUND[:80]:
            step = body.X_WB.inverse() @ pose
            body.X_WB, body.X_OB = pose, body.X_OB @ step
            now = body.bench.clock.now()
            body.bench.feed("odometry", Odometry(now, body.X_OB, 0.0, 0.0))
            body._scans += 1
            upright = scan(HALL, pose, now, seed=body._scans)
            body.bench.feed("scans", replace(upright, ranges=read_only(upright.ranges[::-1].copy()), X_BL=down))
            await body.bench.clock.sleep(0.1)

    body = live(script, library)
    assert body.is_within(0.05, 0.02)
    # The wall on the left of the start is 2 m away, that on the right 3 m.
    grid = body.maps[-1]
    rows = np.flatnonzero((grid.cells[:, 505:515] >= 65).any(axis=1)) * 0.05 - 25.0
    assert np.abs(rows - 2.0).min() < 0.1
    assert np.abs(rows + 3.0).min() < 0.1
    assert np.abs(rows - 3.0).min() > 0.5


def test_scans_whose_pose_never_comes_are_left_out(library: MapLibrary, caplog: pytest.LogCaptureFixture) -> None:
    async def script(body: Body) -> None:
        for _ in range(3):
            body.bench.feed("scans", scan(HALL, body.X_WB, body.bench.clock.now() + 1.0))
            await body.bench.clock.sleep(0.5)
        assert body.explained_each == []
        await body.go(ROUND[:10])
        assert body.explained_each

    live(script, library)
    assert len([r for r in caplog.records if "odometry does not reach the stamps of scans" in r.message]) == 1


def test_mapping_may_be_left_to_others_and_fewer_rays_do(library: MapLibrary) -> None:
    async def script(body: Body) -> None:
        slot = body.bench.slot
        slot.configure({"rays": 3})
        await body.go(ROUND[:100])
        explained_each = len(body.maps)
        slot.configure({"mapping": False})
        back = ROUND[:100][::-1]
        await body.go(back)
        assert body.state == "tracking"
        assert len(body.maps) <= explained_each + 1
        slot.configure({})
        await body.go(ROUND[:20])
        assert body.state == "mapping"

    assert live(script, library).is_within(0.05, 0.02)
