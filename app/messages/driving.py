"""Commands to the body, and what became of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TeleopCommand:
    """An operator's command: ``linear`` and ``angular`` in [-1, 1] of the robot's limits (forward, left).

    ``held`` is the dead-man: False means stop, whatever the other fields. ``stamp`` is the robot's clock at arrival,
    ``sequence`` grows by one with each command of one operator session. ``override`` is a hold of its own: while it is
    held, obstacles do not stop the robot, but only a crawl is allowed.
    """

    stamp: float
    operator: str
    sequence: int
    held: bool
    linear: float
    angular: float
    override: bool = False


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity command for the base: forward m/s and turn rad/s (left positive)."""

    stamp: float
    linear_mps: float
    angular_radps: float


@dataclass(frozen=True, slots=True)
class Exploitation:
    """Which behavior's command the arbiter let through: ``behavior`` is None when no behavior drives.

    ``limited``: in words, why the collision monitor slowed or stopped it, "" where it did not.
    """

    stamp: float
    behavior: str | None
    twist: Twist
    limited: str = ""


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """What the robot's link and its guard report, at 20 Hz.

    ``guard`` is one of ``idle`` (no command ever or a zero one), ``driving``, ``stale_command`` (no fresh command:
    zero), ``e_stopped`` (latched: zero), ``sensor_failure``. ``reason``: the same in words. ``command_age_s`` is the
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
