"""SLAM2D among walls that a test draws: maps, keeps, finds itself, says when it does not know."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base import compiled
from app.base.geometry import Pose2, Pose3
from app.maps.library import GRAPH, MapLibrary
from app.maps.map_service import MapService, MapUnavailable
from app.messages import (
    Keyframes,
    LandmarkPose,
    LaserScan,
    Localization,
    OccupancyGrid,
    Odometry,
    Zone,
    Zones,
    read_only,
)
from app.modules.perception.slam.map_session import stored_map
from app.modules.perception.slam_2d import SLAM2D
from app.runtime.clock import run_virtual
from app.runtime.filter import CLOSED
from tests.modules.fakes import Bench, drain
from tests.modules.perception.slam.places import HALL, Segment, drawn, polygon, scan, way

ROUND = way(
    (1.5, 3.0), (8.0, 3.0), (8.0, 6.5), (10.5, 6.5), (10.5, 4.5), (8.0, 4.0), (1.5, 3.0), (3.6, 4.0), (3.6, 6.5)
)
STAIRS = Zone("stairs", "keep_out", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 1.0)
Script = Callable[["Body"], Awaitable[None]]


class Body:
    """A body that is wherever the test puts it, its odometry, and the module."""

    def __init__(self, library: MapLibrary, walls: Sequence[Segment] = HALL, **settings: Any) -> None:
        self.control = MapService()
        self.library = library
        self.walls = walls
        self.bench = Bench(
            "app.modules.perception.slam_2d:SLAM2D",
            inputs={"scans": LaserScan, "odometry": Odometry, "landmark_poses": LandmarkPose},
            outputs={"localization": Localization, "map": OccupancyGrid, "zones": Zones, "keyframes": Keyframes},
            services={MapLibrary: library, MapService: self.control},
            settings=settings,
        )
        self.X_WB = ROUND[0]
        self.X_OB = Pose2(4.0, -2.0, 1.0)
        self._scans = 0
        self.explained_each: list[Localization] = []
        self.maps: list[OccupancyGrid] = []
        self.keyframes: list[Keyframes] = []
        for port, kept in (
            ("localization", self.explained_each), ("map", self.maps), ("keyframes", self.keyframes)
        ):  # fmt: skip
            self.bench.graph.channel(port).observe(kept.append)
        self.zones = self.bench.listen("zones")

    async def go(self, poses: Sequence[Pose2], every: int = 1, slip: float = 0.01) -> None:
        """Drive along ``poses``, one in 0.1 s, the wheels slipping; scans at each, or one in ``every``."""
        for number, pose in enumerate(poses):
            step = self.X_WB.inverse() @ pose
            self.X_OB = self.X_OB @ Pose2(step.x * (1 + slip), step.y, step.theta * (1 + slip))
            self.X_WB = pose
            now = self.bench.clock.now()
            self.bench.feed("odometry", Odometry(now, self.X_OB, 0.0, 0.0))
            if number % every == 0:
                self._scans += 1
                self.bench.feed("scans", scan(self.walls, pose, now, seed=self._scans))
            await self.bench.clock.sleep(0.1)

    def suggest(self, X_WB: Pose2) -> None:
        """A landmark says that the robot is at ``X_WB``."""
        X_MO = ROUND[0].inverse() @ X_WB @ self.X_OB.inverse()
        self.bench.feed("landmark_poses", LandmarkPose(self.bench.clock.now(), X_MO, np.eye(3), 1, "door"))

    async def stand(self, seconds: float) -> None:
        await self.go([self.X_WB] * round(seconds * 10))

    def is_within(self, metres: float, radians: float, start: Pose2 = ROUND[0]) -> bool:
        """Whether the last published pose is so near to the true one, the map's origin being at ``start``."""
        off = (start @ self.explained_each[-1].X_MB).inverse() @ self.X_WB
        return math.hypot(off.x, off.y) < metres and abs(off.theta) < radians

    @property
    def state(self) -> str:
        return self.explained_each[-1].state

    def states(self, since: int = 0) -> list[str]:
        """The published states, consecutive equal ones once."""
        found = [place.state for place in self.explained_each[since:]]
        return [state for state, before in zip(found, ["", *found], strict=False) if state != before]


def live(script: Script, library: MapLibrary, fails: str = "", **settings: Any) -> Body:
    body = Body(library, **settings)

    async def main() -> None:
        async with body.bench:
            await body.bench.supervisor.started()
            await script(body)

    run_virtual(main())
    assert fails in body.bench.problem
    assert bool(fails) == bool(body.bench.problem)
    return body


@pytest.fixture(scope="module", autouse=True)
def _kernels() -> None:
    """Virtual time waits for no compiler."""
    compiled.make_ready()


