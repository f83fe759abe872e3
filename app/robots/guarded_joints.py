"""The guards of groups of joints whose own controllers take positions, in the process of their body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from app.link import ActuatorGroup, SafeAction
from app.messages import GroupStatus, JointCommand
from app.robots import joint_guard
from app.robots.joint_guard import JointAction, JointGuardState, JointMode
from app.robots.link_protocol import ClearEStop


@dataclass(slots=True)
class _Guarded:
    """A group; ``state``: None until all of its joints were measured; ``sent``: the set-points that went out last."""

    group: ActuatorGroup
    action: JointAction
    state: JointGuardState | None = None
    measured: tuple[float, ...] = ()
    sent: tuple[float, ...] = ()


class GuardedJoints:
    """All ``groups`` of joints of a body that measures their positions and follows set-points.

    Set-points begin where the joints are, and again at each command after a rest, for others may have moved them
    meanwhile. Without a fresh command, in an emergency stop, and while the positions are not known, they brake within
    the joints' acceleration and stay; what stays is not sent again.
    """

    def __init__(self, groups: Iterable[ActuatorGroup]) -> None:
        nothing = JointAction(JointMode.HOLDING, "its joints were not measured yet", SafeAction.HOLD)
        self._groups = {group.name: _Guarded(group, nothing) for group in groups}

    def take(self, frame: object) -> None:
        """Take what the program sent, where it is for a group that was measured already."""
        match frame:
            case JointCommand(group=name) if (guarded := self._groups.get(name)) and guarded.state is not None:
                guarded.state = joint_guard.accept(guarded.state, guarded.group, frame)
            case ClearEStop():
                for guarded in self._groups.values():
                    if guarded.state is not None:
                        guarded.state = joint_guard.clear_e_stop(guarded.state, guarded.group)

    def measure(self, positions: Mapping[str, float]) -> None:
        """Take the positions (rad, m) that the body measured, by joint; those that are no numbers are not known."""
        for guarded in self._groups.values():
            now = tuple(positions.get(joint.name, math.nan) for joint in guarded.group.joints)
            if not all(map(math.isfinite, now)):
                continue
            guarded.measured = now
            if guarded.state is None:
                guarded.state = joint_guard.at_rest(guarded.group, now)

    def step(
        self,
        now: float,
        seconds: float,
        e_stop: str | None,
        faults: Mapping[str, str],
        refusals: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Decide for the ``seconds`` after ``now`` (s, robot's clock). ``e_stop``: reason of the emergency stop that is
        latched, or None; ``faults``: why a group must not move, by its name, "" where it may; ``refusals``: why the
        body itself did not take its commands, likewise."""
        for name, guarded in self._groups.items():
            if guarded.state is None:
                continue
            moved = guarded.action.mode is JointMode.MOVING
            guarded.action = joint_guard.decide(now, guarded.state, guarded.group, e_stop)
            if (fault := faults.get(name, "")) and e_stop is None:
                guarded.action = JointAction(JointMode.HOLDING, fault, SafeAction.HOLD)
            elif (refusal := refusals.get(name, "")) and guarded.action.mode is JointMode.MOVING:
                guarded.action = JointAction(JointMode.REFUSED, refusal, SafeAction.HOLD)
            if guarded.action.mode is JointMode.MOVING and not moved and _rests(guarded.state):
                guarded.state = _from(guarded.state, guarded)
            guarded.state = joint_guard.step(guarded.state, guarded.action, guarded.group, guarded.measured, seconds)

    def moves(self, name: str) -> bool:
        """Whether a group follows commands now."""
        return self._groups[name].action.mode is JointMode.MOVING

    def due(self, name: str) -> tuple[float, ...]:
        """The set-points (rad, m) of a group that are to be sent now, in the order of its joints; none: nothing new."""
        guarded = self._groups[name]
        if guarded.state is None:
            return ()
        now = tuple(setpoint.position for setpoint in guarded.state.setpoints)
        if now == guarded.sent or (not guarded.sent and guarded.action.mode is not JointMode.MOVING):
            return ()
        guarded.sent = now
        return now

    def status(self, now: float) -> tuple[GroupStatus, ...]:
        """The state of each group."""
        return tuple(
            GroupStatus(name, guarded.action.mode.value, guarded.action.reason, None)
            if guarded.state is None
            else joint_guard.status(now, guarded.state, guarded.group, guarded.action)
            for name, guarded in self._groups.items()
        )


def _rests(state: JointGuardState) -> bool:
    return all(setpoint.velocity == 0.0 for setpoint in state.setpoints)


def _from(state: JointGuardState, guarded: _Guarded) -> JointGuardState:
    """``state`` with its set-points where the joints are, within their limits. Goals stay."""
    positions = zip(state.setpoints, guarded.measured, guarded.group.joints, strict=True)
    return replace(
        state,
        setpoints=tuple(
            replace(setpoint, position=joint_guard.clamp(measured, limits)) for setpoint, measured, limits in positions
        ),
    )
