"""The robot interface: a body, simulated, replayed or real, as the rest of the program uses it.

A link gives sensor streams and is the only writer to the motors; the guard (command age, limits, latched e-stop) is
behind it, in another process. Implementations are in ``app/robots/``; modules know only this file.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol

from app.messages import Audio, JointCommand, Twist


class LinkFailed(Exception):
    """The body's process or driver is gone or cannot start; the message contains a remedy."""


@dataclass(frozen=True, slots=True)
class BaseLimits:
    """Limits of the mobile base: speeds (m/s, rad/s) and accelerations (m/s^2, rad/s^2), all positive.

    ``lateral_mps`` is the greatest speed sideways, 0 for a base that cannot move so (a differential drive). Forward and
    sideways speeds are limited together, as a vector within the ellipse of both limits; its change is within
    ``linear_mps2``.
    """

    linear_mps: float
    angular_radps: float
    linear_mps2: float
    angular_radps2: float
    lateral_mps: float = 0.0

    @property
    def holonomic(self) -> bool:
        """Whether the base can move sideways."""
        return self.lateral_mps > 0.0

    def within_speeds(self, linear_mps: float, lateral_mps: float) -> tuple[float, float]:
        """The velocity (forward, sideways; m/s) shortened into the limits, in its own direction where the base can."""
        if not self.holonomic:
            return min(max(linear_mps, -self.linear_mps), self.linear_mps), 0.0
        share = math.hypot(linear_mps / self.linear_mps, lateral_mps / self.lateral_mps)
        return (linear_mps, lateral_mps) if share <= 1.0 else (linear_mps / share, lateral_mps / share)

    def ramped(self, before: tuple[float, float], target: tuple[float, float], elapsed_s: float) -> tuple[float, float]:
        """The velocity (forward, sideways; m/s) on the straight line from ``before`` to ``target`` that the base's
        acceleration allows after ``elapsed_s``."""
        most = self.linear_mps2 * elapsed_s
        x, y = target[0] - before[0], target[1] - before[1]
        change = math.hypot(x, y)
        return target if change <= most else (before[0] + x / change * most, before[1] + y / change * most)


