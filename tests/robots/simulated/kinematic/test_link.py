"""The kinematic body as a robot link: streams at their rates, commands, joints, its file."""

from __future__ import annotations

import itertools
import math
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.link import LinkFailed
from app.messages import JointCommand, Twist
from app.robots.config import StartPose, load_robot_config
from app.robots.factory import KINEMATIC, create_kinematic
from app.robots.simulated.kinematic.config import KinematicConfig, kinematic_of
from app.robots.simulated.kinematic.link import KinematicLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.runtime.clock import VirtualClock, run_virtual
from tests.robots.simulated.kinematic.rooms import kept, room

LAB_ROBOT = paths.config_dir() / "robots" / "irl1_tr.yaml"
ONE = {"name": "one", "face": "pilot", "at": (2, 1), "script": [{"walk": (2, -1)}, {"wait": 9}]}
ONE_WALKS = ScenarioConfig.model_validate({"name": "one", "people": [ONE]})


def config(**more: Any) -> KinematicConfig:
    return kinematic_of(load_robot_config(LAB_ROBOT), Path("map.yaml"), StartPose(y=1.0, heading_deg=0.0), **more)


class Body:
    """A link with everything it says."""

    def __init__(self, scenario: ScenarioConfig | None = None, **more: Any) -> None:
        self.clock = VirtualClock()
        self.link = KinematicLink(config(**more), room(), self.clock, scenario)
        self.heard: dict[str, list[Any]] = {stream: [] for stream in self.link.description.streams}
        for stream, messages in self.heard.items():
            self.link.attach(stream, messages.append)

    async def drive(self, linear: float, angular: float, seconds: float) -> None:
        for _ in range(round(seconds / 0.1)):
            self.link.command(Twist(self.clock.now(), linear, angular))
            await self.clock.sleep(0.1)


def played(body: Body, script: Callable[[], Awaitable[None]]) -> None:
    async def run() -> None:
        await body.link.start()
        await script()
        await body.link.stop()

    run_virtual(run())


def test_streams_come_at_their_rates_and_only_while_they_are_wanted() -> None:
    body = Body()

    async def script() -> None:
        await body.clock.sleep(10.02)
        assert not body.heard["hokuyo"]
        assert not body.heard["scene_truth"]
        for stream in ("hokuyo", "ground_truth", "scene_truth"):
            body.link.demand(stream, math.inf)
        await body.clock.sleep(10.0)

    played(body, script)
    counts = {stream: len(messages) for stream, messages in body.heard.items()}
    assert counts == {
        "odometry": 400, "joints": 200, "status": 100, "ground_truth": 200, "scene_truth": 50, "hokuyo": 100,
    }  # fmt: skip
    assert counts.keys() == body.link.description.streams.keys()


@pytest.mark.parametrize(("wanted_hz", "scans", "periods"), [(math.inf, 100, 4), (40.0, 100, 4), (5.0, 50, 8)])
def test_a_scan_says_how_many_periods_of_the_laser_it_ends(wanted_hz: float, scans: int, periods: int) -> None:
    body = Body()
    ended: list[int] = []
    body.link.attach("hokuyo", lambda _: ended.append(body.link.periods("hokuyo")))
    body.link.demand("hokuyo", wanted_hz)
    played(body, lambda: body.clock.sleep(10.02))
    assert ended == [periods] * scans
    assert body.link.description.streams["hokuyo"].rate_hz == 40.0


def test_odometry_begins_at_the_start_and_truth_is_on_the_map() -> None:
    body = Body()
    body.link.demand("ground_truth", math.inf)
    played(body, lambda: body.drive(0.4, 0.0, 3.0))
    odometry, truth = body.heard["odometry"][-1], body.heard["ground_truth"][-1]
    assert 0.7 < odometry.X_OB.x < 1.0
    assert (truth.X_WB.x, truth.X_WB.y) == pytest.approx((odometry.X_OB.x, 1.0))
    assert odometry.linear_mps == pytest.approx(0.4)
    assert body.heard["status"][-1].guard == "driving"


