"""Where a base will be: its velocity follows commands within its accelerations. A pure function.

``web/src/drive/prediction.ts`` is the same for the page; both are compared with one file of examples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from app.base.geometry import Pose2

#: Velocities are integrated in steps of at most this (s).
STEP_S = 0.02
#: Nothing is predicted further ahead (s): the operator will have changed the command.
FARTHEST_S = 1.5


@dataclass(frozen=True, slots=True)
class Velocity:
    """Forward and sideways (m/s, left positive) and turning (rad/s), in ``base_link``."""

    linear: float = 0.0
    angular: float = 0.0
    lateral: float = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """The pose ``X_OB`` at ``stamp`` (s), and the velocity there."""

    stamp: float
    X_OB: Pose2
    velocity: Velocity = Velocity()


@dataclass(frozen=True, slots=True)
class Commanded:
    """From ``stamp`` (s, robot's clock) on, the base is commanded ``velocity``."""

    stamp: float
    velocity: Velocity


def predicted(
    motion: Motion, commands: Sequence[Commanded], until: float, *, linear_mps2: float, angular_radps2: float
) -> Motion:
    """The motion at ``until`` (s; at most :data:`FARTHEST_S` ahead, never before ``motion``).

    ``commands`` are in the order of their stamps; before the first, the base keeps its velocity. Its velocity changes
    by ``linear_mps2`` and ``angular_radps2`` at most.
    """
    until = min(max(until, motion.stamp), motion.stamp + FARTHEST_S)
    edges = [command.stamp for command in commands if motion.stamp < command.stamp < until]
    stamp, X_OB, velocity = motion.stamp, motion.X_OB, motion.velocity
    for end in (*edges, until):
        wanted = next((each.velocity for each in reversed(commands) if each.stamp <= stamp), velocity)
        steps = max(1, math.ceil((end - stamp) / STEP_S))
        dt = (end - stamp) / steps
        for _ in range(steps):
            after = Velocity(
                _towards(velocity.linear, wanted.linear, linear_mps2 * dt),
                _towards(velocity.angular, wanted.angular, angular_radps2 * dt),
                _towards(velocity.lateral, wanted.lateral, linear_mps2 * dt),
            )
            X_OB = _moved(X_OB, velocity, after, dt)
            velocity = after
        stamp = end
    return Motion(stamp, X_OB, velocity)


def _towards(value: float, wanted: float, most: float) -> float:
    return value + min(max(wanted - value, -most), most)


def _moved(X_OB: Pose2, old: Velocity, new: Velocity, dt: float) -> Pose2:
    """One step with the mean of two velocities, along its middle heading."""
    turn = 0.5 * (old.angular + new.angular) * dt
    forward, left = 0.5 * (old.linear + new.linear) * dt, 0.5 * (old.lateral + new.lateral) * dt
    heading = X_OB.theta + 0.5 * turn
    cos, sin = math.cos(heading), math.sin(heading)
    return Pose2(X_OB.x + cos * forward - sin * left, X_OB.y + sin * forward + cos * left, X_OB.theta + turn)
