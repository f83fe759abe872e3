"""The lines of a CARMEN log, each by itself: pure functions on text.

The format is described at the head of the logs and in CARMEN's manual, *Logger and Playback*:
``NAME contents ipc_timestamp ipc_hostname logger_timestamp``, one message per line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2

#: Kinds of lines that are read.
KINDS = frozenset({"PARAM", "ODOM", "FLASER", "RLASER", "ROBOTLASER1", "ROBOTLASER2", "RAWLASER1", "RAWLASER2"})
#: Begin of the sweep (deg) and step (deg) by the number of rays: the configurations of SICK's LMS behind the old
#: messages, which do not contain angles.
_LMS = {
    180: (-90.0, 1.0),
    181: (-90.0, 1.0),
    360: (-90.0, 0.5),
    361: (-90.0, 0.5),
    400: (-50.0, 0.25),
    401: (-50.0, 0.25),
    540: (-135.0, 0.5),
    541: (-135.0, 0.5),
    720: (-90.0, 0.25),
    721: (-90.0, 0.25),
}


#: No laser has readings by the million.
_MOST_DIGITS = 6


@dataclass(frozen=True, slots=True)
class CarmenTimes:
    """``captured``: ipc_timestamp (s), when the message was made; ``logged``: logger_timestamp (s), of its arrival."""

    captured: float
    logged: float


@dataclass(frozen=True, slots=True)
class Param:
    """A parameter of the robot that recorded the log."""

    name: str
    value: str


@dataclass(frozen=True, slots=True)
class CarmenOdometry:
    """Odometry: ``pose`` and ``twist`` (m/s, rad/s) of the base."""

    times: CarmenTimes
    pose: Pose2
    twist: tuple[float, float]
    kind: str = "ODOM"


@dataclass(frozen=True, slots=True, eq=False)
class CarmenScan:
    """One sweep: ``ranges`` (N,) float32 m as the line has them, but 0 for values that are no distance; ``blank``
    counts those.

    ``maximum`` (m) as the line has it, None without. ``intensities`` (N,) or None. ``robot`` and ``laser`` are the
    poses of base and laser in ``odom``, None if the line has none; ``twist`` (m/s, rad/s) likewise.
    """

    times: CarmenTimes
    kind: str
    ranges: NDArray[np.float32]
    blank: int
    angle_min: float
    angle_increment: float
    intensities: NDArray[np.float32] | None = None
    maximum: float | None = None
    robot: Pose2 | None = None
    laser: Pose2 | None = None
    twist: tuple[float, float] | None = None


def parse(line: str) -> Param | CarmenOdometry | CarmenScan | None:
    """The content of ``line``; None for a kind that is not read. Raises ValueError naming the mistake."""
    words = line.split()
    if not words or words[0] not in KINDS:
        return None
    kind = words[0]
    if kind == "PARAM":
        if len(words) < 3:
            raise ValueError("a parameter without a value")
        return Param(words[1], words[2])
    if len(words) < 5:
        raise ValueError("the line is cut off")
    times = CarmenTimes(_number(words[-3]), _number(words[-1]))
    body = words[1:-3]
    if kind == "ODOM":
        if len(body) != 6:
            raise ValueError(f"{len(body)} numbers instead of x y theta tv rv accel")
        x, y, theta, tv, rv, _ = _numbers(body)
        return CarmenOdometry(times, Pose2(x, y, theta), (tv, rv))
    if kind in ("FLASER", "RLASER"):
        return _old(kind, times, body)
    return _new(kind, times, body)


def _old(kind: str, times: CarmenTimes, body: Sequence[str]) -> CarmenScan:
    count = _count(body, 0)
    if len(body) != 1 + count + 6:
        raise ValueError(f"{len(body) - 1} numbers follow instead of {count} ranges and 6 of poses")
    ranges, blank = _distances(body[1 : 1 + count])
    angle_min, increment = lms_angles(count)
    laser, robot = _poses(body[1 + count :])
    return CarmenScan(
        times, kind, ranges, blank, angle_min=angle_min, angle_increment=increment, robot=robot, laser=laser
    )


def _new(kind: str, times: CarmenTimes, body: Sequence[str]) -> CarmenScan:
    """``laser_type start_angle field_of_view resolution maximum accuracy remission_mode n [ranges] m [remissions]``.

    ROBOTLASER goes on with the poses of laser and robot, tv, rv and three distances.
    """
    if len(body) < 9:
        raise ValueError("the line is cut off")
    _, start, field, resolution, maximum, _, _ = _numbers(body[:7])
    count = _count(body, 7)
    after = 8 + count
    remissions = _count(body, after)
    rest = body[after + 1 + remissions :]
    wanted = 11 if kind.startswith("ROBOT") else 0
    if len(rest) != wanted or remissions not in (0, count):
        raise ValueError(f"{count} ranges, {remissions} remissions and {len(rest)} more numbers instead of {wanted}")
    if resolution <= 0:
        resolution = field / max(count - 1, 1)
    robot = laser = twist = None
    if wanted:
        laser, robot = _poses(rest[:6])
        tv, rv = _numbers(rest[6:8])
        twist = (tv, rv)
    ranges, blank = _distances(body[8:after])
    scan = CarmenScan(times, kind, ranges, blank, angle_min=start, angle_increment=resolution)
    intensities = _array(body[after + 1 : after + 1 + remissions]) if remissions else None
    maximum_m = maximum if maximum > 0 else None
    return replace(scan, intensities=intensities, maximum=maximum_m, robot=robot, laser=laser, twist=twist)


def _poses(words: Sequence[str]) -> tuple[Pose2, Pose2]:
    x, y, theta, robot_x, robot_y, robot_theta = _numbers(words)
    return Pose2(x, y, theta), Pose2(robot_x, robot_y, robot_theta)


def lms_angles(count: int) -> tuple[float, float]:
    """First angle and step (rad) of a sweep of ``count`` rays from right to left."""
    if known := _LMS.get(count):
        return math.radians(known[0]), math.radians(known[1])
    return -0.5 * math.pi, math.pi / max(count - 1, 1)


def _count(words: Sequence[str], at: int) -> int:
    if at >= len(words):
        raise ValueError("the line is cut off")
    if not words[at].isdecimal() or len(words[at]) > _MOST_DIGITS:
        raise ValueError(f"{words[at][:40]!r} is no number of readings")
    return int(words[at])


def _number(word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        raise ValueError(f"{word!r} found where a number should be") from None
    if not math.isfinite(value):
        raise ValueError(f"{word!r} is no finite number")
    return value


def _numbers(words: Sequence[str]) -> list[float]:
    return [_number(word) for word in words]


def _distances(words: Sequence[str]) -> tuple[NDArray[np.float32], int]:
    """Readings (m), 0 where one is no number or below 0: nothing is known there; and how many of these there are."""
    values = _array(words)
    blank = ~(values >= 0.0)  # NaN too
    count = int(np.count_nonzero(blank))
    return (np.where(blank, np.float32(0.0), values) if count else values), count


def _array(words: Sequence[str]) -> NDArray[np.float32]:
    try:
        return np.array(words, dtype=np.float32)
    except ValueError:
        for word in words:
            _number(word)  # names the word that is no number
        raise
