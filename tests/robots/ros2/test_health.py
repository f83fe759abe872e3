"""What forbids driving a robot over ROS 2, and what the guard makes of it."""

from __future__ import annotations

import math

import pytest

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.messages import Odometry
from app.robots import guard
from app.robots.guard import BaseVelocity, GuardLimits, GuardMode, GuardState, VelocityCommand
from app.robots.guarded_base import decide
from app.robots.ros2.health import Seen, began_again, fault, faults, unheard

BASE = BaseLimits(0.3, 1.9, 0.45, 4.0)
LIMITS = GuardLimits(BASE)
GOOD = Seen("odometry", "/odom", last=10.0, others=1)
HEARD = Seen("base", "/cmd_vel", others=1)
DRIVING = guard.accept(GuardState(), VelocityCommand(10.0, BaseVelocity(0.2)))


@pytest.mark.parametrize(
    ("seen", "said"),
    [
        (Seen("odometry", "/odom"), "odometry has given nothing yet: /odom has no publisher"),
        (Seen("odometry", "/odom", others=1), "odometry has given nothing yet: /odom has a publisher, which is silent"),
        (
            Seen("odometry", "/odom", last=9.0, others=1),
            "odometry has given nothing for 1.1 s: /odom has a publisher, which is silent",
        ),
        (Seen("odometry", "/odom", last=9.0), "odometry has given nothing for 1.1 s: /odom has no publisher"),
        (Seen("odometry", "/odom", last=9.0, others=None), "odometry has given nothing for 1.1 s on /odom"),
        (Seen("odometry", "/odom", last=10.0, problem="its time is wrong"), "odometry (/odom): its time is wrong"),
        (GOOD, ""),
    ],
)
def test_a_fault_of_a_sensor_in_words(seen: Seen, said: str) -> None:
    assert fault(seen, 10.1, 0.5) == said


def test_commands_that_nobody_hears_are_a_fault() -> None:
    assert unheard(HEARD) == ""
    assert unheard(Seen("base", "/cmd_vel")) == "nothing listens to /cmd_vel: commands do not reach the robot"
    assert unheard(Seen("base", "/cmd_vel", problem="of another type")) == "base (/cmd_vel): of another type"
    assert faults([GOOD], HEARD, 10.1, 0.5) == ()
    assert len(faults([Seen("odometry", "/odom")], Seen("base", "/cmd_vel"), 10.1, 0.5)) == 2


def test_a_fault_stops_at_once_and_says_why() -> None:
    action = decide(10.1, DRIVING, ("odometry is gone",), LIMITS)
    assert (action.mode, action.reason, action.target, action.immediate) == (
        GuardMode.SENSOR_FAILURE, "odometry is gone", guard.ZERO, True,
    )  # fmt: skip
    stopped = guard.step(guard.GuardState(applied=BaseVelocity(0.3)), action, LIMITS, 0.02)
    assert stopped.applied == guard.ZERO


def test_without_a_fault_the_guard_decides() -> None:
    assert decide(10.1, DRIVING, (), LIMITS).mode is GuardMode.DRIVING
    assert decide(10.3, DRIVING, (), LIMITS).mode is GuardMode.STALE_COMMAND
    stopped = guard.e_stop(DRIVING, "a button")
    assert decide(10.1, stopped, ("odometry is gone",), LIMITS).mode is GuardMode.E_STOPPED


def at(stamp: float, x: float) -> Odometry:
    return Odometry(stamp, Pose2(x, 0.0, 0.0), 0.0, 0.0)


def test_odometry_that_jumps_began_again() -> None:
    assert not began_again(None, at(0.0, 100.0), BASE)
    assert not began_again(at(0.0, 1.0), at(0.05, 1.015), BASE)
    assert not began_again(at(0.0, 1.0), at(10.0, 4.0), BASE), "as far as it can have driven while nothing came"
    assert began_again(at(0.0, 1.0), at(0.05, 0.0), BASE)
    assert began_again(at(0.0, 1.0), at(0.05, math.nan), BASE)
