"""Commands to the body, and what became of them."""

from __future__ import annotations

from dataclasses import dataclass

from app.messages.actuation import GroupStatus


@dataclass(frozen=True, slots=True)
class TeleopCommand:
    """An operator's command: ``linear``, ``angular`` and ``lateral`` in [-1, 1] of the robot's limits (forward, turn
    left, sideways to the left).

    ``held`` is the dead-man: False means that the base stops, whatever the other fields. ``stamp`` is the robot's clock
    at arrival, ``sequence`` grows by one with each command of one operator session. ``override`` is a hold of its own:
    while it is held, obstacles do not stop the robot, but only a crawl is allowed. ``head_held`` is the dead-man of the
    head, which is turned whether the base is driven or not: ``pan`` and ``tilt`` in [-1, 1] of its joints' speeds
    (left, up).
    """

    stamp: float
    operator: str
    sequence: int
    held: bool
    linear: float
    angular: float
    override: bool = False
    lateral: float = 0.0
    head_held: bool = False
    pan: float = 0.0
    tilt: float = 0.0


@dataclass(frozen=True, slots=True)
class GamepadState:
    """A gamepad that is plugged in at the robot, with each of its reports, and again while its dead-man is held.

    ``held`` is the dead-man, ``stop`` the button of the emergency stop; ``linear``, ``angular`` and ``lateral`` are its
    sticks, -1 to 1 (forward, left, left). ``connected`` False: it was unplugged, and holds nothing.
    """

    stamp: float
    connected: bool
    held: bool
    stop: bool
    linear: float = 0.0
    angular: float = 0.0
    lateral: float = 0.0


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity command for the base: forward m/s, turn rad/s and sideways m/s (left positive).

    ``lateral_mps`` is 0 on a base that cannot move sideways.
    """

    stamp: float
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class Exploitation:
    """Which behavior's command the arbiter of an actuator group let through: ``behavior`` is None without any.

    ``limited``: in words, why a check in front of the group (the base's collision monitor) slowed or stopped it, ""
    where none did. ``twist`` is what the base was given, zero for another ``group``. ``outdone``: behaviors that
    command the group as well and were not let through.
    """

    stamp: float
    behavior: str | None
    twist: Twist
    limited: str = ""
    group: str = "base"
    outdone: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class LinkStatus:
    """What the robot's link and its guard report, at 20 Hz.

    ``guard`` is one of ``idle`` (no command ever or a zero one), ``driving``, ``stale_command`` (no fresh command:
    zero), ``e_stopped`` (latched: zero), ``sensor_failure``. ``reason``: the same in words. ``command_age_s`` is the
    age of the newest command at the guard, None before the first. ``applied`` is the twist the wheels are given now.
    ``world_rate`` is simulated time over real time (1.0 on hardware). ``groups``: the guard's state of each actuator
    group of joints.
    """

    stamp: float
    guard: str
    reason: str
    e_stopped: bool
    command_age_s: float | None
    applied: Twist
    world_rate: float
    groups: tuple[GroupStatus, ...] = ()
