"""Stand-ins of perceptions on a kinematic body: what they publish of its truth, and that filters rule them."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base import paths
from app.base.geometry import Pose2, Pose3
from app.link import RobotLink
from app.maps.grid_rays import GridRays
from app.maps.library import MapLibrary
from app.maps.map_service import MapService, MapUnavailable
from app.messages import (
    Faces,
    Image,
    JointCommand,
    LaserScan,
    Localization,
    OccupancyGrid,
    Odometry,
    PersonTruth,
    Twist,
    Zone,
    Zones,
)
from app.modules.perception.stand_ins.visible_faces import Eye, TrackNumbers, visible
from app.robots.config import StartPose, load_robot_config
from app.robots.simulated.kinematic.config import kinematic_of
from app.robots.simulated.kinematic.link import KinematicLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.runtime.clock import run_virtual
from app.runtime.filter import CLOSED
from tests.modules.fakes import Bench
from tests.robots.simulated.kinematic.rooms import room

STAND_INS = "app.modules.perception.stand_ins"
STAIRS = Zone("stairs", "keep_out", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 1.0)
#: Ahead as the Kinect sees it: its x right, y down, z forward.
OPTICAL = Pose3(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.array([0.0, 0.0, 1.2]))
KINECT = Eye("camera", (math.radians(57), math.radians(43)), 4.0, (640, 480), 15.0)


def body(start: StartPose, people: tuple[dict[str, Any], ...] = ()) -> KinematicLink:
    robot = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
    scenario = ScenarioConfig.model_validate({"name": "one", "people": people})
    return KinematicLink(kinematic_of(robot, Path("map.yaml"), start), room(), _NO_CLOCK, scenario)


class _Later:
    """The bench makes the clock, and the link is made before."""

    def now(self) -> float:
        return 0.0

    async def sleep(self, seconds: float) -> None:
        raise AssertionError("set before the link starts")

    async def sleep_until(self, stamp: float) -> None:
        raise AssertionError("set before the link starts")


_NO_CLOCK = _Later()


def played(bench: Bench, link: KinematicLink, script: Callable[[], Awaitable[None]]) -> None:
    async def run() -> None:
        link._clock = bench.clock
        await link.start()
        async with bench:
            await bench.supervisor.started()
            await script()
        await link.stop()

    run_virtual(run())
    assert not bench.problem


class Localized:
    """TrueLocalization on a body in the room."""

    def __init__(self, folder: Path) -> None:
        library, self.maps = MapLibrary(folder), MapService()
        library.keep("room", room(), (STAIRS,))
        self.link = body(StartPose(x=1.0, y=1.0, heading_deg=90))
        self.bench = Bench(
            f"{STAND_INS}.true_localization:TrueLocalization",
            inputs={"scans": LaserScan, "odometry": Odometry},
            outputs={"localization": Localization, "map": OccupancyGrid, "zones": Zones},
            services={MapLibrary: library, MapService: self.maps, RobotLink: self.link},
            settings={"map": "room"},
        )
        self.link.attach("odometry", lambda message: self.bench.feed("odometry", message))
        self.link.attach("hokuyo", lambda message: self.bench.feed("scans", message))
        self.link.demand("hokuyo", math.inf)
        self.heard: dict[str, list[Any]] = {port: [] for port in ("localization", "map", "zones")}
        for port, messages in self.heard.items():
            self.bench.graph.channel(port).observe(messages.append)


def test_each_scan_is_localized_where_the_body_truly_is(tmp_path: Path) -> None:
    tested = Localized(tmp_path)

    async def script() -> None:
        for _ in range(30):
            tested.link.command(Twist(tested.bench.clock.now(), 0.3, 0.5))
            await tested.bench.clock.sleep(0.1)

    played(tested.bench, tested.link, script)
    last: Localization = tested.heard["localization"][-1]
    assert len(tested.heard["localization"]) >= 28
    assert (last.state, last.map, last.overlap) == ("tracking", "room", 1.0)
    assert (last.X_MO.x, last.X_MO.y, last.X_MO.theta) == pytest.approx((1.0, 1.0, math.pi / 2))
    gone = math.hypot(last.X_MB.x - 1.0, last.X_MB.y - 1.0)
    assert 0.3 < gone < 0.9


def test_without_scans_it_publishes_nothing(tmp_path: Path) -> None:
    tested = Localized(tmp_path)
    tested.bench.graph.filters.apply({"Tested.scans": CLOSED})
    played(tested.bench, tested.link, lambda: tested.bench.clock.sleep(2.0))
    assert not tested.heard["localization"]


def test_it_serves_the_kept_map_which_stays_as_it_is(tmp_path: Path) -> None:
    tested = Localized(tmp_path)

    async def script() -> None:
        assert tested.maps.server.name == "room"
        for refused in (tested.maps.server.begin, tested.maps.server.search):
            with pytest.raises(MapUnavailable, match="stays as it is"):
                await refused()
        with pytest.raises(MapUnavailable, match="room"):
            await tested.maps.server.load("another")

    played(tested.bench, tested.link, script)
    assert tested.heard["map"][0].cells.shape == room().cells.shape
    assert [zone.name for zone in tested.heard["zones"][0].zones] == ["stairs"]
    assert not tested.maps.available


class Seeing:
    """TrueFaces on a body at the room's west side that looks east, at one who stands there."""

    def __init__(self, at: tuple[float, float] = (2.4, 1.0), heading_deg: float = 180.0) -> None:
        person = {"name": "one", "face": "pilot", "at": at, "heading_deg": heading_deg, "height_m": 1.7}
        self.link = body(StartPose(x=0.0, y=1.0), (person,))
        self.bench = Bench(
            f"{STAND_INS}.true_faces:TrueFaces",
            inputs={"images": Image, "panorama": Image, "map": OccupancyGrid},
            outputs={"faces": Faces},
            services={RobotLink: self.link},
            attended=("images", "panorama"),
        )
        self.bench.feed("map", room())
        self.heard: list[Faces] = []
        self.bench.graph.channel("faces").observe(self.heard.append)

    def play(self, seconds: float, pan: float = 0.0, **divisors: float) -> list[Faces]:
        async def script() -> None:
            self.bench.graph.filters.apply({f"Tested.{port}": divisor for port, divisor in divisors.items()})
            for _ in range(round(seconds / 0.1)):
                self.link.command(JointCommand(self.bench.clock.now(), "head", ("pan_joint",), (pan,)))
                await self.bench.clock.sleep(0.1)

        played(self.bench, self.link, script)
        return self.heard


