"""MobileBaseControl on a body with a laser: what it lets through, and when the operator may override it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.base import paths
from app.base.geometry import Pose2
from app.messages import Exploitation, JointState, LaserScan, LinkStatus, Odometry, TeleopCommand, Twist
from app.robots.actuator_config import circle
from app.robots.config import load_robot_config
from app.runtime.clock import run_virtual
from app.runtime.graph import WiringError
from tests.modules.actuation.surroundings import scan, wall
from tests.modules.fakes import Bench, FakeLink, drain

MODULE = "app.modules.actuation.mobile_base_control:MobileBaseControl"
INPUTS = {
    "teleop": Twist,
    "path": Twist,
    "scans": LaserScan,
    "odometry": Odometry,
    "operator": TeleopCommand,
}
IRL1 = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
OUTPUTS = {"exploitation": Exploitation, "status": LinkStatus}
SETTINGS = {
    "behaviors": [
        {"input": "teleop", "behavior": "Teleop", "priority": 3},
        {"input": "path", "behavior": "PlanAndFollowPath", "priority": 2},
    ]
}
Surroundings = Callable[[float], LaserScan]


def open_floor(stamp: float) -> LaserScan:
    return scan(stamp)


class Drive:
    """The module with a laser at 40 Hz that sees ``surroundings``, and an operator who holds a command."""

    def __init__(
        self,
        *,
        laser: bool = True,
        footprint: bool = True,
        monitor: str = "on",
        wired: bool = True,
        arms: bool = False,
        joints: bool = False,
    ) -> None:
        """``arms``: the body has the robot's arms; ``joints``: their joints are wired."""
        link = FakeLink(without=() if laser else ("hokuyo",))
        groups = dict(IRL1.groups) if arms else {}
        link.description = replace(
            link.description, footprint=circle(0.28) if footprint else (), groups=groups, model_path=IRL1.model
        )
        inputs = {name: kind for name, kind in INPUTS.items() if wired or name != "scans"}
        self.bench = Bench(
            MODULE,
            inputs=inputs | ({"joints": JointState} if joints else {}),
            outputs=OUTPUTS,
            settings={**SETTINGS, "collision_monitor": monitor},
            link=link,
        )
        self.surroundings: Surroundings | None = open_floor
        self.override = False
        self.sequence = 0
        self.place = Pose2()
        #: Where the joints are; None: nothing is heard of them.
        self.joints: dict[str, float] | None = {} if joints else None

    async def __aenter__(self) -> Drive:
        await self.bench.__aenter__()
        self.exploitations = self.bench.listen("exploitation")
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.bench.__aexit__(*error)

    async def go(self, seconds: float, linear: float, angular: float = 0.0, port: str = "teleop") -> None:
        clock = self.bench.clock
        for step in range(round(seconds / 0.025)):
            if self.surroundings is not None:
                self.bench.feed("scans", self.surroundings(clock.now()))
            self.bench.feed("odometry", Odometry(clock.now(), self.place, 0.0, 0.0))
            if self.joints is not None:
                self.bench.feed("joints", JointState(clock.now(), tuple(self.joints), tuple(self.joints.values())))
            if step % 2 == 0:
                self.sequence += 1
                if port == "teleop":
                    drive = TeleopCommand(clock.now(), "ada", self.sequence, True, 1.0, 0.0, self.override)
                    self.bench.feed("operator", drive)
                self.bench.feed(port, Twist(clock.now(), linear, angular))
            await clock.sleep(0.025)

    @property
    def sent(self) -> Twist:
        return self.bench.link.commands[-1][1]

    @property
    def limited(self) -> str:
        return str(drain(self.exploitations)[-1].limited)


def test_in_the_open_it_drives_as_ever() -> None:
    async def main() -> None:
        async with Drive() as d:
            await d.go(1.5, 0.4, 0.5)
            assert (d.sent.linear_mps, d.sent.angular_radps) == pytest.approx((0.4, 0.5))
            assert d.limited == ""

    run_virtual(main())


@pytest.mark.parametrize("port", ["teleop", "path"])
def test_every_driver_is_slowed_and_stopped_before_a_wall(port: str) -> None:
    async def main() -> None:
        async with Drive() as d:
            await d.go(1.5, 0.4, port=port)
            d.surroundings = lambda stamp: wall(stamp, 0.6)
            await d.go(0.2, 0.4, port=port)
            assert 0.1 < d.sent.linear_mps < 0.35
            assert d.limited.startswith("slowed: something 0.3 m ahead")
            d.surroundings = lambda stamp: wall(stamp, 0.34)
            await d.go(0.2, 0.4, port=port)
            assert d.sent.linear_mps == 0.0
            assert d.limited == "stopped: something 0.1 m ahead"
            await d.go(0.5, -0.4, port=port)
            assert d.sent.linear_mps == pytest.approx(-0.1), "away from it, where the laser does not see"

    run_virtual(main())


