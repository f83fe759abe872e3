"""What the check in front of an arm refuses, and what it gives instead."""

from __future__ import annotations

import pytest

from app.messages import JointCommand
from app.modules.actuation.arm_check import ArmCheck
from tests.modules.actuation.arms import (
    COLLISION,
    INTO_THE_TORSO,
    JOINTS,
    LEFT,
    LEFT_CROSSING,
    LEFT_NAMES,
    REST,
    RIGHT_CROSSING,
    joint_state,
)

PERIOD_S = 1 / 30


def check() -> ArmCheck:
    return ArmCheck(LEFT, COLLISION, JOINTS)


def command(stamp: float, positions: tuple[float, ...], names: tuple[str, ...] = LEFT_NAMES) -> JointCommand:
    return JointCommand(stamp, "left_arm", names, positions, (20.0,) * len(names), (3.0,) * len(names))


def test_a_free_command_is_given_as_it_is() -> None:
    checked = check()
    checked.take(joint_state(1.0, REST))
    asked = command(1.0, LEFT_CROSSING)
    assert checked.judge(asked) == (asked, "")


def test_a_set_point_beyond_the_joints_limits_is_refused_with_them() -> None:
    checked = check()
    checked.take(joint_state(1.0, REST))
    given, reason = checked.judge(command(1.0, (0.0, 0.1, 0.0, -2.5)))
    assert reason == "-2.5 of left_elbow_joint is not within -2.2 to 0.05"
    assert given is not None
    assert (given.positions, given.stiffness) == (REST, ()), "held where it is, by the group's own stiffness"


def test_commands_that_are_not_of_the_arm_are_refused() -> None:
    checked = check()
    checked.take(joint_state(1.0, REST))
    assert checked.judge(command(1.0, (0.0,), ("tail",)))[1].startswith("left_arm has no joint 'tail'; it has left_")
    assert checked.judge(command(1.0, (0.0,)))[1] == "the command has 1 positions for 4 joints"


def test_without_fresh_positions_nothing_is_given() -> None:
    checked = check()
    assert checked.judge(command(1.0, LEFT_CROSSING)) == (None, "the positions of left_arm are not known")
    checked.take(joint_state(1.0, REST))
    assert checked.judge(command(1.4, LEFT_CROSSING)) == (None, "the positions of left_arm are not known")


def test_a_way_into_the_body_is_refused_and_the_arm_is_held_until_a_free_command() -> None:
    checked = check()
    checked.take(joint_state(1.0, REST))
    given, reason = checked.judge(command(1.0, INTO_THE_TORSO))
    assert reason == "left_forearm_link would touch torso_link"
    assert given is not None
    assert given.positions == REST
    checked.take(joint_state(1.1, (0.0, 0.15, 0.0, -0.2)))  # a person pushes it: the set-point stays
    held, _ = checked.judge(command(1.1, INTO_THE_TORSO))
    assert held is not None
    assert held.positions == REST
    free = command(1.2, LEFT_CROSSING)
    assert checked.judge(free) == (free, "")


def test_joints_that_a_command_does_not_name_count_with_their_goals() -> None:
    checked = check()
    checked.take(joint_state(1.0, REST))
    pitch = (LEFT_NAMES[0], LEFT_NAMES[2], LEFT_NAMES[3])
    assert checked.judge(command(1.0, (-0.4, 0.0, 0.0), pitch))[1] == ""
    assert checked.judge(command(1.0, (-0.15,), (LEFT_NAMES[1],)))[1] == "left_forearm_link would touch torso_link"
    checked.release()


def test_an_arm_in_motion_is_stopped_before_the_other_that_comes_in_its_way() -> None:
    checked = check()
    begin = -0.2
    for n in range(3):  # it moves up at 1.2 rad/s, elbow and twist are there already
        checked.take(joint_state(1.0 + n * PERIOD_S, (begin - 1.2 * n * PERIOD_S, 0.0, -0.8, -1.27)))
    assert checked.moving
    now = 1.0 + 2 * PERIOD_S
    asked = command(now, LEFT_CROSSING)
    assert checked.judge(asked)[1] == "", "the other arm hangs"
    here = (begin - 0.08 - 1.2 * PERIOD_S, 0.0, -0.8, -1.27)
    checked.take(joint_state(now + PERIOD_S, here, RIGHT_CROSSING))
    given, reason = checked.judge(command(now + PERIOD_S, LEFT_CROSSING))
    assert "would touch right_" in reason
    assert given is not None
    # It brakes: 1.2 rad/s at 4 rad/s^2 are 0.18 rad, and 0.07 until it begins to; the set-point is 0.18 rad ahead.
    assert given.positions[0] == pytest.approx(here[0] - 0.43, abs=0.02)


def test_a_way_is_free_again_when_the_other_arm_has_left_it() -> None:
    checked = check()
    checked.take(joint_state(1.0, REST, RIGHT_CROSSING))
    assert "right_" in checked.judge(command(1.0, LEFT_CROSSING))[1]
    checked.take(joint_state(2.0, REST))
    assert checked.judge(command(2.0, LEFT_CROSSING))[1] == ""
