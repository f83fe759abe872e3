"""Every message that crosses a channel: frozen, slotted dataclasses, passed by reference, never copied.

Conventions (ARCHITECTURE.md, *Words*): SI units, radians, seconds; right-handed frames, x forward, y left, z up
(REP 103/105: ``odom -> base_link -> ...``); camera optical frames x right, y down, z forward. ``stamp`` is the
robot's clock at *capture*, seconds since the Unix epoch. Arrays are read-only: whoever makes a message passes its
arrays through :func:`read_only`. Poses are named by monogram: ``X_WB`` is the pose of B in W, ``p_WB`` its
translation; O is ``odom``, B ``base_link``, C a camera's optical frame, L the laser, Q a QR code.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from app.geometry import CameraModel, Pose2, Pose3

ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


class Message(Protocol):
    """What every message has: the time of its capture."""

    @property
    def stamp(self) -> float:
        """Seconds of the robot's clock (Unix epoch) at capture."""
        ...


def read_only(array: ArrayT) -> ArrayT:
    """Clear the write flag of ``array`` and return it, so that delivery by reference stays safe."""
    array.flags.writeable = False
    return array


# --- Sensors -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """One frame of a camera, with its registered depth where the camera has one.

    ``color`` (H, W, 3) uint8, RGB. ``depth`` (H, W) uint16, millimetres along the optical axis, 0 = no measurement;
    None for a camera without depth. ``frame`` names the camera. ``X_BC`` is the pose of the optical frame in
    ``base_link`` at ``stamp``, from the joints as measured then.
    """

    stamp: float
    frame: str
    color: NDArray[np.uint8]
    depth: NDArray[np.uint16] | None
    camera: CameraModel
    X_BC: Pose3


@dataclass(frozen=True, slots=True, eq=False)
class LaserScan:
    """One sweep of a planar laser.

    ``ranges`` (N,) float32 m, +inf = nothing within ``range_max``; ``intensities`` (N,) float32, arbitrary unit.
    Ray i points at ``angle_min + i * angle_increment`` (rad, about z of the laser's frame, x forward). ``stamp`` is
    the time of the first ray, the last comes ``duration_s`` later. ``X_BL``: pose of the laser in ``base_link``.
    """

    stamp: float
    frame: str
    ranges: NDArray[np.float32]
    intensities: NDArray[np.float32]
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    duration_s: float
    X_BL: Pose3


@dataclass(frozen=True, slots=True)
class Odometry:
    """Wheel odometry: ``X_OB``, the pose of ``base_link`` in ``odom`` (drifts), and the measured twist in B."""

    stamp: float
    X_OB: Pose2
    linear_mps: float
    angular_radps: float


@dataclass(frozen=True, slots=True)
class JointState:
    """Measured joint positions: ``positions[i]`` (rad, or m where prismatic) of joint ``names[i]``."""

    stamp: float
    names: tuple[str, ...]
    positions: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class GroundTruth:
    """True pose of ``base_link`` in the simulated ``world``: for tests and experiments only, never for a module."""

    stamp: float
    X_WB: Pose2
    linear_mps: float
    angular_radps: float


# --- Driving -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class OperatorDrive:
    """What an operator's hands say: ``linear`` and ``angular`` in [-1, 1] of the robot's limits (forward, left).

    ``held`` is the dead-man: False means stop, whatever the rest says. ``stamp`` is the robot's clock at arrival,
    ``sequence`` grows by one with each command of one operator session.
    """

    stamp: float
    operator: str
    sequence: int
    held: bool
    linear: float
    angular: float


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity command for the base: forward m/s and turn rad/s (left positive)."""

    stamp: float
    linear_mps: float
    angular_radps: float


@dataclass(frozen=True, slots=True)
class Exploitation:
    """Which behavior's command the arbiter let through: ``behavior`` is None when nobody drives."""

    stamp: float
    behavior: str | None
    twist: Twist


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """What the robot's link and its guard report, at 20 Hz.

    ``guard`` is one of ``idle`` (no command ever or a zero one), ``driving``, ``stale_command`` (no fresh command:
    zero), ``e_stopped`` (latched: zero), ``sensor_failure``. ``reason`` says it to people. ``command_age_s`` is the
    age of the newest command at the guard, None before the first. ``applied`` is the twist the wheels are given now.
    ``world_rate`` is simulated time over real time (1.0 on hardware).
    """

    stamp: float
    guard: str
    reason: str
    e_stopped: bool
    command_age_s: float | None
    applied: Twist
    world_rate: float


# --- Percepts ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class QRCode:
    """One decoded code: ``corners`` (4, 2) float32 px, from the code's upper left, clockwise as printed.

    ``p_BQ`` is its centre in ``base_link`` at the message's stamp, None where its depth could not be measured.
    """

    text: str
    corners: NDArray[np.float32]
    p_BQ: tuple[float, float, float] | None


@dataclass(frozen=True, slots=True, eq=False)
class QRCodes:
    """All codes of one image (possibly none), ``frame`` being the camera's name."""

    stamp: float
    frame: str
    codes: tuple[QRCode, ...]


@dataclass(frozen=True, slots=True)
class Landmark:
    """Repeated sightings of one code merged: ``p_OQ`` in ``odom`` (m) with standard deviation ``sigma_m``."""

    text: str
    p_OQ: tuple[float, float, float]
    sigma_m: float
    sightings: int
    first_seen: float
    last_seen: float


@dataclass(frozen=True, slots=True)
class Landmarks:
    """Every landmark known so far, in the order of first sight; published when one is added or moves."""

    stamp: float
    landmarks: tuple[Landmark, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud:
    """Coloured points of one depth image.

    ``points`` (N, 3) float32, m in ``base_link`` at ``stamp``; ``colors`` (N, 3) uint8, RGB.

    ``X_OB`` is the pose of that ``base_link`` in ``odom`` at the same ``stamp``: drawn with it, a cloud stays where
    it was seen however late it comes (thesis 3.4: the cloud was drawn with a newer head pose than its own).
    """

    stamp: float
    points: NDArray[np.float32]
    colors: NDArray[np.uint8]
    X_OB: Pose2


@dataclass(frozen=True, slots=True)
class EncodedImage:
    """A JPEG of a camera's image for people to look at, ``width`` x ``height`` px."""

    stamp: float
    frame: str
    jpeg: bytes
    width: int
    height: int


# --- What the program tells of itself ----------------------------------------------------------------------------
#
# Recorded and replayed as any other message; nothing acts on them. A closed filter's divisor is inf.


@dataclass(frozen=True, slots=True)
class DesireRecord:
    """One desire as it stood: ``params`` is JSON; ``expires`` (robot's clock, s) is +inf for one that never does."""

    id: str
    cls: str
    intensity: float
    utility: float
    security: bool
    params: str
    source_kind: str
    source_name: str
    created: float
    expires: float


@dataclass(frozen=True, slots=True)
class DesiresRecord:
    """Every desire in the Intention Workspace after a change of it."""

    stamp: float
    desires: tuple[DesireRecord, ...]


@dataclass(frozen=True, slots=True)
class ReasonRecord:
    """How a desired class fared: ``state``, the utility it has, the one ``wanted``, the ``best`` there is, in words."""

    cls: str
    state: str
    utility: float
    wanted: float
    best: float
    text: str


@dataclass(frozen=True, slots=True)
class IntentionRecord:
    """An intention put in force, and again once its reasons are complete.

    ``strategies`` selected; classes ``fulfilled`` and security desires ``relaxed``; Ω and its ``bound`` (+inf where
    none is known); ``resources[i]`` is used ``used[i]`` of ``capacities[i]``; ``parameters`` is P' as JSON, by module.
    """

    stamp: float
    strategies: tuple[str, ...]
    fulfilled: tuple[str, ...]
    relaxed: tuple[str, ...]
    omega: float
    bound: float
    proven: bool
    solve_time_s: float
    resources: tuple[str, ...]
    used: tuple[float, ...]
    capacities: tuple[float, ...]
    parameters: str
    reasons: tuple[ReasonRecord, ...]


@dataclass(frozen=True, slots=True)
class Divisors:
    """φ of every filter that attention controls, after a change: ``divisors[i]`` (inf: closed) of ``filters[i]``."""

    stamp: float
    filters: tuple[str, ...]
    divisors: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class LoadRecord:
    """CPU over the last window of ``window_s``: ``cpu[i]`` % of a core for ``modules[i]``, ``process`` in all."""

    stamp: float
    window_s: float
    modules: tuple[str, ...]
    cpu: tuple[float, ...]
    process: float


@dataclass(frozen=True, slots=True)
class ModuleRecord:
    """A module's state changed: ``status`` as ``app.runtime.supervisor`` names it, ``problem`` in words."""

    stamp: float
    module: str
    status: str
    restarts: int
    problem: str


@dataclass(frozen=True, slots=True)
class EventRecord:
    """One event of the timeline: ``data`` is JSON, ``text`` a sentence for people."""

    stamp: float
    kind: str
    subject: str
    text: str
    data: str


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line of the program's log: ``level`` as in ``logging`` (10 debug … 50 critical), ``source`` its logger."""

    stamp: float
    level: int
    source: str
    text: str


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """What the Recorder does, each second and at every change.

    ``state``: ``idle``; ``recording`` into one file; ``ring`` (the last minutes are kept); ``stopped`` by itself
    though still desired (``reason`` says why: disk full, disk too slow). ``name`` is the recording's, "" while idle.
    ``duration_s``, ``bytes`` and ``messages`` are those of the file, or of what the ring holds now.
    ``dropped`` messages could not be queued for the disk; ``queued_bytes`` wait for it now.
    """

    stamp: float
    state: str
    name: str
    began: float
    duration_s: float
    bytes: int
    messages: int
    dropped: int
    queued_bytes: int
    reason: str