def test_a_stop_waits_for_no_beat_and_no_command() -> None:
    async def main() -> None:
        async with Drive() as d:
            await d.go(1.5, 0.4)
            d.bench.link.commands.clear()
            seen_at = d.bench.clock.now()
            d.bench.feed("scans", wall(seen_at, 0.34))
            await d.bench.settle()
            when, twist = d.bench.link.commands[0]
            assert when == seen_at
            assert twist.linear_mps == 0.0
            assert drain(d.exploitations)[-1].limited == "stopped: something 0.1 m ahead", "reported with it"

    run_virtual(main())


def test_without_a_fresh_scan_nothing_drives() -> None:
    async def main() -> None:
        async with Drive() as d:
            d.surroundings = None
            await d.go(0.5, 0.4)
            assert d.sent.linear_mps == 0.0
            assert d.limited == "stopped: the laser has given no scan yet"
            d.surroundings = open_floor
            await d.go(1.5, 0.4)
            assert d.sent.linear_mps == pytest.approx(0.4)
            d.surroundings = None
            d.bench.link.commands.clear()
            last = d.bench.clock.now() - 0.025
            await d.go(1.0, 0.4)
            stopped = next(when for when, twist in d.bench.link.commands if twist.linear_mps == 0.0)
            assert 0.3 <= stopped - last <= 0.35
            assert d.limited == "stopped: the laser gives no new scans"
            d.override = True
            await d.go(0.5, 0.4)
            assert d.sent.linear_mps == pytest.approx(0.1)
            assert d.limited.startswith("override")

    run_virtual(main())


@pytest.mark.parametrize("off_s", [5.0, math.nan])
def test_a_scan_of_no_time_that_could_be_is_none(off_s: float) -> None:
    async def main() -> None:
        async with Drive() as d:
            d.surroundings = lambda stamp: open_floor(stamp + off_s)
            await d.go(0.5, 0.4)
            # One is enough: it would be fresh for as long as its clock is ahead.
            d.surroundings = None
            await d.go(0.5, 0.4)
            assert d.sent.linear_mps == 0.0
            assert d.limited == "stopped: the laser's stamps are not of the robot's clock"

    run_virtual(main())


@pytest.mark.parametrize("reading", [0.0, 0.05, math.nan])
def test_a_laser_that_measures_nothing_is_not_an_open_floor(reading: float) -> None:
    def covered(stamp: float) -> LaserScan:
        return replace(open_floor(stamp), ranges=np.full(720, reading, np.float32))

    async def main() -> None:
        async with Drive() as d:
            await d.go(1.0, 0.4)
            d.surroundings = covered
            await d.go(0.1, 0.4)
            assert d.sent.linear_mps == 0.0
            assert d.limited == "stopped: no ray of the laser measures anything: is it covered?"

    run_virtual(main())


def test_what_is_driven_while_it_brakes_to_a_slower_command_is_judged_too() -> None:
    async def main() -> None:
        async with Drive() as d:
            await d.go(1.5, 0.4)
            await d.go(0.05, 0.1)
            assert d.sent.linear_mps > 0.3, "it still rolls on"
            d.surroundings = lambda stamp: wall(stamp, 0.5)
            await d.go(0.05, 0.1)
            assert d.sent.linear_mps < 0.25

    run_virtual(main())


def test_the_override_crawls_only_while_it_is_held_and_only_by_hand() -> None:
    async def main() -> None:
        async with Drive() as d:
            d.surroundings = lambda stamp: wall(stamp, 0.34)
            await d.go(0.5, 0.4)
            assert d.sent.linear_mps == 0.0
            d.override = True
            await d.go(0.5, 0.4)
            assert d.sent.linear_mps == pytest.approx(0.1)
            d.override = False
            await d.go(0.05, 0.4)
            assert d.sent.linear_mps == 0.0
            # The operator holds the override, but another behavior drives: its twists, the operator's hold.
            d.bench.feed("operator", TeleopCommand(d.bench.clock.now(), "ada", d.sequence + 1, True, 1.0, 0.0, True))
            await d.bench.clock.sleep(0.3)
            for _ in range(10):
                d.bench.feed("operator", TeleopCommand(d.bench.clock.now(), "ada", d.sequence + 1, True, 1, 0, True))
                await d.go(0.05, 0.4, port="path")
            assert d.sent.linear_mps == 0.0
            assert d.limited.startswith("stopped")

    run_virtual(main())


