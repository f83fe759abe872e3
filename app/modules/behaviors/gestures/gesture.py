"""What a gesture is made of: what it sees at one instant, what it gives, and moves of an arm. No clock, no channel."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.link import ActuatorGroup
from app.messages import Accomplished, Exploitation, JointCommand
from app.modules.behaviors.gestures.arms import Arm

Vector = NDArray[np.float64]

#: A joint so near (rad) to its goal is there.
_THERE_RAD = 0.04
#: A move that is refused for so long (s) looks for another way, and has failed after so many. The arm stands by then:
#: the way of one that moved before is not the one that was looked at.
_REFUSED_S = 0.7
_WAYS = 2
#: Beyond the time that it needs, a move may take so much longer (s): a person may hold the arm.
_LATE_S = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class GestureView:
    """What a gesture sees at ``now`` (s): positions (rad, m) of all joints as ``measured``, by name; the newest report
    of each actuator group's arbiter; the point ``p_BP`` (3,) m in ``base_link``, None where none is known."""

    now: float
    measured: Mapping[str, float]
    reports: Mapping[str, Exploitation]
    p_BP: Vector | None = None


@dataclass(frozen=True, slots=True)
class GestureStep:
    """What a gesture gives: commands, how fast (rad/s, left positive) the base shall turn (None: as it likes), and the
    outcome once it has ended. ``reason``: of the outcome, or what it waits for, in words."""

    commands: tuple[JointCommand, ...] = ()
    turn_radps: float | None = None
    outcome: Accomplished | None = None
    reason: str = ""


class Gesture(ABC):
    """One desire's gesture, asked ten times a second."""

    @abstractmethod
    def step(self, view: GestureView) -> GestureStep:
        """What to do now."""


def failed(reason: str) -> GestureStep:
    """The last step of a gesture that cannot be made."""
    return GestureStep(outcome="failed", reason=reason)


@dataclass(frozen=True, slots=True)
class Servo:
    """How a group of joints is commanded for ``behavior``: with stiffness and damping, or (None) with its own."""

    behavior: str
    group: ActuatorGroup
    impedance: tuple[float, float] | None

    @property
    def limp(self) -> bool:
        """Whether it keeps no position."""
        return self.impedance is not None and self.impedance[0] == 0.0

    def command(self, now: float, names: tuple[str, ...], positions: tuple[float, ...]) -> JointCommand:
        """The command of ``positions`` (rad, m) for joints ``names``."""
        if self.impedance is None:
            return JointCommand(now, self.group.name, names, positions)
        stiffness, damping = ((value,) * len(names) for value in self.impedance)
        return JointCommand(now, self.group.name, names, positions, stiffness=stiffness, damping=damping)

    def drives(self, view: GestureView) -> bool:
        """Whether no other behavior commands the group."""
        report = view.reports.get(self.group.name)
        return report is None or report.behavior in (None, self.behavior)

    def refusal(self, view: GestureView) -> str:
        """Why the check in front of the group refuses what this behavior commands; "" where it does not."""
        report = view.reports.get(self.group.name)
        return report.limited if report is not None and report.behavior == self.behavior else ""


class ArmMove:
    """A move of ``arm`` along ``route``, postures (4,) rad of which the last is its ``goal``, started at ``view``."""

    def __init__(self, arm: Arm, servo: Servo, route: Sequence[Vector], view: GestureView) -> None:
        self.arm = arm
        self.goal = route[-1]
        self._before = list(route[:-1])
        self._servo = servo
        speed = np.array([joint.velocity for joint in arm.kinematics.joints])
        acceleration = np.array([joint.acceleration for joint in arm.kinematics.joints])
        legs = np.abs(np.diff([arm.positions(view.measured), *route], axis=0))
        self._takes_s = float((legs / speed + speed / acceleration).max(axis=1).sum()) + _LATE_S
        self._began = view.now
        self._free = view.now
        self._ways = 0

    def command(self, view: GestureView) -> JointCommand:
        """The command that makes the move, at each step."""
        while self._before and self._near(self._before[0], view):
            self._before.pop(0)
        posture = self._before[0] if self._before else self.goal
        return self._servo.command(view.now, self.arm.names, tuple(posture.tolist()))

    def there(self, view: GestureView) -> bool:
        """Whether the arm is at its goal; at once for one that keeps no position."""
        return self._servo.limp or (not self._before and self._near(self.goal, view))

    def problem(self, view: GestureView) -> str:
        """Why the move has failed, in words; "" while it has not."""
        if not self._servo.drives(view):
            self._began = self._free = view.now
            return ""
        refusal = self._servo.refusal(view)
        if not refusal:
            self._free = view.now
        elif view.now - self._free >= _REFUSED_S and not self._turn_aside(view):
            return refusal
        if view.now - self._began < self._takes_s or self.there(view):
            return ""
        off = np.abs(self.goal - self.arm.positions(view.measured))
        worst = int(np.argmax(off))
        return f"{self.arm.names[worst]} stays {math.degrees(off[worst]):.0f}° from where it should be"

    def _turn_aside(self, view: GestureView) -> bool:
        """Take another way from here, if there is one."""
        self._ways += 1
        route = self.arm.route(self.goal, view.measured) if self._ways < _WAYS else ""
        if isinstance(route, str):
            return False
        self._before, self._began, self._free = list(route[:-1]), view.now, view.now
        return True

    def _near(self, posture: Vector, view: GestureView) -> bool:
        return bool(np.abs(posture - self.arm.positions(view.measured)).max() < _THERE_RAD)


class Stay:
    """Measures for how long something has been so."""

    def __init__(self) -> None:
        self._since: float | None = None

    def lasted(self, now: float, so: bool) -> float:
        """Seconds until ``now`` for which it has been ``so`` without a break."""
        if not so:
            self._since = None
            return 0.0
        self._since = now if self._since is None else self._since
        return now - self._since
