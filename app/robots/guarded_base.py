"""The guard of a base in the process of its body: takes what the program sends, decides each step, and reports."""

from __future__ import annotations

from app.messages import LinkStatus, Twist
from app.robots import guard
from app.robots.guard import BaseVelocity, GuardAction, GuardLimits, GuardMode, GuardState
from app.robots.link_protocol import ClearEStop, DriveRequest, EStopRequest


def decide(now: float, state: GuardState, reasons: tuple[str, ...], limits: GuardLimits) -> GuardAction:
    """The allowed motion at ``now``: none while there are ``reasons``, else the guard's decision on the command."""
    if state.e_stop is None and reasons:
        return GuardAction(GuardMode.SENSOR_FAILURE, reasons[0], guard.ZERO, immediate=True)
    return guard.decide(now, state, {}, limits)


class GuardedBase:
    """The guard's state within ``limits``; ``e_stop``: reason of an emergency stop that is latched already, or None."""

    def __init__(self, limits: GuardLimits, e_stop: str | None) -> None:
        self._limits = limits
        self._state = GuardState(e_stop=e_stop)
        self._action = decide(0.0, self._state, (), limits)

    @property
    def velocity(self) -> BaseVelocity:
        """What the base is to be given now."""
        return self._state.applied

    @property
    def immediate(self) -> bool:
        """Whether it is to be given at once, without a ramp: a safety stop."""
        return self._action.immediate

    @property
    def e_stop(self) -> str | None:
        """The reason of the emergency stop that is latched, or None."""
        return self._state.e_stop

    def take(self, frame: object) -> None:
        """Take what the program sent, where it is for the guard."""
        match frame:
            case DriveRequest(stamp, linear, angular, lateral):
                command = guard.VelocityCommand(stamp, BaseVelocity(linear, angular, lateral))
                self._state = guard.accept(self._state, command)
            case EStopRequest(reason):
                self._state = guard.e_stop(self._state, reason)
            case ClearEStop():
                self._state = guard.clear_e_stop(self._state)

    def step(self, now: float, seconds: float, reasons: tuple[str, ...]) -> None:
        """Decide for the ``seconds`` after ``now`` (s, robot's clock); ``reasons`` forbid driving."""
        self._action = decide(now, self._state, reasons, self._limits)
        self._state = guard.step(self._state, self._action, self._limits, seconds)

    def status(self, now: float) -> LinkStatus:
        """The message of the stream ``status``."""
        applied = self._state.applied
        return LinkStatus(
            stamp=now,
            guard=self._action.mode.value,
            reason=self._action.reason,
            e_stopped=self._state.e_stop is not None,
            command_age_s=guard.command_age(self._state, now),
            applied=Twist(now, applied.linear_mps, applied.angular_radps, applied.lateral_mps),
            world_rate=1.0,
        )