@pytest.mark.parametrize(
    "hold",
    [
        {"held": False, "override": True},
        {"held": True, "override": False},
        {"held": True, "override": True, "age_s": 0.3},
    ],
)
def test_what_is_no_hold_overrides_nothing(hold: dict[str, Any]) -> None:
    async def main() -> None:
        async with Drive() as d:
            d.surroundings = lambda stamp: wall(stamp, 0.34)
            for number in range(10):
                now = d.bench.clock.now()
                d.bench.feed("scans", wall(now, 0.34))
                stamp = now - hold.get("age_s", 0.0)
                d.bench.feed("operator", TeleopCommand(stamp, "ada", number, hold["held"], 1, 0, hold["override"]))
                d.bench.feed("teleop", Twist(now, 0.4, 0.0))
                await d.bench.clock.sleep(0.025)
                assert d.sent.linear_mps == 0.0

    run_virtual(main())


def test_an_old_scan_is_moved_by_odometry() -> None:
    async def main() -> None:
        async with Drive() as d:
            d.surroundings = lambda stamp: wall(stamp, 1.0)
            await d.go(1.5, 0.4)
            assert d.sent.linear_mps == pytest.approx(0.4)
            d.surroundings = None
            d.place = Pose2(0.4)
            await d.go(0.1, 0.4)
            assert d.sent.linear_mps < 0.35

    run_virtual(main())


@pytest.mark.parametrize(
    ("without", "why"),
    [
        ({"laser": False}, "has no laser"),
        ({"laser": False, "wired": False}, "has no laser"),
        ({"footprint": False}, "has no footprint"),
        ({"monitor": "off"}, "runs with its collision monitor switched off (collision_monitor: off)"),
        ({"monitor": "off", "wired": False}, "runs with its collision monitor switched off (collision_monitor: off)"),
    ],
)
def test_without_laser_or_footprint_or_switched_off_there_is_no_monitor_and_people_know(
    without: dict[str, Any], why: str
) -> None:
    async def main() -> None:
        async with Drive(**without) as d:
            d.surroundings = (lambda stamp: wall(stamp, 0.1)) if without.get("wired", True) else None
            await d.go(1.5, 0.4)
            assert d.sent.linear_mps == pytest.approx(0.4)
            cautions = d.bench.slot.module.cautions()
            assert [(caution.title, caution.text) for caution in cautions] == [
                ("No collision monitor", f"a test body {why}: nothing keeps it from driving into things")
            ]

    run_virtual(main())


def test_with_its_monitor_there_is_nothing_to_know() -> None:
    assert Drive().bench.slot.module.cautions() == ()


def test_a_body_whose_joints_are_not_wired_says_so() -> None:
    (caution,) = Drive(arms=True).bench.slot.module.cautions()
    assert caution.title == "Joints are not watched"
    assert Drive(arms=True, joints=True).bench.slot.module.cautions() == ()


def test_an_arm_stretched_aside_is_not_driven_into_what_the_body_would_pass() -> None:
    async def main() -> None:
        async with Drive(arms=True, joints=True) as d:
            d.surroundings = lambda stamp: scan(stamp, [(0.3, 0.45)])
            await d.go(1.0, 0.2)
            assert (d.sent.linear_mps, d.limited) == (pytest.approx(0.2), ""), "the arms hang"
            d.joints = {"left_shoulder_roll_joint": 0.9, "left_shoulder_pitch_joint": -0.5}
            await d.go(0.3, 0.2)
            assert d.sent.linear_mps == 0.0
            assert d.limited.startswith("stopped: something")
            d.joints = {}
            await d.go(1.5, 0.2)
            assert (d.sent.linear_mps, d.limited) == (pytest.approx(0.2), "")

    run_virtual(main())


def test_while_the_joints_are_not_known_the_outline_is_the_widest() -> None:
    async def main() -> None:
        async with Drive(arms=True, joints=True) as d:
            d.joints = None
            d.surroundings = lambda stamp: scan(stamp, [(0.3, -0.65)])
            await d.go(0.3, 0.2)
            assert d.sent.linear_mps == 0.0, "none came yet"
            d.joints = {}
            await d.go(1.5, 0.2)
            assert (d.sent.linear_mps, d.limited) == (pytest.approx(0.2), "")
            d.joints = None
            await d.go(0.25, 0.2)
            assert d.sent.linear_mps == pytest.approx(0.2), "they are young enough"
            await d.go(0.3, 0.2)
            assert d.sent.linear_mps == 0.0, "they are too old"

    run_virtual(main())


def test_a_body_with_a_laser_whose_scans_are_not_wired_is_refused() -> None:
    with pytest.raises(WiringError, match=r"Tested\.inputs: Tested has no input scans, and a test body has a laser"):
        Drive(wired=False)


def test_a_behavior_cannot_come_in_by_the_monitors_inputs() -> None:
    with pytest.raises(WiringError, match="brings no behavior's commands"):
        Bench(
            MODULE,
            inputs={"scans": Twist},
            outputs=OUTPUTS,
            settings={"behaviors": [{"input": "scans", "behavior": "A", "priority": 1}]},
        )
