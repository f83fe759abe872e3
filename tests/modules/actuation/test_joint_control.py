from __future__ import annotations

import math
from typing import Any

import pytest

from app.messages import Exploitation, JointCommand, JointState
from app.runtime.clock import in_virtual_time
from app.runtime.graph import WiringError
from tests.modules.actuation.arms import INTO_THE_TORSO, LEFT_NAMES, REST, joint_state, link
from tests.modules.fakes import Bench, drain

MODULE = "app.modules.actuation.joint_control:JointControl"
BEHAVIORS = [
    {"input": "look", "behavior": "LookAt", "priority": 1},
    {"input": "nod", "behavior": "Nod", "priority": 2},
]


def bench(group: str = "head", behaviors: list[dict[str, Any]] = BEHAVIORS) -> Bench:
    return Bench(
        MODULE,
        inputs={behavior["input"]: JointCommand for behavior in behaviors},
        outputs={"exploitation": Exploitation},
        settings={"group": group, "behaviors": behaviors},
    )


def command(b: Bench, pan: float, group: str = "head") -> JointCommand:
    return JointCommand(b.clock.now(), group, ("pan",), (pan,))


@in_virtual_time
async def test_the_highest_priority_commands_the_joints_and_is_reported() -> None:
    async with bench() as b:
        reports = b.listen("exploitation")
        await b.clock.sleep(1.0)
        assert [(e.behavior, e.group) for e in drain(reports)] == [(None, "head")] * 10
        assert b.link.joint_commands == [], "nothing is given without a command: the guard has the last word"
        asked = b.clock.now()
        b.feed("look", command(b, 0.5))
        await b.settle()
        assert [(c.stamp, c.positions) for c in b.link.joint_commands] == [(asked, (0.5,))], "it waits for no beat"
        assert [(e.stamp, e.behavior) for e in drain(reports)] == [(asked, "LookAt")]
        b.feed("nod", command(b, -0.5))
        b.feed("look", command(b, 0.6))
        await b.settle()
        assert b.link.joint_commands[-1].positions == (-0.5,)
        latest = drain(reports)[-1]
        assert (latest.behavior, latest.outdone) == ("Nod", ("LookAt",))
        await b.clock.sleep(0.5)
        assert drain(reports)[-1].behavior is None
        given = len(b.link.joint_commands)
        await b.clock.sleep(1.0)
        assert len(b.link.joint_commands) == given


@in_virtual_time
async def test_a_command_is_given_again_at_each_beat_while_it_is_fresh() -> None:
    async with bench() as b:
        asked = b.clock.now()
        b.feed("look", command(b, 0.5))
        await b.clock.sleep(1.0)
        stamps = [c.stamp - asked for c in b.link.joint_commands]
        assert len(stamps) == 3
        assert all(0 <= stamp <= 0.25 for stamp in stamps)


