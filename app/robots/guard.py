"""The guard: last check between the program and the wheels, as pure functions of time, ages, flags and state.

It runs in the link's process at every control step, independent of the runtime: a dead or frozen runtime stops sending
commands, and their age triggers the stop.

- No fresh command for ``command_timeout_s`` (0.2 s): zero. Latched emergency stop: zero until it is cleared.
- Speeds are clamped to the base's limits; a command with a non-finite value is refused and counts as zero. Forward and
  sideways speeds are clamped and ramped as one vector: else a diagonal would be faster than either limit, and bend.
- An ordinary command is approached at the base's accelerations, up and down alike (thesis 4.2: 0.40 m/s^2, 4.00
  rad/s^2). A *safety* stop (stale command, emergency stop, failed sensor) sets the wheels' speed to zero at once; the
  drives then brake as hard as their torque limit lets them (``emergency_mps2`` of the robot's configuration).

Source: ArduPilot's and PX4's failsafes are built the same way: one decision function, stepped in its tests.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

from app.link import BaseLimits

FUTURE_TOLERANCE_S = 0.05
"""Greatest advance (s) of a command's stamp over the guard's clock."""


class GuardMode(StrEnum):
    """State of the guard; the values of ``LinkStatus.guard``."""

    IDLE = "idle"
    DRIVING = "driving"
    STALE_COMMAND = "stale_command"
    E_STOPPED = "e_stopped"
    SENSOR_FAILURE = "sensor_failure"


@dataclass(frozen=True, slots=True)
class BaseVelocity:
    """A velocity of the base: forward (m/s), turn (rad/s, left positive) and sideways (m/s, left positive)."""

    linear_mps: float = 0.0
    angular_radps: float = 0.0
    lateral_mps: float = 0.0

    @property
    def is_finite(self) -> bool:
        """Whether all parts are finite."""
        return all(math.isfinite(part) for part in (self.linear_mps, self.angular_radps, self.lateral_mps))

    @property
    def is_zero(self) -> bool:
        """Whether all parts are exactly zero."""
        return self.linear_mps == 0.0 and self.angular_radps == 0.0 and self.lateral_mps == 0.0


ZERO = BaseVelocity()


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """A commanded velocity, at ``stamp`` (s, robot's clock)."""

    stamp: float
    velocity: BaseVelocity


@dataclass(frozen=True, slots=True)
class GuardLimits:
    """The base's limits; greatest age (s) of a command, and of a sensor that driving requires."""

    base: BaseLimits
    command_timeout_s: float = 0.2
    sensor_timeout_s: float = 0.5


@dataclass(frozen=True, slots=True)
class GuardState:
    """State between steps.

    ``applied``: velocity of the wheels; ``command``: the newest command; ``e_stop``: reason of the latched stop or
    None; ``refused``: reason of refusing the newest command, or None.
    """

    applied: BaseVelocity = ZERO
    command: VelocityCommand | None = None
    e_stop: str | None = None
    refused: str | None = None


@dataclass(frozen=True, slots=True)
class GuardAction:
    """Action now: approach ``target``, at once if ``immediate``, else along the ramp; with mode and reason."""

    mode: GuardMode
    reason: str
    target: BaseVelocity
    immediate: bool


def accept(state: GuardState, command: VelocityCommand) -> GuardState:
    """The state after ``command``: refused and counted as zero if not finite, ignored if older than the last."""
    if not (command.velocity.is_finite and math.isfinite(command.stamp)):
        refused = VelocityCommand(state.command.stamp if state.command else -math.inf, ZERO)
        return replace(state, command=refused, refused="the last command was not a number")
    if state.command is not None and command.stamp < state.command.stamp:
        return state
    return replace(state, command=command, refused=None)


def e_stop(state: GuardState, reason: str) -> GuardState:
    """The state with the emergency stop latched; the first reason stays."""
    return state if state.e_stop is not None else replace(state, e_stop=reason)


def clear_e_stop(state: GuardState) -> GuardState:
    """The state with the latch released: earlier commands are dropped, so the base waits for a new one."""
    return state if state.e_stop is None else replace(state, e_stop=None, command=None, refused=None)


def command_age(state: GuardState, now: float) -> float | None:
    """Age (s) of the newest command at ``now``, None before the first."""
    if state.command is None or not math.isfinite(state.command.stamp):
        return None
    return now - state.command.stamp


def clamp(velocity: BaseVelocity, limits: BaseLimits) -> BaseVelocity:
    """``velocity`` within the base's speeds."""
    linear, lateral = limits.within_speeds(velocity.linear_mps, velocity.lateral_mps)
    angular = min(max(velocity.angular_radps, -limits.angular_radps), limits.angular_radps)
    return BaseVelocity(linear, angular, lateral)


def decide(now: float, state: GuardState, sensor_ages: Mapping[str, float], limits: GuardLimits) -> GuardAction:
    """The allowed motion at ``now`` (s, robot's clock).

    ``sensor_ages``: seconds since the last value of each sensor that driving requires. The most severe state wins:
    emergency stop, failed sensor, unusable or stale command.
    """
    if state.e_stop is not None:
        return GuardAction(GuardMode.E_STOPPED, f"emergency stop: {state.e_stop}", ZERO, immediate=True)
    for name, age in sensor_ages.items():
        if not age <= limits.sensor_timeout_s:
            return GuardAction(GuardMode.SENSOR_FAILURE, f"{name} has given nothing for {age:.1f} s", ZERO, True)
    if state.refused is not None:
        return GuardAction(GuardMode.STALE_COMMAND, state.refused, ZERO, immediate=True)
    if state.command is None:
        return GuardAction(GuardMode.IDLE, "no command yet", ZERO, immediate=False)
    age = now - state.command.stamp
    if age < -FUTURE_TOLERANCE_S:
        reason = f"the command's time lies {-age:.1f} s in the future: is its sender's clock the robot's?"
        return GuardAction(GuardMode.STALE_COMMAND, reason, ZERO, immediate=True)
    if age > limits.command_timeout_s:
        if state.command.velocity.is_zero and state.applied.is_zero:
            return GuardAction(GuardMode.IDLE, "standing; no command", ZERO, immediate=True)
        return GuardAction(GuardMode.STALE_COMMAND, f"no fresh command for {age:.1f} s", ZERO, immediate=True)
    target = clamp(state.command.velocity, limits.base)
    if target.is_zero:
        return GuardAction(GuardMode.IDLE, "commanded to stand", ZERO, immediate=False)
    return GuardAction(GuardMode.DRIVING, "", target, immediate=False)


def step(state: GuardState, action: GuardAction, limits: GuardLimits, dt_s: float) -> GuardState:
    """The state ``dt_s`` seconds later: ``applied`` moved towards the action's target, within the base's
    accelerations."""
    if action.immediate:
        return replace(state, applied=action.target)
    before, target = state.applied, action.target
    linear, lateral = limits.base.ramped(
        (before.linear_mps, before.lateral_mps), (target.linear_mps, target.lateral_mps), dt_s
    )
    angular = _approach(before.angular_radps, target.angular_radps, limits.base.angular_radps2 * dt_s)
    return replace(state, applied=BaseVelocity(linear, angular, lateral))


def _approach(value: float, target: float, most: float) -> float:
    return min(max(target, value - most), value + most)
