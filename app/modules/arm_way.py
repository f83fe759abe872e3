"""The way of an arm's joints to a posture, and whether it touches the rest of the body. Pure functions.

The guard moves each joint by itself, within its speed and acceleration: those with a short way arrive first. So the way
is a straight line in none but the simplest cases, and it is the true one that is judged.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from app.base.self_collision import Clearance, SelfCollision
from app.link import JointLimits

Array = NDArray[np.float64]

MARGIN_M = 0.005
"""Nearer than this to the rest of the body counts as touching it."""
PLANNING_MARGIN_M = 0.009
"""... for a behavior that looks for a way: noise of positions must not make the check in front of the arm refuse it."""
#: Greatest step (rad) of a joint between two postures of a way; by 0.05 rad a hand moves some 3 cm.
_STEP_RAD = 0.05
_MOST_STEPS = 80
STANDS_RADPS = 0.1
"""A joint that is slower (rad/s) is at rest: above the noise of its positions."""
#: The speeds of joints are known so well that this (rad) of a braking distance is.
_OVERSHOOT_RAD = 0.02
#: A posture that touches already may be left by ways that bring it no nearer than this (m).
_NEARER_M = 0.001


def way(joints: Sequence[JointLimits], begin: Array, goal: Array) -> Array:
    """Postures (N, J) rad on the way of ``joints`` from rest at ``begin`` (J,) to ``goal`` (J,), both among them."""
    distance = np.abs(goal - begin)
    speed, acceleration = np.array([j.velocity for j in joints]), np.array([j.acceleration for j in joints])
    speeding_s = np.minimum(speed / acceleration, np.sqrt(distance / acceleration))
    top = speeding_s * acceleration
    cruising_s = (distance - top * speeding_s) / np.where(top > 0, top, 1.0)
    lasts_s = float((2 * speeding_s + cruising_s).max())
    steps = min(max(math.ceil(float(distance.max()) / _STEP_RAD), 1), _MOST_STEPS)
    times = np.linspace(0.0, lasts_s, steps + 1)[:, None]
    sped, left = np.minimum(times, speeding_s), np.clip(2 * speeding_s + cruising_s - times, 0.0, speeding_s)
    gone = acceleration * sped**2 / 2 + top * np.clip(times - speeding_s, 0.0, cruising_s)
    gone += acceleration * (speeding_s**2 - left**2) / 2 * (times > speeding_s + cruising_s)
    return np.asarray(begin + np.sign(goal - begin) * np.minimum(gone, distance))


def stopping(
    joints: Sequence[JointLimits], positions: Array, velocities: Array, after_s: float, goals: Array | None = None
) -> Array:
    """Postures (3, J) rad until the joints stand, if they brake ``after_s`` seconds from now: now, when they begin to
    brake, at the end. Until they brake, those on their way to ``goals`` (J,) speed up; they stop there at the latest,
    where they still can."""
    acceleration, most = np.array([j.acceleration for j in joints]), np.array([j.velocity for j in joints])
    lower, upper = np.array([joint.lower for joint in joints]), np.array([joint.upper for joint in joints])
    speeds = velocities
    if goals is not None:
        left = goals - positions
        speeds = np.clip(velocities + np.sign(left) * acceleration * after_s, -most, most)
        towards, braking_rad = velocities * np.sign(left), velocities**2 / (2 * acceleration)
        stops = (towards > -STANDS_RADPS) & (braking_rad <= np.abs(left) + _OVERSHOOT_RAD)
        lower = np.where(stops, np.maximum(lower, np.minimum(goals, positions)), lower)
        upper = np.where(stops, np.minimum(upper, np.maximum(goals, positions)), upper)
    braking = positions + (velocities + speeds) / 2 * after_s
    stands = braking + speeds * np.abs(speeds) / (2 * acceleration)
    return np.asarray(np.clip(np.stack([positions, braking, stands]), lower, upper))


def touching(
    collision: SelfCollision, postures: Array, measured: Mapping[str, float], margin_m: float = MARGIN_M
) -> str:
    """What the joints would touch on their way through ``postures`` (N, J) rad, in words; "" where they touch nothing.

    ``measured``: positions by name of all joints of the body. Nearer than ``margin_m`` is touching. A way that begins
    where links touch already is free while it brings them no nearer.
    """
    clearances = collision.clearances(postures, measured)
    allowed = min(margin_m, clearances[0].distance_m - _NEARER_M)
    nearest: Clearance = min(clearances, key=lambda clearance: clearance.distance_m)
    if nearest.distance_m >= allowed:
        return ""
    first = next(clearance for clearance in clearances if clearance.distance_m < allowed)
    return f"{first.moving} would touch {first.other}"
