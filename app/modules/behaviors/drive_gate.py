"""Dead-man rules for an operator's commands: a pure decision on each command and on each tick of the clock.

A command with ``held`` False stops at once, also a late one. While ``held``, ``timeout_s`` without a command stops. An
invalid stick position (not a number, beyond full stick) stops and is refused. A held command older than one already
taken is ignored. A command that holds the head alone says nothing of a base that is not driven.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.link import BaseLimits
from app.messages import TeleopCommand, Twist

#: Full stick is 1; conversions may add a rounding error.
_FULL = 1.0 + 1e-6


@dataclass(frozen=True, slots=True)
class Decision:
    """Result of a command or a tick: the ``twist`` to publish (or None), and a ``problem`` in words (or "")."""

    twist: Twist | None
    problem: str = ""


class DriveGate:
    """Turns operator commands into twists; ``timeout_s``: how long a held command stays valid without another (s)."""

    def __init__(self, limits: BaseLimits, timeout_s: float = 0.25) -> None:
        self.limits = limits
        self.timeout_s = timeout_s
        self._operator: str | None = None
        self._sequence = -1
        self._held_since: float | None = None

    def take(self, command: TeleopCommand, speed: float = 1.0) -> Decision:
        """Decide on a command; full stick gives ``speed`` (in ]0, 1]) of the robot's limits."""
        if command.operator != self._operator:
            self._operator, self._sequence = command.operator, -1
        late = command.sequence <= self._sequence
        self._sequence = max(self._sequence, command.sequence)
        if not command.held:
            of_the_head = command.head_held and self._held_since is None
            return Decision(None if of_the_head else self._stop(command.stamp))
        if late:
            return Decision(None)
        sticks = (command.linear, command.angular, command.lateral)
        if not all(math.isfinite(stick) and abs(stick) <= _FULL for stick in sticks):
            return Decision(
                self._stop(command.stamp),
                f"refused a command: linear, angular and lateral must be numbers from -1 to 1, "
                f"not {command.linear!r}, {command.angular!r} and {command.lateral!r}",
            )
        self._held_since = command.stamp
        linear, angular, lateral = (max(-1.0, min(1.0, stick)) for stick in sticks)
        limits = self.limits
        if limits.holonomic and (pushed := math.hypot(linear, lateral)) > 1.0:
            # Full stick both ways is a direction, not a greater speed.
            linear, lateral = linear / pushed, lateral / pushed
        return Decision(
            Twist(
                command.stamp,
                speed * linear * limits.linear_mps,
                speed * angular * limits.angular_radps,
                speed * lateral * limits.lateral_mps,
            )
        )

    def beat(self, now: float) -> Decision:
        """Decide on silence: stops a held command older than ``timeout_s``, once."""
        if self._held_since is None or now - self._held_since < self.timeout_s:
            return Decision(None)
        silence_s = now - self._held_since
        return Decision(
            self._stop(now), f"stopped: the dead-man was held, but nothing came from the operator for {silence_s:.2f} s"
        )

    def _stop(self, stamp: float) -> Twist:
        self._held_since = None
        return Twist(stamp, 0.0, 0.0)