def test_faces_come_only_while_attention_looks_for_them_and_as_often() -> None:
    assert not Seeing().play(3.0)
    often = Seeing().play(4.0, images=1)
    assert 18 <= len(often) <= 21
    assert {faces.frame for faces in often} == {"kinect_optical_frame"}
    assert 6 <= len(Seeing().play(4.0, images=8)) <= 8
    assert {faces.frame for faces in Seeing().play(1.0, panorama=1)} == {"panorama_optical_frame"}


def test_a_face_is_where_it_is_and_keeps_its_track() -> None:
    messages = Seeing().play(2.0, images=1)
    assert all(len(message.faces) == 1 for message in messages)
    assert {message.faces[0].track for message in messages} == {1}
    x, y, z = messages[-1].faces[0].p_BF
    assert (x, y) == pytest.approx((2.3, 0.0), abs=0.05)
    assert z == pytest.approx(0.926 * 1.7, abs=0.05)


def test_the_head_looks_away_a_wall_is_between_or_a_person_turns() -> None:
    assert not any(message.faces for message in Seeing().play(3.0, pan=1.0, images=1)[10:])
    assert any(message.faces for message in Seeing().play(3.0, pan=1.0, panorama=1)[10:])
    assert not any(message.faces for message in Seeing(heading_deg=0.0).play(1.0, images=1))
    assert not any(message.faces for message in Seeing(at=(4.7, 1.0)).play(1.0, images=1))


def test_a_pillar_hides_a_face_from_a_camera_and_distance_from_another() -> None:
    one = PersonTruth("one", 3.6, 0.0, math.pi, 1.7, mouth=(3.5, 0.0, 1.5))
    rays = GridRays(room())
    assert not list(visible([one], Pose2(1.0, 0.0), OPTICAL, KINECT, rays))
    assert len(list(visible([one], Pose2(1.0, 0.0), OPTICAL, KINECT, None))) == 1
    near = Eye("camera", KINECT.fov, 2.0, KINECT.size, KINECT.rate_hz)
    assert not list(visible([one], Pose2(1.0, 0.0), OPTICAL, near, None))
    assert not list(visible([one], Pose2(1.0, 0.0, math.pi), OPTICAL, KINECT, None))
    ((_, face),) = visible([one], Pose2(1.0, 0.5), OPTICAL, KINECT, None)
    left, top, wide, high = face.box
    assert 320 < left + wide / 2 < 640
    assert 0 < top + high / 2 < 240
    assert face.range_m == pytest.approx(math.dist((2.5, -0.5, 1.551), (0, 0, 1.2)))


def test_who_was_not_seen_for_a_while_is_another_track() -> None:
    tracks = TrackNumbers(1.2)
    assert [tracks.of("one", 0.0), tracks.of("two", 0.5), tracks.of("one", 1.0)] == [1, 2, 1]
    assert [tracks.of("one", 3.0), tracks.of("two", 3.0), tracks.of("one", 4.0)] == [3, 4, 3]
