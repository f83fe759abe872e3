"""What the guard knows of a robot over ROS 2, and decides by: pure functions of what was seen and when. Times in s."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.messages import Odometry

#: Beyond what the base can have driven meanwhile, odometry that moved farther than this (m) began again.
JUMP_M = 0.5


@dataclass(frozen=True, slots=True)
class Seen:
    """What is known of a topic that driving requires.

    ``last``: arrival of its newest usable message, None before the first. ``problem``: why the newest message, or the
    topic itself, is not usable; "" if it is. ``others``: how many publishers it has (subscribers, of a topic for
    commands); None where that is unknown.
    """

    name: str
    topic: str
    last: float | None = None
    problem: str = ""
    others: int | None = 0


def fault(seen: Seen, now: float, timeout_s: float) -> str:
    """Why the robot must not drive by what was ``seen`` until ``now``; "" if it may."""
    if seen.problem:
        return f"{seen.name} ({seen.topic}): {seen.problem}"
    if seen.last is not None and now - seen.last <= timeout_s:
        return ""
    given = "nothing yet" if seen.last is None else f"nothing for {now - seen.last:.1f} s"
    if seen.others is None:
        return f"{seen.name} has given {given} on {seen.topic}"
    if seen.others == 0:
        return f"{seen.name} has given {given}: {seen.topic} has no publisher"
    return f"{seen.name} has given {given}: {seen.topic} has a publisher, which is silent"


def unheard(commands: Seen) -> str:
    """Why commands do not reach the robot; "" if they do, as far as can be known."""
    if commands.problem:
        return f"{commands.name} ({commands.topic}): {commands.problem}"
    return "" if commands.others else f"nothing listens to {commands.topic}: commands do not reach the robot"


def faults(required: Iterable[Seen], commands: Seen, now: float, timeout_s: float) -> tuple[str, ...]:
    """All that forbids driving, the gravest first."""
    found = [fault(seen, now, timeout_s) for seen in required] + [unheard(commands)]
    return tuple(reason for reason in found if reason)


def began_again(before: Odometry | None, now: Odometry, limits: BaseLimits) -> bool:
    """Whether odometry jumped farther than the base can have driven: its source was started again, or set back."""
    if before is None:
        return False
    seconds = max(now.stamp - before.stamp, 0.0)
    most = JUMP_M + 1.5 * max(limits.linear_mps, limits.lateral_mps) * seconds
    return not _distance(before.X_OB, now.X_OB) <= most


def _distance(a: Pose2, b: Pose2) -> float:
    return math.hypot(b.x - a.x, b.y - a.y)
