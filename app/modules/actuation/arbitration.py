"""Priority arbitration of an actuator group (thesis 4.2), and limits of the base: pure functions on commands and times.

Of the behaviors whose command is fresh, the one of highest priority wins, all others are ignored (subsumption, not
blending). A twist is clamped to the body's speeds and approached no faster than the body's accelerations; joints are
limited by the guard.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from pydantic import BaseModel, Field

from app.link import BaseLimits
from app.messages import JointCommand, Twist

#: A command to an actuator group.
C = TypeVar("C", Twist, JointCommand)


class Contender(BaseModel, frozen=True, extra="forbid"):
    """One behavior that may command an actuator group, and its priority."""

    input: str = Field(min_length=1, description="name of the input port its commands come in by")
    behavior: str = Field(min_length=1, description="name of the behavior, as exploitation reports it")
    priority: int = Field(description="the highest priority among those with a fresh command wins")
    unattended: bool = Field(
        False, description="its commands need no strategy and exploit none: for what always moves, as a calm face"
    )


def arbitrate(
    now: float,
    commands: Mapping[str, C],
    contenders: Sequence[Contender],
    max_age_s: float,
    usable: Callable[[C], bool],
) -> tuple[str, C] | None:
    """The contender that wins and its command; None if no command is fresh.

    ``commands``: the newest command by port. A command is fresh while its stamp is within ``max_age_s`` of ``now``; one
    that is not ``usable`` counts as none. Among equal priorities the contender listed first wins.
    """
    winner: Contender | None = None
    for contender in fresh(now, commands, contenders, max_age_s, usable):
        if winner is None or contender.priority > winner.priority:
            winner = contender
    return None if winner is None else (winner.behavior, commands[winner.input])


def fresh(
    now: float,
    commands: Mapping[str, C],
    contenders: Sequence[Contender],
    max_age_s: float,
    usable: Callable[[C], bool],
) -> list[Contender]:
    """The contenders whose command is fresh and usable, as :func:`arbitrate` takes them."""
    found = []
    for contender in contenders:
        command = commands.get(contender.input)
        # The comparison is written so that a NaN stamp is not fresh.
        if command is not None and abs(now - command.stamp) <= max_age_s and usable(command):
            found.append(contender)
    return found


def twist_is_finite(twist: Twist) -> bool:
    """Whether all speeds are finite."""
    return all(math.isfinite(speed) for speed in (twist.linear_mps, twist.angular_radps, twist.lateral_mps))


def joints_are_finite(command: JointCommand) -> bool:
    """Whether all positions, stiffness and damping are finite."""
    return all(math.isfinite(value) for value in (*command.positions, *command.stiffness, *command.damping))


def clamped(twist: Twist, limits: BaseLimits) -> Twist:
    """``twist`` within the body's speeds: forward and sideways as one vector, and the turn by itself."""
    linear, lateral = limits.within_speeds(twist.linear_mps, twist.lateral_mps)
    return Twist(twist.stamp, linear, _within(twist.angular_radps, limits.angular_radps), lateral)


def approach(before: Twist, target: Twist, limits: BaseLimits, longest_s: float) -> Twist:
    """The twist between ``before`` and ``target`` that the body's accelerations allow at the target's stamp.

    The time since ``before`` counts up to ``longest_s``, so that a long pause does not permit a jump. A stop (all zero)
    is passed on at once: the guard shapes braking, and nothing here delays it.
    """
    if target.linear_mps == 0.0 and target.angular_radps == 0.0 and target.lateral_mps == 0.0:
        return target
    elapsed_s = min(max(target.stamp - before.stamp, 0.0), longest_s)
    linear, lateral = limits.ramped(
        (before.linear_mps, before.lateral_mps), (target.linear_mps, target.lateral_mps), elapsed_s
    )
    angular = _within(target.angular_radps - before.angular_radps, limits.angular_radps2 * elapsed_s)
    return Twist(target.stamp, linear, before.angular_radps + angular, lateral)


def _within(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
