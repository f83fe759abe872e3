"""SLAM2D on kept maps: loads them, finds itself, goes on with them, keeps them again."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.base import compiled
from app.base.geometry import Pose2
from app.maps.library import GRAPH, MapLibrary
from app.maps.map_service import MapUnavailable
from app.modules.perception.slam.map_session import stored_map
from tests.modules.fakes import drain
from tests.modules.perception.slam.hall_drive import ROUND, STAIRS, Body, live
from tests.modules.perception.slam.places import HALL, drawn, polygon, scan, way


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
