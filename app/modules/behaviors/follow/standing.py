"""Where to stand before a person or behind one, and how fast to come nearer. Pure functions; lengths in m.

Distances are from the middle of the robot to the middle of the person, over ground; all places are in one frame.
"""

from __future__ import annotations

import math
from typing import Final

from app.base.geometry import Pose2, wrap_angle

Point = tuple[float, float]

#: So far (rad) beside where a person faces is in front of them.
IN_FRONT_RAD: Final = 0.35
#: The way round a person leads over places so far (rad) apart, on a circle so much wider that the straight ways between
#: them keep the distance.
_STEP_RAD: Final = math.radians(60)
_WIDER: Final = 1.0 / math.cos(_STEP_RAD / 2)
#: It is so much (m) wider than the distance, too: where they are is known so well, and driven so.
_SPARE_M: Final = 0.1


def bearing(start: Point, end: Point) -> float:
    """Direction (rad) from ``start`` to ``end``; 0 where they are the same."""
    return math.atan2(end[1] - start[1], end[0] - start[0])


def behind(robot: Point, person: Point, distance_m: float) -> Pose2:
    """Where the robot keeps ``distance_m`` from a person on its own side of them, facing them.

    A robot that is nearer stays where it is: it does not back away.
    """
    left = math.dist(robot, person)
    heading = bearing(robot, person)
    way = max(0.0, left - distance_m)
    return Pose2(robot[0] + way * math.cos(heading), robot[1] + way * math.sin(heading), heading)


def in_front(robot: Point, person: Point, facing: float, distance_m: float) -> Pose2:
    """Where the robot goes next to stand ``distance_m`` in front of a person who faces ``facing`` (rad), facing them.

    The straight way there keeps that distance: one that would lead past the person leads first to a place beside them,
    the shorter way round. A robot that is in front of them and nearer stays where it is.
    """
    left = math.dist(robot, person)
    aside = wrap_angle(facing - bearing(person, robot))
    if abs(aside) <= IN_FRONT_RAD and left <= distance_m:
        return Pose2(robot[0], robot[1], bearing(robot, person))
    clear_m = distance_m + _SPARE_M
    tangent = math.acos(min(1.0, clear_m / left)) if left > 0.0 else 0.0
    if abs(aside) <= max(IN_FRONT_RAD, tangent):
        return _around(person, facing, distance_m)
    reach = tangent + _STEP_RAD / 2
    return _around(person, facing - aside + math.copysign(min(abs(aside), reach), aside), _WIDER * clear_m)


def _around(person: Point, direction: float, radius_m: float) -> Pose2:
    """The place in ``direction`` (rad) of the person, facing them."""
    x, y = person[0] + radius_m * math.cos(direction), person[1] + radius_m * math.sin(direction)
    return Pose2(x, y, wrap_angle(direction + math.pi))


def is_in_front(robot: Point, person: Point, facing: float) -> bool:
    """Whether the robot is before the face of a person who faces ``facing`` (rad)."""
    return abs(wrap_angle(facing - bearing(person, robot))) <= IN_FRONT_RAD


def nearing_mps(gap_m: float, braking_mps2: float, delay_s: float) -> float:
    """Greatest speed (m/s) towards a place ``gap_m`` ahead from which a base still stops there, that goes on for
    ``delay_s`` before it brakes."""
    if gap_m <= 0.0:
        return 0.0
    return braking_mps2 * (math.sqrt(delay_s**2 + 2.0 * gap_m / braking_mps2) - delay_s)


def share_of_speed(velocity: tuple[float, float], aside: float, nearest_mps: float) -> float:
    """Share, 0 to 1, of ``velocity`` (forward, left; m/s) that comes no faster than ``nearest_mps`` nearer to what is
    at the angle ``aside`` (rad, left positive) of the body's front."""
    nearing = velocity[0] * math.cos(aside) + velocity[1] * math.sin(aside)
    return 1.0 if nearing <= nearest_mps else nearest_mps / nearing