@pytest.fixture
def library(tmp_path: Path) -> MapLibrary:
    return MapLibrary(tmp_path)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> MapLibrary:
    """The hall, mapped and kept; not to be changed."""
    library = MapLibrary(tmp_path_factory.mktemp("maps"))

    async def script(body: Body) -> None:
        await body.go(ROUND)
        await body.control.server.mark((STAIRS,))
        await body.control.server.save("hall")

    live(script, library)
    return library


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


def test_a_kept_map_is_loaded_where_the_robot_is_said_to_be(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        body.X_WB = Pose2(7.0, 3.0, 0.3)
        await body.stand(0.5)
        about = ROUND[0].inverse() @ Pose2(7.4, 2.6, 0.0)
        await body.control.server.load("hall", about)
        assert [zone.name for zone in drain(body.zones)[-1].zones] == ["stairs"]
        explained_each = len(body.explained_each)
        await body.go([*[body.X_WB] * 3, *way((7.0, 3.0), (10.0, 3.0))])
        assert body.states(explained_each) == ["tracking"]
        assert body.explained_each[-1].map == body.control.server.name == "hall"

    body = live(script, kept)
    assert body.is_within(0.05, 0.02)
    assert body.maps[-1].cells.shape < (1000, 1000), "the map stays as it was kept"


def test_without_a_word_it_looks_for_itself_and_is_reported_to_be_searching_till_then(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        body.X_WB = Pose2(9.0, 6.5, math.pi)
        await body.stand(0.5)
        await body.control.server.load("hall")
        explained_each = len(body.explained_each)
        assert body.state == "searching"
        await body.stand(3.0)
        assert body.state == "searching", "nothing is believed before it moves"
        sigma = math.sqrt(body.explained_each[-1].covariance[0, 0])
        await body.go(way((9.0, 6.5), (8.0, 6.0), (8.0, 3.0)))
        assert body.states(explained_each) == ["searching", "tracking"]
        assert sigma > 3 * math.sqrt(body.explained_each[-1].covariance[0, 0])

    assert live(script, kept).is_within(0.05, 0.02)


def test_a_robot_that_was_carried_away_notices_and_finds_itself(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.stand(0.2)
        await body.control.server.load("hall", Pose2())
        await body.go(ROUND[:30])
        assert body.state == "tracking"
        explained_each = len(body.explained_each)
        body.X_WB = Pose2(10.5, 6.0, -1.0)  # odometry knows nothing of it
        await body.go(way((10.5, 6.0), (10.5, 4.5), (8.0, 4.5), (5.0, 4.0), (2.0, 4.0)))
        assert body.states(explained_each) == ["tracking", "lost", "searching", "tracking"]
        back = next(place for place in body.explained_each[explained_each + 40 :] if place.state == "tracking")
        assert back.stamp - body.explained_each[explained_each].stamp < 10.0

    assert live(script, kept).is_within(0.05, 0.02)


@pytest.mark.slow
def test_where_nothing_is_on_the_map_it_stays_lost(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.stand(0.2)
        await body.control.server.load("hall", Pose2())
        body.walls = polygon((0, 0), (5, 0), (3, 4))
        explained_each = len(body.explained_each)
        await body.go(way((1.5, 1.0), (3.5, 1.0), (2.5, 2.0), (1.5, 0.7)))
        assert "tracking" not in body.states(explained_each + 15)

    live(script, kept)


@pytest.mark.slow
def test_mapping_goes_on_from_a_kept_map(kept: MapLibrary, library: MapLibrary) -> None:
    async def map_half(body: Body) -> None:
        await body.go(ROUND[:60])
        await body.control.server.save("half")

    live(map_half, library)

    async def go_on(body: Body) -> None:
        body.X_WB = ROUND[0]
        await body.stand(0.2)
        await body.control.server.load("half", Pose2(0.1, 0.1), extend=True)
        await body.go(ROUND)
        assert body.states(1)[-1] == "mapping"
        await body.control.server.save("whole")

    body = live(go_on, library)
    assert body.is_within(0.05, 0.02)
    half, whole = library.facts("half"), library.facts("whole")
    assert whole.graph
    assert whole.known_m2 > half.known_m2 + 5


@pytest.mark.slow
def test_a_map_of_another_program_is_followed_on_but_does_not_grow(library: MapLibrary) -> None:
    library.keep("foreign", drawn(HALL, (12, 8)))

    async def script(body: Body) -> None:
        map_server = body.control.server
        await body.stand(0.2)
        with pytest.raises(MapUnavailable, match="'foreign' was kept without its graph"):
            await map_server.load("foreign", extend=True)
        await map_server.load("foreign", ROUND[0])
        explained_each = len(body.explained_each)
        await body.go(ROUND)
        assert body.states(explained_each) == ["tracking"]
        assert body.is_within(0.06, 0.03, Pose2())
        await map_server.save("copy")

    live(script, library)
    assert not (library.folder / "copy" / GRAPH).exists()


def test_what_cannot_be_is_refused_in_words_and_changes_nothing(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        map_server = body.control.server
        with pytest.raises(MapUnavailable, match="nothing to keep yet"):
            await map_server.save("empty")
        with pytest.raises(MapUnavailable, match="no map yet"):
            await map_server.search()
        with pytest.raises(MapUnavailable, match="no map yet"):
            await map_server.place(Pose2())
        await body.go(ROUND[:30])
        with pytest.raises(MapUnavailable, match="there is no map 'other'; there are: hall"):
            await map_server.load("other")
        for call in (map_server.save, map_server.load):
            with pytest.raises(MapUnavailable, match="a map's name has"):
                await call("../up")
        with pytest.raises(MapUnavailable, match="two zones are called"):
            await map_server.mark((STAIRS, STAIRS))
        await body.go(ROUND[30:40])
        assert body.states() == ["mapping"]
        assert map_server.name == ""

    assert live(script, kept).is_within(0.05, 0.02)


def test_beginning_again_forgets_the_map_and_its_zones(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.stand(0.2)
        await body.control.server.load("hall", Pose2())
        await body.go(ROUND[:30])
        await body.control.server.begin()
        assert (body.maps[-1].cells == -1).all()
        assert drain(body.zones)[-1].zones == ()
        assert body.control.server.name == ""
        start = body.X_WB
        await body.go(ROUND[30:50])
        assert body.state == "mapping"
        assert body.is_within(0.05, 0.02, start)

    live(script, kept)


def test_zones_are_kept_with_a_map_that_has_a_name(library: MapLibrary) -> None:
    library.keep("foreign", drawn(HALL, (12, 8)))

    async def script(body: Body) -> None:
        await body.stand(0.2)
        await body.control.server.load("foreign", ROUND[0])
        await body.control.server.mark((STAIRS,))
        assert [zone.name for zone in drain(body.zones)[-1].zones] == ["stairs"]

    live(script, library)
    assert [zone.name for zone in library.zones("foreign")] == ["stairs"]


def test_after_a_restart_it_goes_on_with_the_map_it_had(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND[:60])
        nowhere: Any = None
        broken = replace(scan(HALL, body.X_WB, body.bench.clock.now() - 0.15), X_BL=nowhere)
        body.bench.feed("scans", broken)
        await body.bench.clock.sleep(1.0)
        await body.bench.supervisor.started()
        assert body.bench.supervisor.states["Tested"].restarts == 1
        explained_each = len(body.explained_each)
        await body.go(ROUND[60:90])
        assert body.states(explained_each) == ["mapping"]
        await body.control.server.save("grown")

    assert live(script, kept, fails="AttributeError").is_within(0.1, 0.03)
    grown = stored_map(kept, "grown").state
    assert grown is not None
    assert len({round(keyframe.stamp) for keyframe in grown.keyframes}) > 6
    kept.delete("grown")


def test_configured_to_it_begins_on_a_kept_map(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.go(ROUND[:40])
        assert body.explained_each[-1].map == "hall"
        assert body.states() == ["searching", "tracking"]

    assert live(script, kept, map="hall").is_within(0.05, 0.02)


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


@pytest.mark.slow
def test_a_lost_robot_that_stands_finds_itself_by_a_landmark_that_scans_bear_out(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        body.X_WB = ROUND[40]
        await body.control.server.load("hall")
        await body.stand(2.0)
        assert body.state == "searching"
        # The landmark was moved: what it says is not what scans say.
        body.suggest(ROUND[40] @ Pose2(1.5, 0.6, 0.8))
        await body.stand(2.0)
        assert body.state == "searching"
        body.suggest(ROUND[40] @ Pose2(0.15, -0.1, 0.1))
        await body.stand(2.0)

    body = live(script, kept)
    assert body.state == "tracking"
    assert body.is_within(0.05, 0.02)


@pytest.mark.slow
def test_a_landmark_moves_no_robot_whose_scans_fit(kept: MapLibrary) -> None:
    async def script(body: Body) -> None:
        await body.stand(0.2)
        await body.control.server.load("hall", Pose2())
        await body.stand(1.0)
        body.suggest(ROUND[0] @ Pose2(0.2, 0.2, 0.2))
        await body.stand(1.0)

    body = live(script, kept)
    assert body.states(3) == ["tracking"]
    assert body.is_within(0.05, 0.02)
