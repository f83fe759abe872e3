"""The collision monitor in the simulated world: real braking, real noise, people who step in the way."""

from __future__ import annotations

import random
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

import pytest

from app.link import RobotLink
from app.messages import Exploitation, JointCommand, Twist
from app.robots.config import RobotConfig
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock, run_virtual
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.supervisor import Supervisor
from tests.robots.conftest import hall, make_hall, robot

pytestmark = pytest.mark.slow

T = TypeVar("T")
__all__ = ["hall", "robot"]

CHANNELS = {
    "hand": {"type": "Twist", "external": True},
    "scan": {"type": "LaserScan", "rate_hz": 40},
    "odometry": {"type": "Odometry", "rate_hz": 100},
    "joints": {"type": "JointState", "rate_hz": 30},
    "exploitation": {"type": "Exploitation", "rate_hz": 10},
    "link_status": {"type": "LinkStatus", "rate_hz": 20},
}
MODULES: dict[str, dict[str, Any]] = {
    "Hokuyo": {"class": "app.modules.sensors.hokuyo:Hokuyo", "outputs": {"scans": "scan"}},
    "WheelOdometry": {
        "class": "app.modules.sensors.wheel_odometry:WheelOdometry",
        "outputs": {"odometry": "odometry", "joints": "joints"},
    },
    "MobileBaseControl": {
        "class": "app.modules.actuation.mobile_base_control:MobileBaseControl",
        "inputs": {"teleop": "hand", "scans": "scan", "odometry": "odometry", "joints": "joints"},
        "outputs": {"exploitation": "exploitation", "status": "link_status"},
    },
}


class Ride:
    """The base, its sensors and its control in a world, driven by twists."""

    def __init__(self, link: LockstepLink, clock: VirtualClock, graph: Graph) -> None:
        self.link, self.clock, self.graph = link, clock, graph
        self.exploitations = graph.channel("exploitation").subscribe("test", capacity=10_000)

    async def drive(self, linear: float, angular: float, seconds: float, lateral: float = 0.0) -> None:
        for _ in range(round(seconds / 0.05)):
            self.graph.channel("hand").publish(Twist(self.clock.now(), linear, angular, lateral))
            await self.clock.sleep(0.05)

    def limits(self) -> list[str]:
        """What was said about limits since this was asked last."""
        found: list[str] = []
        while self.exploitations.waiting:
            message: Exploitation = self.exploitations.receive_nowait()
            if message.limited and (not found or found[-1] != message.limited):
                found.append(message.limited)
        return found


def ride(
    body: RobotConfig,
    world: WorldConfig,
    script: Callable[[Ride], Awaitable[T]],
    people: list[dict[str, Any]] | None = None,
) -> T:
    """Run ``script`` in virtual time; ``people`` as in a scenario."""
    scenario = ScenarioConfig.model_validate({"name": "people", "people": people}) if people else None

    async def run() -> T:
        clock = VirtualClock()
        link = LockstepLink(body, world, clock, scenario)
        graph = Graph(
            clock=clock,
            channels={name: ChannelSpec.model_validate(spec) for name, spec in CHANNELS.items()},
            modules={name: ModuleSpec.model_validate(spec) for name, spec in MODULES.items()},
            services={RobotLink: link},
        )
        await link.start()
        try:
            async with Supervisor(graph.modules, clock):
                ride = Ride(link, clock, graph)
                await clock.sleep(0.1)
                return await script(ride)
        finally:
            await link.stop()

    return run_virtual(run())


def at(body: RobotConfig, x: float, y: float, heading_deg: float = 0.0) -> RobotConfig:
    start = body.start.model_copy(update={"x": x, "y": y, "heading_deg": heading_deg})
    return body.model_copy(update={"start": start})


def test_a_person_who_steps_in_front_is_not_touched(robot: RobotConfig, hall: WorldConfig) -> None:
    """At 0.4 m/s; the person walks in from aside and stops where the base is about to be."""
    line_m, walk_m, ahead_m, speed_mps = 0.6, 0.9, 0.75, 1.5
    reached_s = 1.0 + (line_m - 0.2) / 0.4  # it speeds up for one second
    there = (10 + line_m + 0.28 + ahead_m, 10.0)
    person = {
        "name": "one", "face": "pilot", "at": (there[0], there[1] + walk_m), "heading_deg": -90,
        "script": [{"wait": reached_s - walk_m / speed_mps}, {"walk": there, "speed": speed_mps}, {"wait": 99}],
    }  # fmt: skip

    async def script(ride: Ride) -> tuple[list[str], float, float]:
        await ride.drive(0.4, 0.0, reached_s)
        fast = ride.link.true_pose().x
        await ride.drive(0.4, 0.0, 3.5)
        assert ride.link.contacts == ()
        return ride.limits(), fast, ride.link.true_pose().x

    limits, fast, stood = ride(at(robot, 10, 10), hall, script, [person])
    assert fast == pytest.approx(10 + line_m, abs=0.1), "it was under way"
    assert limits[0].startswith("slowed: something")
    assert limits[-1].startswith("stopped: something 0.1 m ahead")
    assert there[0] - stood > 0.28 + 0.1, "it stands before the person, not at their feet"