@in_virtual_time
async def test_commands_that_are_no_numbers_or_of_another_group_are_never_given(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with bench() as b:
        b.feed("nod", command(b, math.nan))
        b.feed("look", command(b, 0.5))
        await b.settle()
        assert [c.positions for c in b.link.joint_commands] == [(0.5,)]
        b.link.joint_commands.clear()
        await b.clock.sleep(0.5)
        b.link.joint_commands.clear()
        for _ in range(3):
            b.feed("look", command(b, 0.5, group="arm"))
            await b.settle()
        assert b.link.joint_commands == []
    assert [r.getMessage() for r in caplog.records].count(
        "look brings commands of the group arm; they are ignored"
    ) == 1  # fmt: skip


def test_a_group_that_the_body_does_not_have_is_refused() -> None:
    with pytest.raises(
        WiringError, match=r"commands the actuator group 'tail', which a test body does not have .*head"
    ):
        bench(group="tail")


def test_two_behaviors_cannot_share_an_input() -> None:
    with pytest.raises(WiringError, match="an input of its own"):
        bench(behaviors=[BEHAVIORS[0], {**BEHAVIORS[1], "input": "look"}])


def arm_bench(joints: bool = True, arm_check: bool = True) -> Bench:
    return Bench(
        MODULE,
        inputs={"look": JointCommand, "nod": JointCommand, **({"joints": JointState} if joints else {})},
        outputs={"exploitation": Exploitation},
        settings={"group": "left_arm", "behaviors": BEHAVIORS, "arm_check": arm_check},
        link=link(),
    )


def arm_command(b: Bench, positions: tuple[float, ...]) -> JointCommand:
    return JointCommand(b.clock.now(), "left_arm", LEFT_NAMES, positions)


@in_virtual_time
async def test_an_arms_way_into_the_body_is_refused_with_the_reason_and_the_arm_is_held() -> None:
    async with arm_bench() as b:
        reported = b.listen("exploitation")
        b.feed("joints", joint_state(b.clock.now(), REST))
        await b.settle()
        b.feed("look", arm_command(b, INTO_THE_TORSO))
        await b.settle()
        assert [c.positions for c in b.link.joint_commands] == [REST]
        assert [(e.behavior, e.limited) for e in drain(reported)] == [
            ("LookAt", "left_forearm_link would touch torso_link")
        ]
        b.feed("look", arm_command(b, (-1.0, 0.1, 0.0, 0.0)))
        await b.settle()
        assert b.link.joint_commands[-1].positions == (-1.0, 0.1, 0.0, 0.0)
        assert drain(reported)[-1].limited == ""


@in_virtual_time
async def test_what_comes_in_a_moving_arms_way_stops_it_with_the_next_positions() -> None:
    async with arm_bench() as b:
        for n in range(4):
            b.feed("joints", joint_state(b.clock.now(), (-0.2 - 0.04 * n, 0.0, -0.8, -1.27)))
            b.feed("look", arm_command(b, (-1.22, 0.0, -0.8, -1.27)))
            await b.clock.sleep(1 / 30)
        assert {c.positions for c in b.link.joint_commands} == {(-1.22, 0.0, -0.8, -1.27)}
        b.feed("joints", joint_state(b.clock.now(), (-0.36, 0.0, -0.8, -1.27), (-1.36, 0.05, 1.0, -1.14)))
        await b.settle()
        assert -0.75 < b.link.joint_commands[-1].positions[0] < -0.36


@in_virtual_time
async def test_a_behavior_may_command_several_groups_on_one_channel(caplog: pytest.LogCaptureFixture) -> None:
    async with arm_bench() as b:
        b.feed("joints", joint_state(b.clock.now(), REST))
        b.feed("look", arm_command(b, REST))
        b.feed("look", JointCommand(b.clock.now(), "right_arm", (), ()))
        await b.settle()
        assert [c.group for c in b.link.joint_commands] == ["left_arm"]
    assert "ignored" not in caplog.text


def test_an_arm_whose_positions_are_not_wired_is_refused_unless_the_check_is_switched_off() -> None:
    with pytest.raises(WiringError, match="no input joints, and left_arm is an arm"):
        arm_bench(joints=False)
    unchecked = arm_bench(joints=False, arm_check=False)
    assert [caution.title for caution in unchecked.slot.module.cautions()] == ["No check of an arm"]


@in_virtual_time
async def test_what_is_unattended_moves_without_a_strategy_and_exploits_none() -> None:
    calm = {"input": "calm", "behavior": "CalmFace", "priority": 0, "unattended": True}
    async with bench(behaviors=[*BEHAVIORS, calm]) as b:
        moving = {port.name for port in b.slot.context.inputs.values() if port.moves}
        assert moving == {"look", "nod"}
        reported = b.listen("exploitation")
        b.feed("calm", command(b, 0.1))
        await b.settle()
        assert [c.positions for c in b.link.joint_commands] == [(0.1,)]
        assert {report.behavior for report in drain(reported)} <= {None}
        b.feed("look", command(b, 0.5))
        await b.settle()
        assert b.link.joint_commands[-1].positions == (0.5,)
        latest = drain(reported)[-1]
        assert (latest.behavior, latest.outdone) == ("LookAt", ())
