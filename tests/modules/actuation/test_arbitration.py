from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from app.link import BaseLimits
from app.messages import JointCommand, Twist
from app.modules.actuation.arbitration import (
    Contender,
    approach,
    arbitrate,
    clamped,
    joints_are_finite,
    twist_is_finite,
)

LIMITS = BaseLimits(0.40, 1.00, 0.40, 4.00)
TELEOP = Contender(input="teleop", behavior="Teleop", priority=2)
FOLLOW = Contender(input="follow", behavior="PlanAndFollowPath", priority=1)

SPEED = st.floats(-5, 5)
TWISTS = st.builds(Twist, st.floats(0, 10), SPEED, SPEED, SPEED)
HOLONOMIC = BaseLimits(0.40, 1.00, 0.40, 4.00, lateral_mps=0.25)


def test_the_highest_priority_with_a_fresh_command_drives() -> None:
    teleop, follow = Twist(9.9, 0.1, 0.0), Twist(9.95, 0.3, 0.5)
    commands = {"teleop": teleop, "follow": follow}
    for order in ((TELEOP, FOLLOW), (FOLLOW, TELEOP)):
        assert arbitrate(10.0, commands, order, 0.25, twist_is_finite) == ("Teleop", teleop)
        assert arbitrate(10.17, commands, order, 0.25, twist_is_finite) == ("PlanAndFollowPath", follow)
        assert arbitrate(10.3, commands, order, 0.25, twist_is_finite) is None


def test_equal_priorities_go_to_the_first_listed() -> None:
    rivals = (Contender(input="a", behavior="A", priority=1), Contender(input="b", behavior="B", priority=1))
    commands = {"a": Twist(1.0, 0.1, 0), "b": Twist(1.0, 0.2, 0)}
    assert arbitrate(1.0, commands, rivals, 0.25, twist_is_finite) == ("A", commands["a"])


def test_what_is_not_finite_or_from_the_future_never_drives() -> None:
    commands = {"teleop": Twist(10.0, math.nan, 0.0), "follow": Twist(10.0, 0.1, 0.0)}
    assert arbitrate(10.0, commands, (TELEOP, FOLLOW), 0.25, twist_is_finite) == (
        "PlanAndFollowPath",
        commands["follow"],
    )
    for stamp in (1e9, math.nan, math.inf):
        assert arbitrate(10.0, {"teleop": Twist(stamp, 0.1, 0.0)}, (TELEOP,), 0.25, twist_is_finite) is None


def test_joints_are_arbitrated_by_the_same_rule() -> None:
    look = JointCommand(9.9, "head", ("pan",), (0.5,))
    nod = JointCommand(10.0, "head", ("tilt",), (math.nan,))
    rivals = (
        Contender(input="look", behavior="LookAt", priority=1),
        Contender(input="nod", behavior="Nod", priority=2),
    )
    assert arbitrate(10.0, {"look": look, "nod": nod}, rivals, 0.25, joints_are_finite) == ("LookAt", look)
    assert arbitrate(10.2, {"look": look}, rivals, 0.25, joints_are_finite) is None
    for bad in (math.inf, math.nan):
        assert not joints_are_finite(JointCommand(10.0, "arm", ("elbow",), (0.0,), stiffness=(bad,)))
        assert not joints_are_finite(JointCommand(10.0, "arm", ("elbow",), (0.0,), damping=(bad,)))


@given(TWISTS)
def test_clamped_keeps_the_sign_and_the_limits(twist: Twist) -> None:
    result = clamped(twist, LIMITS)
    assert abs(result.linear_mps) <= LIMITS.linear_mps
    assert abs(result.angular_radps) <= LIMITS.angular_radps
    assert result.linear_mps * twist.linear_mps >= 0
    assert result.angular_radps * twist.angular_radps >= 0
    assert clamped(result, LIMITS) == result


@given(TWISTS, TWISTS)
def test_approach_obeys_the_accelerations_and_never_overshoots(before: Twist, target: Twist) -> None:
    result = approach(before, target, LIMITS, 0.1)
    if target.linear_mps == target.angular_radps == target.lateral_mps == 0:
        assert result == target
        return
    elapsed = min(max(target.stamp - before.stamp, 0.0), 0.1)
    assert abs(result.linear_mps - before.linear_mps) <= LIMITS.linear_mps2 * elapsed + 1e-12
    assert abs(result.angular_radps - before.angular_radps) <= LIMITS.angular_radps2 * elapsed + 1e-12
    for axis in ("linear_mps", "angular_radps"):
        low, high = sorted((getattr(before, axis), getattr(target, axis)))
        assert low - 1e-12 <= getattr(result, axis) <= high + 1e-12


def test_full_speed_is_reached_in_one_second_and_left_at_once() -> None:
    sent = Twist(0.0, 0.0, 0.0)
    speeds = []
    for step in range(1, 13):
        sent = approach(sent, Twist(step * 0.1, 0.4, 0.0), LIMITS, 0.1)
        speeds.append(round(sent.linear_mps, 6))
    assert speeds == [0.04, 0.08, 0.12, 0.16, 0.2, 0.24, 0.28, 0.32, 0.36, 0.4, 0.4, 0.4]
    assert approach(sent, Twist(1.3, 0.0, 0.0), LIMITS, 0.1).linear_mps == 0.0


@given(TWISTS, TWISTS)
def test_forward_and_sideways_are_limited_as_one_vector(before: Twist, target: Twist) -> None:
    target = clamped(target, HOLONOMIC)
    assert math.hypot(target.linear_mps / 0.40, target.lateral_mps / 0.25) <= 1 + 1e-9
    if target.linear_mps == target.lateral_mps == target.angular_radps == 0.0:
        return
    reached = approach(before, target, HOLONOMIC, longest_s=0.1)
    changed = math.hypot(reached.linear_mps - before.linear_mps, reached.lateral_mps - before.lateral_mps)
    assert changed <= 0.04 + 1e-9


def test_a_sideways_command_is_no_stop_and_a_stop_is_passed_on_at_once() -> None:
    moving = Twist(1.0, 0.0, 0.0, 0.25)
    assert approach(moving, Twist(1.1, 0.0, 0.0), HOLONOMIC, 0.1) == Twist(1.1, 0.0, 0.0)
    assert approach(Twist(1.0, 0.0, 0.0), Twist(1.1, 0.0, 0.0, 0.25), HOLONOMIC, 0.1).lateral_mps > 0
    assert clamped(moving, LIMITS).lateral_mps == 0.0
    assert not twist_is_finite(Twist(1.0, 0.0, 0.0, math.inf))
