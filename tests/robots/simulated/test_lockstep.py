"""The body in lockstep: the same world as the process's, on the program's clock, the same each time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from app.link import LinkFailed
from app.messages import (
    Audio,
    GroundTruth,
    Image,
    JointCommand,
    JointState,
    LaserScan,
    LinkStatus,
    Odometry,
    SceneTruth,
    Twist,
)
from app.robots.config import RobotConfig, load_robot_config
from app.robots.simulated.camera_rendering import KinectRenderer
from app.robots.simulated.contacts import Contact
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.renderer import WorldSnapshot
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import VirtualClock, run_virtual
from tests.robots.conftest import make_hall, needs_gl

pytestmark = pytest.mark.slow

T = TypeVar("T")
WALKING = ScenarioConfig.model_validate(
    {
        "name": "one walks",
        "people": [
            {"name": "one", "face": "pilot", "at": (6, 6), "script": [{"walk": (6, 9), "speed": 1.0}, {"walk": (6, 6)}]}
        ],
    }
)


class Body:
    """A link in lockstep with everything it says."""

    def __init__(self, link: LockstepLink, clock: VirtualClock) -> None:
        self.link, self.clock = link, clock
        self.heard: dict[str, list[Any]] = {stream: [] for stream in link.description.streams}
        for stream, messages in self.heard.items():
            link.attach(stream, messages.append)

    async def drive(self, linear: float, angular: float, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            self.link.command(Twist(self.clock.now(), linear, angular))
            await self.clock.sleep(0.05)


def live(
    robot: RobotConfig,
    world: WorldConfig,
    script: Callable[[Body], Awaitable[T]],
    scenario: ScenarioConfig | None = None,
    *,
    cameras: bool = False,
    microphones: bool = False,
) -> T:
    """Run ``script`` in the world in virtual time."""

    async def run() -> T:
        clock = VirtualClock()
        link = LockstepLink(robot, world, clock, scenario, cameras=cameras, microphones=microphones)
        body = Body(link, clock)
        await body.link.start()
        try:
            return await script(body)
        finally:
            await body.link.stop()

    return run_virtual(run())


def at(robot: RobotConfig, x: float, y: float, heading_deg: float = 0.0) -> RobotConfig:
    start = robot.start.model_copy(update={"x": x, "y": y, "heading_deg": heading_deg})
    return robot.model_copy(update={"start": start})


def test_streams_run_at_their_rates_by_the_programs_clock_and_unwanted_ones_not(
    robot: RobotConfig, hall: WorldConfig
) -> None:
    async def script(body: Body) -> dict[str, list[Any]]:
        await body.clock.sleep(1.0)
        assert not body.heard["hokuyo"]
        for stream in ("hokuyo", "ground_truth", "scene_truth"):
            body.link.demand(stream, math.inf)
        for messages in body.heard.values():
            messages.clear()
        await body.clock.sleep(2.0)
        return body.heard

    heard = live(at(robot, 10, 10), hall, script, WALKING)
    rates = {"odometry": 100, "joints": 30, "status": 20, "hokuyo": 40, "ground_truth": 100, "scene_truth": 20}
    assert set(heard) == set(rates) | {"battery"}  # no ears, and eyes only where asked for
    assert not heard["battery"]
    for stream, rate_hz in rates.items():
        assert len(heard[stream]) == pytest.approx(2 * rate_hz, abs=2), stream
        stamps = [message.stamp for message in heard[stream]]
        assert stamps == sorted(stamps)
    scan: LaserScan = heard["hokuyo"][-1]
    assert scan.ranges.shape == (720,)
    assert not scan.ranges.flags.writeable
    assert scan.ranges[360] == pytest.approx(19.9 - 10.2, abs=0.05)  # the east wall, from the laser ahead of the base
    status: LinkStatus = heard["status"][-1]
    assert status.world_rate == 1.0
    truth: SceneTruth = heard["scene_truth"][-1]
    assert truth.people[0].y > 6.5


def test_it_drives_as_the_guard_lets_it_and_stops_when_commands_end(robot: RobotConfig, hall: WorldConfig) -> None:
    async def script(body: Body) -> tuple[float, float, list[LinkStatus], Odometry]:
        await body.drive(9.0, 0.0, 3.0)
        moving = body.link.true_pose()
        await body.clock.sleep(0.2)  # the last command is 0.05 s old: it is valid for 0.15 s more
        await body.clock.sleep(1.0)
        return moving.x, body.link.true_pose().x, body.heard["status"], body.heard["odometry"][-1]

    moving, stopped, statuses, odometry = live(at(robot, 5, 10), hall, script)
    # 0.4 m/s after 1 s of 0.4 m/s^2, and 2 s at that
    assert moving - 5 == pytest.approx(1.0, abs=0.03)
    assert stopped - moving == pytest.approx(0.4 * 0.15 + 0.4**2 / (2 * 2.5), abs=0.03)
    assert odometry.X_OB.x == pytest.approx(stopped - 5, rel=0.02)
    assert statuses[-1].guard in ("idle", "stale_command")
    assert max(status.applied.linear_mps for status in statuses) == pytest.approx(0.4)


def test_an_emergency_stop_holds_until_it_is_cleared_also_over_a_restart(robot: RobotConfig, hall: WorldConfig) -> None:
    async def script(body: Body) -> list[float]:
        places = []
        body.link.e_stop("a test")
        await body.link.stop()
        await body.link.start()
        await body.drive(0.4, 0.0, 1.0)
        places.append(body.link.true_pose().x)
        body.link.clear_e_stop()
        await body.drive(0.4, 0.0, 1.0)
        places.append(body.link.true_pose().x)
        return places

    held, free = live(at(robot, 5, 10), hall, script)
    assert held == pytest.approx(5.0, abs=0.002)
    assert free > 5.1


def test_two_runs_are_the_same_and_another_seed_is_not(robot: RobotConfig, hall: WorldConfig) -> None:
    async def script(body: Body) -> tuple[Any, ...]:
        body.link.demand("hokuyo", math.inf)
        await body.drive(0.3, 0.4, 1.0)
        last: LaserScan = body.heard["hokuyo"][-1]
        return body.link.true_pose(), body.heard["odometry"][-1].X_OB, last.stamp, last.ranges.tobytes()

    first = live(at(robot, 10, 10), hall, script, WALKING)
    assert live(at(robot, 10, 10), hall, script, WALKING) == first
    assert live(at(robot, 10, 10).model_copy(update={"seed": 2}), hall, script, WALKING) != first


def test_a_loose_thing_on_a_table_is_no_contact_of_the_body(robot: RobotConfig) -> None:
    table = {"kind": "box", "at": (12.0, 10.0), "size": (0.4, 0.4, 0.6)}
    block = {"kind": "box", "at": (12.0, 10.0), "z": 0.6, "size": (0.04, 0.04, 0.12), "mass_kg": 0.1}

    async def script(body: Body) -> tuple[Contact, ...]:
        await body.clock.sleep(1.0)
        return body.link.contacts

    assert live(at(robot, 10, 10), make_hall(objects=[table, block]), script) == ()


def test_contacts_report_what_was_touched_and_each_time_once(robot: RobotConfig) -> None:
    posts = {"at": [(6.0, 10.0)], "material": "wall"}
    world = make_hall(cylinders=[posts])

    async def script(body: Body) -> Any:
        await body.drive(0.4, 0.0, 3.0)
        once = body.link.contacts
        await body.drive(-0.4, 0.0, 2.0)
        await body.drive(0.4, 0.0, 3.0)
        return once, body.link.contacts

    once, twice = live(at(robot, 5.3, 10), world, script)
    assert [contact.what for contact in once] == ["cylinder0.0"]
    assert once[0].at[:2] == pytest.approx((6.0 - 0.075, 10.0), abs=0.02)
    assert once[0].X_WB.x == pytest.approx(6.0 - 0.075 - 0.275, abs=0.01)
    assert [contact.what for contact in twice] == ["cylinder0.0"] * 2


def test_the_laser_measures_a_cylinder_where_it_stands(robot: RobotConfig) -> None:
    world = make_hall(cylinders=[{"at": [(8.0, 10.0), (8.0, 11.5)], "radius": 0.2, "material": "wall"}])

    async def script(body: Body) -> LaserScan:
        body.link.demand("hokuyo", math.inf)
        await body.clock.sleep(0.2)
        return body.heard["hokuyo"][-1]

    scan = live(at(robot, 5, 10), world, script)
    angles = scan.angle_min + scan.angle_increment * np.arange(scan.ranges.size)
    ahead = scan.ranges[np.abs(angles) < 0.01]
    assert np.mean(ahead) == pytest.approx(8.0 - 0.2 - 5.2, abs=0.02)
    aside = scan.ranges[np.abs(angles - math.atan2(1.5, 2.8)) < 0.01]
    assert np.mean(aside) == pytest.approx(math.hypot(1.5, 2.8) - 0.2, abs=0.02)


@needs_gl
def test_with_cameras_pictures_come_with_the_step_they_show(robot: RobotConfig, hall: WorldConfig) -> None:
    kinect = robot.streams.kinect
    assert kinect is not None
    small = kinect.model_copy(update={"width": 160, "height": 120})
    robot = robot.model_copy(update={"streams": robot.streams.model_copy(update={"kinect": small, "panorama": None})})

    async def script(body: Body) -> tuple[list[Image], list[GroundTruth]]:
        body.link.demand("kinect", math.inf)
        body.link.demand("ground_truth", math.inf)
        await body.drive(0.0, 0.0, 0.5)
        return body.heard["kinect"], body.heard["ground_truth"]

    pictures, _ = live(at(robot, 17, 10), hall, script, cameras=True)
    assert len(pictures) == pytest.approx(0.5 * 15, abs=1)
    assert all(b.stamp - a.stamp == pytest.approx(1 / 15, abs=0.005) for a, b in itertools.pairwise(pictures))
    depth = pictures[-1].depth
    assert depth is not None
    assert np.median(depth[20:60]) == pytest.approx(2900 - 1000 * pictures[-1].X_BC.translation[0], abs=150)


@needs_gl
def test_a_camera_draws_no_more_than_is_demanded_and_says_how_many_it_left_out(
    robot: RobotConfig, hall: WorldConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    kinect = robot.streams.kinect
    assert kinect is not None
    small = kinect.model_copy(update={"width": 160, "height": 120})
    robot = robot.model_copy(update={"streams": robot.streams.model_copy(update={"kinect": small, "panorama": None})})
    drawn: list[float] = []
    drawing = KinectRenderer.draw

    def draw(self: KinectRenderer, snapshot: WorldSnapshot) -> Iterator[None]:
        drawn.append(snapshot.stamp)
        return drawing(self, snapshot)

    async def script(body: Body) -> tuple[list[Image], list[int]]:
        periods: list[int] = []
        body.link.attach("kinect", lambda _: periods.append(body.link.periods("kinect")))
        body.link.demand("kinect", 15 / 4)
        await body.clock.sleep(0.1)
        monkeypatch.setattr(KinectRenderer, "draw", draw)
        await body.clock.sleep(3.0)
        return body.heard["kinect"], periods

    pictures, periods = live(at(robot, 17, 10), hall, script, cameras=True)
    assert periods == [1] + [4] * (len(pictures) - 1)
    assert len(pictures) == pytest.approx(1 + 3 * 15 / 4, abs=1)
    assert all(b.stamp - a.stamp == pytest.approx(4 / 15, abs=0.005) for a, b in itertools.pairwise(pictures))
    assert drawn == [picture.stamp for picture in pictures[1:]]


def test_a_body_that_runs_is_not_started_twice_and_one_that_does_not_says_so(
    robot: RobotConfig, hall: WorldConfig
) -> None:
    async def script(body: Body) -> None:
        with pytest.raises(LinkFailed, match="runs already"):
            await body.link.start()
        with pytest.raises(KeyError, match="no stream 'kinect'"):
            body.link.attach("kinect", print)
        await body.link.stop()
        await body.link.stop()
        assert "not started" in str(await body.link.wait_failed())

    live(robot, hall, script)


def test_with_microphones_a_clap_is_heard_when_sound_has_come_the_way_and_no_sample_is_missing(
    robot: RobotConfig,
) -> None:
    world = make_hall(rooms=[{"name": "hall", "from": (0, 0), "to": (20, 20), "rt60_s": 0.2}])
    clap = {"name": "clap", "kind": "clap", "clip": "clap", "at": (17.0, 10.0, 1.0), "begin_s": 0.4, "gain_db": 0}
    scenario = ScenarioConfig.model_validate({"name": "a clap", "sounds": [clap]})

    async def script(body: Body) -> list[Audio]:
        body.link.demand("microphones", math.inf)
        await body.clock.sleep(0.7)
        return body.heard["microphones"]

    heard = live(at(robot, 10, 10), world, script, scenario, microphones=True)
    assert [b.first_sample - a.first_sample for a, b in itertools.pairwise(heard)] == [512] * (len(heard) - 1)
    assert len(heard) == pytest.approx(0.7 * 48000 / 512, abs=4)
    assert not heard[0].samples.flags.writeable
    samples = np.abs(np.concatenate([frame.samples[:, 0] for frame in heard]).astype(float))
    quiet = samples[: round(0.3 * 48000)].max()
    begin_s = (heard[0].first_sample + int(np.argmax(samples > 3 * quiet))) / 48000
    assert begin_s == pytest.approx(0.4 + 7.0 / 343, abs=0.006)


async def turn_head(body: Body, seconds: float, pan: float, tilt: float) -> None:
    for _ in range(round(seconds / 0.1)):
        body.link.command(JointCommand(body.clock.now(), "head", ("pan_joint", "tilt_joint"), (pan, tilt)))
        await body.clock.sleep(0.1)


def pans(joints: list[JointState]) -> list[float]:
    return [message.positions[message.names.index("pan_joint")] for message in joints]


def test_the_head_turns_within_its_speed_holds_without_commands_and_says_so(
    robot: RobotConfig, hall: WorldConfig
) -> None:
    async def script(body: Body) -> tuple[list[JointState], list[LinkStatus], int]:
        body.link.command(JointCommand(body.clock.now(), "tail", ("tail_joint",), (1.0,)))  # it has none
        await turn_head(body, 2.0, 1.2, 9.0)
        commanded = len(body.heard["joints"])
        await body.clock.sleep(1.0)
        return body.heard["joints"], body.heard["status"], commanded

    joints, statuses, commanded = live(at(robot, 10, 10), hall, script)
    pan = pans(joints)
    fastest = max(abs(later - earlier) * 30 for earlier, later in itertools.pairwise(pan))
    assert 0.95 < fastest < 1.05 + 0.1, "the noise of two measurements is within 0.1 rad/s"
    assert pan[commanded - 1] == pytest.approx(1.2, abs=0.005)
    assert max(pan) < 1.2 + 0.005
    assert joints[-1].positions[joints[-1].names.index("tilt_joint")] == pytest.approx(0.4363, abs=0.005)
    assert pan[-1] == pytest.approx(1.2, abs=0.005), "without commands it is held"
    head = next(each for each in statuses[-1].groups if each.group == "head")
    face = next(each for each in statuses[-1].groups if each.group == "face")
    assert face.guard == "idle"
    assert (head.group, head.guard) == ("head", "idle")
    assert head.command_age_s == pytest.approx(1.0, abs=0.2)
    assert {status.groups[0].guard for status in statuses} >= {"idle", "moving"}


def test_the_efforts_of_the_motors_are_measured(robot: RobotConfig, hall: WorldConfig) -> None:
    async def script(body: Body) -> tuple[JointState, JointState]:
        simulation = body.link._simulation
        assert simulation is not None
        await body.clock.sleep(1.0)
        idle = body.heard["joints"][-1]
        data, joint = simulation.physics.data, simulation.physics.model.joint("robot/left_elbow_joint")
        data.qfrc_applied[joint.dofadr[0]] = -3.0
        await body.clock.sleep(2.0)
        return idle, body.heard["joints"][-1]

    idle, pushed = live(at(robot, 10, 10), hall, script)
    assert all(abs(effort) < 0.3 for effort in idle.efforts), "at rest, but for noise: weight is compensated"
    elbow = pushed.names.index("left_elbow_joint")
    friction, noise = 0.1, 0.05
    assert pushed.efforts[elbow] == pytest.approx(3.0, abs=friction + 5 * noise)


def test_the_face_is_where_its_guard_sets_it_and_rests_in_an_emergency(robot: RobotConfig, hall: WorldConfig) -> None:
    names = ("eyelids_joint", "lower_lip_joint", "eyes_pan_joint")

    async def script(body: Body) -> list[JointState]:
        for position in (9.0, 0.0):
            for _ in range(3):
                body.link.command(JointCommand(body.clock.now(), "face", names, (position, 0.2, -0.5)))
                await body.clock.sleep(0.1)
        body.link.e_stop("a test")
        body.link.command(JointCommand(body.clock.now(), "face", names, (1.0, 0.0, 0.0)))
        await body.clock.sleep(0.5)
        return body.heard["joints"]

    joints = live(at(robot, 10, 10), hall, script)
    lids, lips, eyes = ([dict(zip(j.names, j.positions, strict=True))[name] for j in joints] for name in names)
    assert max(lids) == pytest.approx(1.2), "as far as its limit, without a servo's lag or a measurement's noise"
    assert max(abs(b - a) * 30 for a, b in itertools.pairwise(eyes)) <= 10.0 + 1e-6
    assert (lids[-1], lips[-1], eyes[-1]) == pytest.approx((0.26, 0.03, 0.0)), "calm, with open eyes"
    assert {len(message.names) for message in joints} == {23}


def test_the_emergency_stop_covers_the_head(robot: RobotConfig, hall: WorldConfig) -> None:
    async def script(body: Body) -> tuple[float, float, float, LinkStatus]:
        await turn_head(body, 0.5, 2.0, 0.0)
        body.link.e_stop("a test")
        stopped = pans(body.heard["joints"])[-1]
        await turn_head(body, 1.0, 2.0, 0.0)
        held, status = pans(body.heard["joints"])[-1], body.heard["status"][-1]
        body.link.clear_e_stop()
        await body.clock.sleep(0.3)
        waiting = pans(body.heard["joints"])[-1]
        assert waiting == pytest.approx(held, abs=0.005), "it waits for a new command"
        await turn_head(body, 2.0, 2.0, 0.0)
        return stopped, held, pans(body.heard["joints"])[-1], status

    stopped, held, free, status = live(at(robot, 10, 10), hall, script)
    assert held - stopped < 0.25, "it brakes at once, and its servo follows"
    assert (status.groups[0].guard, status.groups[0].reason) == ("holding", "emergency stop: a test")
    assert free == pytest.approx(2.0, abs=0.005)


def test_a_group_that_yields_can_be_pushed_and_begins_again_where_it_is(
    robot: RobotConfig, hall: WorldConfig, tmp_path: Path
) -> None:
    path = tmp_path / "robot.yaml"
    head = "{joints: [pan_joint, tilt_joint], velocity: 1.05, acceleration: 5.8, stop: yield}"
    path.write_text(f"model: {robot.model}\nworld: {robot.world}\nactuators: {{head: {head}}}\n")
    body = at(load_robot_config(path), 10, 10)

    async def script(body: Body) -> tuple[float, float, float]:
        simulation = body.link._simulation
        assert simulation is not None
        physics = simulation.physics
        joint = physics.model.joint("robot/pan_joint")
        body.link.e_stop("a test")
        await body.clock.sleep(0.1)
        physics.data.qfrc_applied[joint.dofadr[0]] = 1.0
        await body.clock.sleep(1.0)
        physics.data.qfrc_applied[joint.dofadr[0]] = 0.0
        await body.clock.sleep(1.0)
        assert body.heard["status"][-1].groups[0].guard == "yielding"
        pushed = float(physics.data.qpos[joint.qposadr[0]])
        body.link.clear_e_stop()
        await body.clock.sleep(0.5)
        held = float(physics.data.qpos[joint.qposadr[0]])
        await turn_head(body, 0.1, 0.0, 0.0)
        return pushed, held, float(physics.data.qpos[joint.qposadr[0]])

    pushed, held, later = live(body, hall, script)
    assert pushed > 0.05
    assert held == pytest.approx(pushed, abs=0.002)
    assert pushed - 5.8 * 0.1**2 / 2 - 0.002 < later < pushed, "it goes back at its own acceleration"


def test_a_compliant_group_gives_way_by_the_stiffness_it_is_commanded(
    robot: RobotConfig, hall: WorldConfig, tmp_path: Path
) -> None:
    path = tmp_path / "robot.yaml"
    head = "{joints: [pan_joint], compliant: true, stiffness: 100, damping: 10, velocity: 1.05, acceleration: 5.8}"
    path.write_text(f"model: {robot.model}\nworld: {robot.world}\nactuators: {{head: {head}}}\n")

    async def script(body: Body) -> tuple[float, float, float]:
        simulation = body.link._simulation
        assert simulation is not None
        data, joint = simulation.physics.data, simulation.physics.model.joint("robot/pan_joint")
        data.qfrc_applied[joint.dofadr[0]] = 1.0
        await body.clock.sleep(2.0)
        stiff = float(data.qpos[joint.qposadr[0]])
        for _ in range(30):
            soft = JointCommand(body.clock.now(), "head", ("pan_joint",), (0.0,), stiffness=(5.0,), damping=(2.0,))
            body.link.command(soft)
            await body.clock.sleep(0.1)
        gives = float(data.qpos[joint.qposadr[0]])
        await body.clock.sleep(2.0)  # it is held again, where it was pushed to, with the group's stiffness
        return stiff, gives, float(data.qpos[joint.qposadr[0]])

    stiff, gives, held = live(at(load_robot_config(path), 10, 10), hall, script)
    friction = 0.06
    assert stiff == pytest.approx(1.0 / 100, abs=friction / 100)
    assert gives == pytest.approx(1.0 / 5, abs=friction / 5)
    assert held == pytest.approx(gives, abs=0.02)