@pytest.mark.parametrize("aside_m", [0.0, 0.1])
def test_a_doorway_of_a_metre_is_driven_through(robot: RobotConfig, aside_m: float) -> None:
    """Between its posts it is 0.87 m wide: in the middle at full speed, along a post more slowly."""
    door = {"at": 10, "width": 1.0}
    world = make_hall(walls=[{"from": (10, 0), "to": (10, 20), "material": "wall", "thickness": 0.15, "doors": [door]}])

    async def script(ride: Ride) -> None:
        await ride.drive(0.4, 0.0, 4.0 if aside_m else 3.0)
        said = ride.limits()
        assert ride.link.contacts == ()
        assert ride.link.true_pose().x > 10.1
        assert not said if aside_m == 0.0 else all(text.startswith("slowed") for text in said)

    ride(at(robot, 9.25, 10.0 + aside_m), world, script)


def test_an_arm_stretched_forward_stops_before_the_wall(robot: RobotConfig, hall: WorldConfig) -> None:
    shoulder = ("left_shoulder_pitch_joint",)

    async def script(ride: Ride) -> tuple[float, list[str]]:
        for _ in range(30):
            ride.link.command(JointCommand(ride.clock.now(), "left_arm", shoulder, (-1.57,)))
            await ride.clock.sleep(0.1)
        ride.limits()
        for _ in range(60):
            ride.link.command(JointCommand(ride.clock.now(), "left_arm", shoulder, (-1.57,)))
            await ride.drive(0.3, 0.0, 0.1)
        assert ride.link.contacts == ()
        return ride.link.true_pose().x, ride.limits()

    stood, limits = ride(at(robot, 18.5, 10), hall, script)
    wall, hand = 19.9, 0.52
    assert wall - 0.15 < stood + hand < wall
    assert limits[-1].startswith("stopped: something")


def test_hands_that_push_on_at_random_touch_nothing(robot: RobotConfig) -> None:
    """Forward and round among boxes and posts, whatever is in the way."""
    boxes = [
        {"kind": "box", "at": (x, y), "yaw_deg": 20 * x, "size": [0.5, 0.4, 0.6]}
        for x, y in ((11.2, 10.4), (10.6, 11.6), (9.2, 11.4), (8.6, 10.0), (9.4, 8.7), (10.9, 8.9), (11.6, 9.6))
    ]
    chance = random.Random(5)

    async def script(ride: Ride) -> None:
        for _ in range(10):
            await ride.drive(0.4, chance.uniform(-1.0, 1.0), 0.8)
        assert ride.link.contacts == ()
        said = ride.limits()
        assert any(text.startswith("stopped") for text in said), "there was something to run into"

    ride(at(robot, 10, 10), make_hall(objects=boxes), script)


def test_out_of_a_tight_place_it_crawls_back_and_turns(robot: RobotConfig, hall: WorldConfig) -> None:
    async def script(ride: Ride) -> None:
        await ride.drive(0.4, 0.0, 3.0)
        stood = ride.link.true_pose()
        assert ride.limits()[-1].startswith("stopped")
        await ride.drive(-0.4, 0.0, 2.0)
        back = ride.link.true_pose()
        assert 0.12 < stood.x - back.x < 0.21
        assert ride.limits()[-1] == "slowed: the laser does not see behind"
        await ride.drive(0.0, 1.0, 1.0)
        assert ride.link.true_pose().theta > 0.7
        assert ride.link.contacts == ()

    ride(at(robot, 19.25, 10.0), hall, script)


def test_a_holonomic_base_strafes_to_a_wall_and_stops_before_it(robot: RobotConfig, hall: WorldConfig) -> None:
    """Its laser sees all around; the wall is 0.9 m to the left."""
    limits = robot.limits.model_copy(update={"lateral_mps": 0.3})
    base = robot.base.model_copy(update={"drive": "holonomic"})
    assert robot.streams.hokuyo is not None
    laser = robot.streams.hokuyo.model_copy(update={"fov_deg": 360.0})
    streams = robot.streams.model_copy(update={"hokuyo": laser})
    body = robot.model_copy(update={"limits": limits, "base": base, "streams": streams})

    async def script(ride: Ride) -> None:
        start = ride.link.true_pose()
        await ride.drive(0.0, 0.0, 2.0, lateral=0.3)
        went = ride.link.true_pose()
        assert went.y - start.y > 0.3
        assert abs(went.x - start.x) < 0.02
        assert abs(went.theta) < 0.02
        await ride.drive(0.0, 0.0, 6.0, lateral=0.3)
        assert ride.limits()[-1].startswith("stopped: something 0.1 m to the left")
        assert ride.link.contacts == ()
        assert ride.link.true_pose().y < 20.0 - 0.28
        await ride.drive(0.2, -0.5, 2.0, lateral=-0.2)
        assert ride.link.true_pose().y < 19.6, "away from it nothing is in the way"
        assert ride.link.contacts == ()

    ride(at(body, 10, 19.1), hall, script)