class SafeAction(StrEnum):
    """What a group of joints does without a fresh command, and in an emergency stop.

    ``hold``: brake within the joints' acceleration and keep the position. ``yield``: keep no position, resist with
    damping only, so that a person can push it aside; its weight stays compensated. ``rest``: go to the group's
    positions at rest and keep them; only for parts that touch nothing, as a face that may be in mid-blink.
    """

    HOLD = "hold"
    YIELD = "yield"
    REST = "rest"


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of one joint: position ``lower`` to ``upper`` (rad, or m where prismatic), speed (rad/s), acceleration
    (rad/s^2), both positive, effort (N m, N where prismatic; 0 where unknown), and ``contact``: the effort from outside
    beyond which its group yields."""

    name: str
    lower: float
    upper: float
    velocity: float
    acceleration: float
    effort: float = 0.0
    contact: float = math.inf


@dataclass(frozen=True, slots=True)
class ActuatorGroup:
    """Joints that are commanded together: their limits, and the guard's rules for them.

    ``rest``: positions (rad, m) at rest, in the order of ``joints``; none: all 0. ``timeout_s``: the age (s) beyond
    which a command is stale. ``compliant``: whether its commands may set stiffness and damping, within
    ``stiffness_range`` (N m/rad) and ``damping_range`` (N m s/rad); ``stiffness`` and ``damping`` are the values
    without. A contact (:attr:`JointLimits.contact`) that lasts ``contact_s`` makes the group yield for
    ``contact_rest_s``, and until the next command then.
    """

    name: str
    joints: tuple[JointLimits, ...]
    stale: SafeAction = SafeAction.HOLD
    stop: SafeAction = SafeAction.HOLD
    rest: tuple[float, ...] = ()
    timeout_s: float = 0.25
    compliant: bool = False
    stiffness: float = 0.0
    damping: float = 0.0
    stiffness_range: tuple[float, float] = (0.0, math.inf)
    damping_range: tuple[float, float] = (0.0, math.inf)
    contact_s: float = 0.1
    contact_rest_s: float = 1.0


@dataclass(frozen=True, slots=True)
class ArmDescription:
    """An arm: the ``group`` of its joints, the link ``hand`` that it reaches with, the group of its ``gripper`` ("":
    none; one joint, closed at its least position), and the positions at ``rest`` (rad, in the group's order)."""

    group: str
    hand: str
    gripper: str
    rest: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class StreamDescription:
    """One sensor stream: its name, message type (a class of ``app.messages``) and nominal rate (Hz).

    ``thins``: whether the body gives it no faster than demanded (:meth:`RobotLink.demand`); else it gives all of it
    while it is wanted.
    """

    name: str
    message_type: type[Any]
    rate_hz: float
    thins: bool = False


@dataclass(frozen=True, slots=True)
class RobotDescription:
    """Description of a body: its name for people, its model (URDF), limits and streams by name."""

    name: str
    model_path: Path
    limits: BaseLimits
    streams: dict[str, StreamDescription]
    simulated: bool
    #: Whether :meth:`RobotLink.play` has an effect.
    loudspeaker: bool = False
    #: Footprint of the body: corners (m) in ``base_link``, convex, counter-clockwise. Empty for a body that does not
    #: move.
    footprint: tuple[tuple[float, float], ...] = ()
    #: Height of the body (m): obstacles above it are ignored.
    height_m: float = 1.5
    #: Whether :meth:`RobotLink.start` may be called again after a failure.
    restartable: bool = False
    #: Groups of joints that take a :class:`JointCommand`, by name. The base is not one of them: it takes a Twist.
    groups: dict[str, ActuatorGroup] = field(default_factory=dict)
    #: Arms by side: ``left``, ``right``.
    arms: dict[str, ArmDescription] = field(default_factory=dict)


class RobotLink(Protocol):
    """A body. All methods are called on the event loop and return at once unless they are ``async``.

    Streams every body has: ``odometry`` (Odometry), ``joints`` (JointState), ``status`` (LinkStatus). Sensor
    streams depend on the body: ``kinect`` (Image with depth), ``panorama`` (Image, fisheye), ``camera`` (Image),
    ``hokuyo`` (LaserScan), ``microphones`` (Audio), ``loudspeaker`` (Audio: what it plays, while it plays, sampled and
    numbered with ``microphones``), ``battery`` (BatteryState), ``imu`` (Imu). ``ground_truth`` (GroundTruth) and
    ``scene_truth`` (SceneTruth) exist only in a simulated world whose configuration turns them on.
    """

    @property
    def description(self) -> RobotDescription:
        """Description of this body; known before :meth:`start`."""
        ...

    async def start(self) -> None:
        """Bring the body up; returns when its streams run. Raises LinkFailed, having released everything."""
        ...

    async def stop(self) -> None:
        """Stop the wheels, then release everything; idempotent, under 1 s."""
        ...

    async def wait_failed(self) -> LinkFailed:
        """Wait until the body fails after a good start (its process died, its device vanished); return why."""
        ...

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """Call ``receive(message)`` on the loop for each message of ``stream``; returns the detacher.

        Raises KeyError naming the streams there are, if this body has no such stream.
        """
        ...

    def demand(self, stream: str, rate_hz: float) -> None:
        """Set the rate at which ``stream`` is wanted: at 0 (the default) it is not produced.

        A stream that ``thins`` is given at most at that rate, by leaving out whole periods of it; any other, and one
        demanded faster than it is, at its own rate. ``odometry``, ``joints`` and ``status`` always run.
        """
        ...

    def periods(self, stream: str) -> int:
        """How many periods of ``stream`` the message ends that is being delivered: its own, and those before it that
        were left out. A receiver asks while it is called; 1 for a stream without ``thins``.
        """
        ...

    def command(self, command: Twist | JointCommand) -> None:
        """Give the base a velocity, or the joints of a group their set-points.

        The guard clamps a velocity (forward and sideways as one vector), ramps towards it, and keeps it for 200 ms. It
        clamps set-points to the joints' limits, and approaches them within their speeds and accelerations; a command
        older than the group's timeout ends in the group's safe action. A group or joint that the body does not have is
        ignored.
        """
        ...

    def play(self, audio: Audio) -> None:
        """Play one frame of one channel through the loudspeaker, after earlier ones; no effect on a body without one.

        At most half a second waits to be played: beyond it the oldest is dropped.
        """
        ...

    def e_stop(self, reason: str) -> None:
        """Latch the emergency stop: zero velocity until :meth:`clear_e_stop`."""
        ...

    def clear_e_stop(self) -> None:
        """Release the latch; the base stays still until the next fresh command."""
        ...