def test_joints_follow_their_set_points_within_their_speed() -> None:
    body = Body()

    async def script() -> None:
        for _ in range(20):
            body.link.command(JointCommand(body.clock.now(), "head", ("pan_joint",), (1.0,)))
            await body.clock.sleep(0.1)
        body.link.command(JointCommand(body.clock.now(), "wings", ("left",), (1.0,)))

    played(body, script)
    pans = [dict(zip(state.names, state.positions, strict=True))["pan_joint"] for state in body.heard["joints"]]
    assert pans[0] < 0.1
    assert pans[-1] == pytest.approx(1.0, abs=1e-6)
    assert max(after - before for before, after in itertools.pairwise(pans)) <= 0.1051
    assert "left_wheel_joint" in body.heard["joints"][0].names
    assert {group.group for group in body.heard["status"][-1].groups} >= {"head", "left_arm", "face"}


def test_people_walk_and_are_in_the_scan() -> None:
    body = Body(ONE_WALKS)
    for stream in ("hokuyo", "scene_truth"):
        body.link.demand(stream, math.inf)
    played(body, lambda: body.clock.sleep(6.0))
    assert body.heard["scene_truth"][0].people[0].y == pytest.approx(1.0, abs=0.15)
    assert body.heard["scene_truth"][-1].people[0].y == pytest.approx(-1.0, abs=0.02)
    ahead = [float(scan.ranges[172:189].min()) for scan in body.heard["hokuyo"]]
    assert ahead[0] < 2.1 < 4.0 < ahead[-1]


def test_the_same_seed_gives_the_same_run() -> None:
    def run() -> list[Any]:
        body = Body(ONE_WALKS)
        body.link.demand("scene_truth", math.inf)
        played(body, lambda: body.drive(0.3, 0.2, 4.0))
        return [message.X_OB for message in body.heard["odometry"]] + body.heard["scene_truth"]

    assert run() == run()


def test_an_emergency_stop_stops_base_and_joints() -> None:
    body = Body()

    async def script() -> None:
        await body.drive(0.4, 0.0, 2.0)
        body.link.e_stop("test")
        await body.drive(0.4, 0.0, 1.0)
        assert body.link.base.velocity.is_zero
        assert body.heard["status"][-1].e_stopped
        body.link.clear_e_stop()
        await body.drive(0.4, 0.0, 1.0)

    played(body, script)
    assert body.heard["status"][-1].guard == "driving"


def test_it_fails_once_it_is_ended_and_may_begin_again() -> None:
    body = Body()

    async def script() -> None:
        assert "not started" in str(await body.link.wait_failed())
        await body.link.start()
        with pytest.raises(LinkFailed, match="runs already"):
            await body.link.start()
        await body.link.stop()
        await body.link.stop()
        await body.link.start()
        await body.clock.sleep(1.0)
        await body.link.stop()

    run_virtual(script())
    assert len(body.heard["odometry"]) >= 19


def test_its_file_names_a_map_and_a_scenario(tmp_path: Path) -> None:
    map_file, model = kept(tmp_path / "maps"), LAB_ROBOT.parent / "irl1_tr.urdf"
    (tmp_path / "people.yaml").write_text("name: one\npeople: [{name: one, face: pilot, at: [2, 1]}]\n")
    file = tmp_path / "body.yaml"
    text = f"kind: kinematic\nname: Shadow\nmodel: {model}\nmap: maps/room/map.yaml\nscenario: people.yaml\n"
    file.write_text(f"{text}laser: {{link: hokuyo_link}}\nactuators: {{head: {{joints: [pan_joint]}}}}\n")
    body = KINEMATIC.load(file)
    assert isinstance(body, KinematicConfig)
    assert set(body.files) == {model, map_file, tmp_path / "people.yaml"}
    link = create_kinematic(body, VirtualClock())
    assert [actor.name for actor in link.scenario_state.actors] == ["one"]
    assert set(link.description.groups) == {"head"}
    file.write_text(text + "laser: {link: hokuyo_lnk}\n")
    with pytest.raises(ConfigError, match="hokuyo_lnk"):
        KINEMATIC.load(file)
    file.write_text(text.replace("room", "rom"))
    with pytest.raises(ConfigError, match="map: there is no file") as refused:
        KINEMATIC.load(file)
    assert refused.value.line == 4


def test_a_body_without_a_footprint_is_refused() -> None:
    desk = load_robot_config(LAB_ROBOT).model_copy(update={"footprint": ()})
    with pytest.raises(ConfigError, match="covers no floor"):
        kinematic_of(desk, Path("map.yaml"), StartPose())
