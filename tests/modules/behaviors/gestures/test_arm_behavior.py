"""The modules of the gestures: which desire they serve, what they publish and report, what they refuse."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import Accomplishment, Exploitation, JointCommand, JointState, Localization, Odometry, Twist
from app.modules.behaviors.gestures.gesture_parameters import HOLD, POINT_AT, REACH, RELEASE, REST, WAVE
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.actuation.arms import JOINTS, LEFT_NAMES, link
from tests.modules.behaviors.gestures.ideal_arms import IdealBody, beside_deg
from tests.modules.fakes import Bench, FakeLink, drain

MODULES = {
    "PointAt": "point_at:PointAt",
    "Reach": "reach:Reach",
    "Wave": "wave:Wave",
    "Rest": "rest:Rest",
    "Hold": "grip:Hold",
    "Release": "grip:Release",
}
CLASSES = DesireClasses([POINT_AT, REACH, WAVE, REST, HOLD, RELEASE])


class Scene:
    """One behavior, on arms that go where it commands them."""

    def __init__(self, behavior: str, body: FakeLink | None = None) -> None:
        self.workspace = IntentionWorkspace(CLASSES, VirtualClock().now)
        self.body = IdealBody()
        pointed = {"odometry": Odometry, "localization": Localization} if behavior in ("PointAt", "Reach") else {}
        twist = {"twist": Twist} if behavior == "PointAt" else {}
        self.bench = Bench(
            f"app.modules.behaviors.gestures.{MODULES[behavior]}",
            inputs={"joints": JointState, "left": Exploitation, "right": Exploitation, **pointed},
            outputs={"command": JointCommand, "accomplishments": Accomplishment, **twist},
            link=body or link(),
            services={IntentionWorkspace: self.workspace},
            attended=("command", *twist),
        )
        self.behavior = behavior
        self.commands: list[JointCommand] = []
        self.twists: list[Twist] = []
        self.reports: list[Accomplishment] = []
        #: By side, what the arm's arbiter reports: whose command it lets through, and why it does not.
        self.arbiters: dict[str, tuple[str, str]] = {}

    def desire(self, **params: Any) -> str:
        source = Source("operator", "a test")
        return self.workspace.add(self.behavior, intensity=4, utility=1, params=params, source=source).id

    async def run(self, seconds: float, opened: bool = True) -> None:
        """For ``seconds``, with the outputs open or closed; what is commanded moves the arms."""
        outputs = ("command", "twist") if self.behavior == "PointAt" else ("command",)
        heard = {port: self.bench.listen(port) for port in (*outputs, "accomplishments")}
        self.bench.graph.filters.apply({f"Tested.{port}": 1 if opened else math.inf for port in outputs})
        for _ in range(round(seconds / 0.1)):
            now = self.bench.clock.now()
            for side, (behavior, limited) in self.arbiters.items():
                group = f"{side}_arm"
                self.bench.feed(side, Exploitation(now, behavior, Twist(now, 0.0, 0.0), limited, group=group))
            self.bench.feed("joints", JointState(now, JOINTS, tuple(self.body.joints[name] for name in JOINTS)))
            await self.bench.clock.sleep(0.1)
            for command in drain(heard["command"]):
                self.commands.append(command)
                self.body.obey(command)
            for report in drain(heard["accomplishments"]):
                self.reports.append(report)
                self.workspace.accomplish(report)
            if "twist" in heard:
                self.twists += drain(heard["twist"])
        for port, subscription in heard.items():
            self.bench.graph.channel(port).unsubscribe(subscription)


@in_virtual_time
async def test_a_desire_is_served_until_it_is_done_and_reported_once() -> None:
    scene = Scene("Reach")
    async with scene.bench:
        await scene.run(0.5)
        assert scene.commands == [], "no desire"
        desire = scene.desire(x=0.35, y=0.25, z=0.95, frame="base_link", stiffness="soft")
        await scene.run(0.5, opened=False)
        assert scene.commands == [], "attention keeps it closed"
        await scene.run(5.0)
        assert [(r.desire_id, r.outcome, r.reason) for r in scene.reports] == [
            (desire, "done", "the left hand is there")
        ]
        assert {c.group for c in scene.commands} == {"left_arm"}
        assert scene.commands[0].stiffness == pytest.approx((20.0,) * 4)
        scene.commands.clear()
        await scene.run(1.0)
        assert scene.commands == [], "the desire has left, and the guard holds the arm"


@in_virtual_time
async def test_changed_parameters_begin_again() -> None:
    scene = Scene("Reach")
    async with scene.bench:
        desire = scene.desire(x=0.35, y=0.25, z=0.95, frame="base_link", hold_s=60)
        await scene.run(4.0)
        scene.workspace.change(desire, params={"x": 0.3, "y": -0.3, "z": 1.0, "frame": "base_link", "arm": "right"})
        await scene.run(5.0)
        assert [(r.desire_id, r.outcome) for r in scene.reports] == [(desire, "done")]
        assert scene.commands[-1].group == "right_arm"


@in_virtual_time
async def test_a_point_in_the_room_waits_for_odometry_and_one_on_the_map_for_localization() -> None:
    scene = Scene("PointAt")
    async with scene.bench:
        desire = scene.desire(x=0.0, y=2.0, z=1.0, frame="odom", hold_s=0)
        await scene.run(1.0)
        assert scene.commands == []
        scene.bench.feed("odometry", Odometry(scene.bench.clock.now(), Pose2(0.0, 0.0, math.pi / 2), 0.0, 0.0))
        await scene.run(5.0)
        assert [(r.desire_id, r.outcome) for r in scene.reports] == [(desire, "done")]
        assert min(beside_deg(side, scene.body, np.array([2.0, 0.0, 1.0])) for side in ("left", "right")) < 5.0
        scene.desire(x=0.0, y=2.0, z=1.0, frame="map", hold_s=0)
        scene.commands.clear()
        await scene.run(1.0)
        assert scene.commands == []
        assert scene.twists == []


@in_virtual_time
async def test_pointing_behind_turns_the_base_and_stops_it_when_the_desire_leaves() -> None:
    scene = Scene("PointAt")
    async with scene.bench:
        scene.bench.feed("odometry", Odometry(scene.bench.clock.now(), Pose2(), 0.0, 0.0))
        desire = scene.desire(x=-2.0, y=0.5, z=1.0, frame="odom")
        await scene.run(2.0)
        assert all(twist.angular_radps > 0.1 and twist.linear_mps == 0.0 for twist in scene.twists)
        assert len(scene.twists) > 10
        assert scene.commands == []
        scene.workspace.remove(desire)
        scene.twists.clear()
        await scene.run(1.0)
        assert [twist.angular_radps for twist in scene.twists] == [0.0]
        scene.desire(x=-2.0, y=0.5, z=1.0, frame="odom")
        await scene.run(1.0)
        scene.twists.clear()
        await scene.run(1.0, opened=False)
        assert [twist.angular_radps for twist in scene.twists] == [0.0], "the last word"


@in_virtual_time
async def test_what_cannot_be_done_fails_with_the_reason() -> None:
    scene = Scene("Reach")
    async with scene.bench:
        scene.desire(x=3.0, y=0.0, z=1.0, frame="base_link")
        scene.desire(x=0.35, y=0.25, z=0.95, frame="base_link", stiffness_nm=900)
        await scene.run(1.0)
        reasons = [(r.outcome, r.reason) for r in scene.reports]
        assert reasons[0] == ("failed", "a stiffness of 900 is not within 0 to 300, which left_arm takes")
        assert reasons[1][0] == "failed"
        assert "the arm reaches 0.5" in reasons[1][1]
        assert scene.commands == []


@in_virtual_time
async def test_a_refusal_of_the_arbiter_ends_the_gesture() -> None:
    scene = Scene("Wave")
    async with scene.bench:
        scene.body.stuck = LEFT_NAMES
        scene.desire(arm="left")
        await scene.run(0.3)
        reason = "left_forearm_link would touch head_link"
        scene.arbiters["left"] = ("Tested", reason)
        await scene.run(2.0)
        assert [(r.outcome, r.reason) for r in scene.reports] == [("failed", reason)]


@in_virtual_time
async def test_it_waves_with_the_arm_that_no_other_behavior_commands() -> None:
    scene = Scene("Wave")
    async with scene.bench:
        scene.arbiters["right"] = ("PointAt", "")
        await scene.run(0.2)
        scene.desire(times=2)
        await scene.run(12.0)
        assert [(r.outcome, r.reason) for r in scene.reports] == [("done", "the left arm waved")]
        assert {c.group for c in scene.commands} == {"left_arm"}


@in_virtual_time
async def test_both_arms_rest_and_one_gripper_opens() -> None:
    scene = Scene("Rest")
    async with scene.bench:
        scene.desire()
        await scene.run(3.0)
        assert [r.outcome for r in scene.reports] == ["done"]
        assert {c.group for c in scene.commands} == {"left_arm", "right_arm"}
    scene = Scene("Release")
    async with scene.bench:
        scene.desire(arm="left")
        await scene.run(3.0)
        assert [r.outcome for r in scene.reports] == ["done"]
        assert {c.group for c in scene.commands} == {"left_gripper"}


@in_virtual_time
async def test_a_body_without_arms_is_refused() -> None:
    scene = Scene("Wave", FakeLink())
    async with scene.bench as bench:
        assert "a test body has none: name them under `arms` of its file" in bench.problem
