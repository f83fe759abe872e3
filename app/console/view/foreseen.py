"""Where the robot will be when a command that a viewer gives now arrives: pure.

A viewer sees the robot late, and their command takes its time, too: both together are the round trip that was measured
of that viewer. What has been commanded by now goes on until then.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.base.motion_prediction import Commanded, Motion, Velocity, predicted
from app.console.view.floor import ribbon
from app.link import BaseLimits
from app.messages import Odometry, TeleopCommand

#: What is nearer than both to the measured body is drawn as that alone (m, rad).
NEAR_M, NEAR_RAD = 0.05, math.radians(3.0)
#: Unlike the outlines of the next two seconds, which lie on the floor: blue pickets that stand on it.
COLOR = (40, 130, 255)
DASH_M, GAP_M, HEIGHT_M = 0.07, 0.06, 0.3
_STEP_M = 0.01
#: Vertices (V, 3) and faces (F, 3).
Mesh: TypeAlias = tuple[NDArray[np.float32], NDArray[np.uint32]]
#: A driver's command counts for so long (s), as for Teleop; then what the base was given goes on.
FRESH_S = 0.25


@dataclass(frozen=True, slots=True)
class Motions:
    """How the base moves and is commanded to: ``motion`` measured last, and ``commanded`` from ``now`` (s) on."""

    motion: Motion
    commanded: Velocity
    now: float


def motions(
    odometry: Odometry, applied: Velocity, driver: TeleopCommand | None, limits: BaseLimits, *, now: float
) -> Motions:
    """What is known at ``now`` (s): a fresh command of the ``driver`` counts, else the velocity that is ``applied``."""
    velocity = Velocity(odometry.linear_mps, odometry.angular_radps, odometry.lateral_mps)
    commanded = applied
    if driver is not None and 0.0 <= now - driver.stamp <= FRESH_S:
        commanded = Velocity()
        if driver.held:
            linear, lateral = limits.within_speeds(
                driver.linear * limits.linear_mps, driver.lateral * limits.lateral_mps
            )
            commanded = Velocity(linear, driver.angular * limits.angular_radps, lateral)
    return Motions(Motion(odometry.stamp, odometry.X_OB, velocity), commanded, now)


def foreseen(known: Motions, round_trip_s: float, limits: BaseLimits) -> Pose2 | None:
    """``X_OP`` in ``odom`` after ``round_trip_s``; None where that is not far from the measured pose."""
    motion = known.motion
    after = predicted(
        motion,
        [Commanded(known.now, known.commanded)],
        known.now + round_trip_s,
        linear_mps2=limits.linear_mps2,
        angular_radps2=limits.angular_radps2,
    ).X_OB
    away = math.hypot(after.x - motion.X_OB.x, after.y - motion.X_OB.y)
    turned = abs(wrap_angle(after.theta - motion.X_OB.theta))
    return after if away > NEAR_M or turned > NEAR_RAD else None


def pickets(footprint: NDArray[np.float64]) -> Mesh:
    """The outline of ``footprint`` (N, 2) as pickets, with a line from its middle to its front, at their height:
    vertices (V, 3), m in ``base_link``, and faces (F, 3)."""
    closed = np.concatenate([footprint, footprint[:1]])
    lengths = np.hypot(*np.diff(closed, axis=0).T)
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    count = max(3, round(float(at[-1]) / (DASH_M + GAP_M)))
    period = float(at[-1]) / count
    dash = period * DASH_M / (DASH_M + GAP_M)
    lines = [_along(closed, at, number * period, number * period + dash) for number in range(count)]
    front = float(footprint[:, 0].max())
    return _joined(
        [
            *map(_picket, lines),
            _raised(ribbon(np.array([(0.3 * front, 0.0), (front, 0.0)]))),
            *(_raised(ribbon(line)) for line in lines),
        ]
    )


def _along(closed: NDArray[np.float64], at: NDArray[np.float64], begin: float, end: float) -> NDArray[np.float64]:
    steps = np.linspace(begin, end, max(2, math.ceil((end - begin) / _STEP_M)))
    return np.stack([np.interp(steps, at, closed[:, axis]) for axis in (0, 1)], axis=-1)


def _picket(line: NDArray[np.float64]) -> Mesh:
    """A strip over ``line`` (N, 2), from the floor up."""
    count = len(line)
    foot = np.column_stack([line, np.zeros(count)])
    head = np.column_stack([line, np.full(count, HEIGHT_M)])
    first = np.arange(count - 1)
    one = np.stack([first, first + 1, first + count], axis=1)
    other = np.stack([first + 1, first + 1 + count, first + count], axis=1)
    return np.concatenate([foot, head]).astype(np.float32), np.concatenate([one, other]).astype(np.uint32)


def _raised(mesh: Mesh) -> Mesh:
    vertices, faces = mesh
    return vertices + np.array((0.0, 0.0, HEIGHT_M), np.float32), faces


def _joined(meshes: Sequence[Mesh]) -> Mesh:
    vertices, faces, count = [], [], 0
    for points, triangles in meshes:
        vertices.append(points)
        faces.append(triangles + np.uint32(count))
        count += len(points)
    return np.concatenate(vertices), np.concatenate(faces)
