"""The robot interface: a body, simulated, replayed or real, as the rest of the program uses it.

A link gives sensor streams and is the only writer to the motors; the guard (command age, limits, latched e-stop) is
behind it, in another process. Implementations are in ``app/robots/``; modules know only this file.
"""

from __future__ import annotations

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
    """Limits of the mobile base: speeds (m/s, rad/s) and accelerations (m/s^2, rad/s^2), all positive."""

    linear_mps: float
    angular_radps: float
    linear_mps2: float
    angular_radps2: float


class SafeAction(StrEnum):
    """What a group of joints does without a fresh command, and in an emergency stop.

    ``hold``: brake within the joints' acceleration and keep the position. ``yield``: keep no position, resist with
    damping only, so that a person can push it aside; its weight stays compensated.
    """

    HOLD = "hold"
    YIELD = "yield"


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of one joint: position ``lower`` to ``upper`` (rad, or m where prismatic), speed (rad/s), acceleration
    (rad/s^2), both positive, and effort (N m, 0 where unknown)."""

    name: str
    lower: float
    upper: float
    velocity: float
    acceleration: float
    effort: float = 0.0


@dataclass(frozen=True, slots=True)
class ActuatorGroup:
    """Joints that are commanded together: their limits, and the guard's rules for them.

    ``timeout_s``: the age (s) beyond which a command is stale. ``compliant``: whether its commands may set stiffness
    and damping; ``stiffness`` (N m/rad) and ``damping`` (N m s/rad) are the values without.
    """

    name: str
    joints: tuple[JointLimits, ...]
    stale: SafeAction = SafeAction.HOLD
    stop: SafeAction = SafeAction.HOLD
    timeout_s: float = 0.25
    compliant: bool = False
    stiffness: float = 0.0
    damping: float = 0.0


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


class RobotLink(Protocol):
    """A body. All methods are called on the event loop and return at once unless they are ``async``.

    Streams every body has: ``odometry`` (Odometry), ``joints`` (JointState), ``status`` (LinkStatus). Sensor
    streams depend on the body: ``kinect`` (Image with depth), ``panorama`` (Image, fisheye), ``camera`` (Image),
    ``hokuyo`` (LaserScan), ``microphones`` (Audio), ``loudspeaker`` (Audio: what it plays, while it plays, sampled and
    numbered with ``microphones``), ``battery`` (BatteryState). ``ground_truth`` (GroundTruth) and ``scene_truth``
    (SceneTruth) exist only in a simulated world whose configuration turns them on.
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

        The guard clamps a velocity, ramps towards it, and keeps it for 200 ms. It clamps set-points to the joints'
        limits, and approaches them within their speeds and accelerations; a command older than the group's timeout
        ends in the group's safe action. A group or joint that the body does not have is ignored.
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
