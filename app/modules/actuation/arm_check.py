"""The check in front of an arm: set-points that it cannot reach, and ways on which it would touch its own body.

A refused arm brakes, and is held where it stands until a command is accepted again. While it moves, it is stopped
before it touches what has come in its way (the head, the other arm). No clock: times come with the messages.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.base.self_collision import SelfCollision
from app.link import ActuatorGroup
from app.messages import JointCommand, JointState
from app.modules.arm_way import STANDS_RADPS, stopping, touching, way

#: Positions that are older (s) say nothing.
_FRESH_S = 0.3
#: From measured positions to braking joints (s): their period, and that of the control steps.
_REACTION_S = 0.06
#: A joint that follows its set-point later (s) is hardly moved by it.
_MOST_LAG_S = 0.3
#: Joints of others count with where they are so much later (s).
_AHEAD_S = 0.12
#: A way is judged again when another joint has moved so far (rad).
_MOVED_RAD = 0.02
_ROUNDING_RAD = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class _Accepted:
    """A way that was free: to ``goal`` (J,) rad, with all other joints at ``others``."""

    goal: NDArray[np.float64]
    others: Mapping[str, float]
    from_rest: bool


class ArmCheck:
    """Judges the commands of one arm, the ``group`` whose joints ``collision`` is about. ``others`` are the joints of
    the body, by name, that move what the arm could touch."""

    def __init__(self, group: ActuatorGroup, collision: SelfCollision, others: Collection[str]) -> None:
        self._group = group
        self._collision = collision
        self._names = [joint.name for joint in group.joints]
        self._others = tuple(name for name in others if name not in self._names)
        self._stamp = -np.inf
        self._measured: Mapping[str, float] = {}
        self._velocities: Mapping[str, float] = {}
        #: Goals of joints that a command does not name are those given before.
        self._goals: dict[str, float] = {}
        self._accepted: _Accepted | None = None
        self._held: tuple[float, ...] | None = None

    @property
    def moving(self) -> bool:
        """Whether a joint of the arm moves."""
        return any(abs(self._velocities.get(name, 0.0)) > STANDS_RADPS for name in self._names)

    def take(self, joints: JointState) -> None:
        """Take the measured positions of all joints."""
        positions = dict(zip(joints.names, joints.positions, strict=True))
        elapsed_s = joints.stamp - self._stamp
        if 0 < elapsed_s <= _FRESH_S:
            before = self._measured
            self._velocities = {
                name: (position - before.get(name, position)) / elapsed_s for name, position in positions.items()
            }
        else:
            self._velocities = {}
        self._stamp, self._measured = joints.stamp, positions

    def release(self) -> None:
        """No behavior commands the arm any more."""
        self._goals.clear()
        self._accepted = self._held = None

    def judge(self, command: JointCommand) -> tuple[JointCommand | None, str]:
        """The command to give instead of ``command``, None where there is nothing to give, and the reason in words; the
        command itself and "" where it is free."""
        if problem := self._unreachable(command):
            return self._hold(command), problem
        if not command.stamp - self._stamp <= _FRESH_S or not all(name in self._measured for name in self._names):
            self._accepted = None
            return None, f"the positions of {self._group.name} are not known"
        if problem := self._touching(command):
            self._accepted = None
            return self._hold(command), problem
        self._held = None
        self._goals.update(zip(command.names, command.positions, strict=True))
        return command, ""

    def _unreachable(self, command: JointCommand) -> str:
        limits = {joint.name: joint for joint in self._group.joints}
        if len(command.names) != len(command.positions):
            return f"the command has {len(command.positions)} positions for {len(command.names)} joints"
        for name, position in zip(command.names, command.positions, strict=True):
            joint = limits.get(name)
            if joint is None:
                return f"{self._group.name} has no joint {name!r}; it has {', '.join(limits)}"
            if not joint.lower - _ROUNDING_RAD <= position <= joint.upper + _ROUNDING_RAD:
                return f"{position:.3g} of {name} is not within {joint.lower:g} to {joint.upper:g}"
        return ""

    def _touching(self, command: JointCommand) -> str:
        joints, measured = self._group.joints, self._measured
        here, speeds = self._of(measured), self._of(self._velocities)
        others = {name: measured[name] for name in self._others if name in measured}
        goal = self._of({**measured, **self._goals, **dict(zip(command.names, command.positions, strict=True))})
        judged = self._accepted is not None and np.array_equal(self._accepted.goal, goal) and self._alike(others)
        if judged and self._accepted is not None and self._accepted.from_rest:
            return ""
        others_move = any(abs(self._velocities.get(name, 0.0)) > STANDS_RADPS for name in others)
        if self.moving or others_move:
            # The way of an arm that moves already is not the one from rest, which is judged below.
            ahead = {name: others[name] + self._velocities.get(name, 0.0) * _AHEAD_S for name in others}
            soon = stopping(joints, here, speeds, self._reaction_s(command), goal)
            if problem := touching(self._collision, soon, ahead):
                return problem
        if judged:
            return ""
        if problem := touching(self._collision, way(joints, here, goal), others):
            return problem
        self._accepted = _Accepted(goal, others, from_rest=not self.moving)
        return ""

    def _alike(self, others: Mapping[str, float]) -> bool:
        assert self._accepted is not None
        before = self._accepted.others
        return all(abs(position - before.get(name, np.inf)) <= _MOVED_RAD for name, position in others.items())

    def _hold(self, command: JointCommand) -> JointCommand | None:
        """The command that keeps the arm where it stops; None where its positions are not known."""
        if not all(name in self._measured for name in self._names):
            return None
        if self._held is None:
            here, speeds = self._of(self._measured), self._of(self._velocities)
            self._held = tuple(stopping(self._group.joints, here, speeds, self._reaction_s(command))[-1].tolist())
            self._goals = dict(zip(self._names, self._held, strict=True))
        return replace(command, names=tuple(self._names), positions=self._held, stiffness=(), damping=())

    def _reaction_s(self, command: JointCommand) -> float:
        """From measured positions to braking set-points (s): a compliant joint follows its set-point late, by damping
        over stiffness."""
        group = self._group
        stiffness, damping = (*command.stiffness, group.stiffness)[0], (*command.damping, group.damping)[0]
        return _REACTION_S + (min(damping / stiffness, _MOST_LAG_S) if group.compliant and stiffness > 0 else 0.0)

    def _of(self, values: Mapping[str, float]) -> NDArray[np.float64]:
        return np.array([values.get(name, 0.0) for name in self._names])
