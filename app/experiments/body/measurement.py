"""What every actuator group did: the guard's states, speeds and positions against its limits, and who commanded."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.link import ActuatorGroup, BaseLimits
from app.messages import Exploitation, JointState, LinkStatus, Odometry
from app.program.system import System

BASE = "base"
#: Speeds are differences over so long (s): a joint's noise of 0.5 mrad is 7 mrad/s then.
_SPAN_S = 0.1
#: A joint slower than this (rad/s), and a base slower than this (m/s or rad/s), is at rest.
_REST = 0.03

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GroupFigures:
    """Figures of one group.

    ``behaviors``: seconds that each commanded; ``modes``: seconds in each state of the guard; ``oldest_s``: the
    greatest age of a command that the guard acted by (s), None without any; ``speed``: greatest speed over its limit;
    ``beyond``: greatest position beyond a limit (rad or m, 0: none); ``rest_s``: from the emergency stop to rest, None
    where there was none, or the group did not move then.
    """

    group: str
    behaviors: Mapping[str, float]
    modes: Mapping[str, float]
    oldest_s: float | None
    speed: float
    beyond: float
    rest_s: float | None


@dataclass(slots=True)
class Observation:
    """What came, each with its stamp (s, since the begin): states of guards and commands, positions, base speeds."""

    stopped_at: float | None = None
    statuses: list[tuple[float, LinkStatus]] = field(default_factory=list)
    exploitations: list[tuple[float, Exploitation]] = field(default_factory=list)
    joints: list[tuple[float, JointState]] = field(default_factory=list)
    odometry: list[tuple[float, float, float]] = field(default_factory=list)


class BodyObserver:
    """Observes a program's body from its making to :meth:`end`, without any demand of its own."""

    def __init__(self, system: System) -> None:
        self.observation = Observation()
        self._begin = system.clock.now()
        take: dict[str, Callable[[Any], None]] = {
            "status": self._take_status,
            "joints": lambda joints: self.observation.joints.append((self._since(joints.stamp), joints)),
            "odometry": self._take_odometry,
        }
        self._ends = [system.link.attach(stream, receive) for stream, receive in take.items()]
        for channel in system.graph.channels.values():
            if channel.message_type is Exploitation:
                self._ends.append(channel.observe(self._take_exploitation))

    def end(self, stopped_at: float | None) -> Observation:
        """All of it; ``stopped_at``: when the emergency stop was pressed (s, robot's clock), if it was."""
        for end in self._ends:
            end()
        self.observation.stopped_at = None if stopped_at is None else self._since(stopped_at)
        return self.observation

    def _since(self, stamp: float) -> float:
        return stamp - self._begin

    def _take_status(self, status: LinkStatus) -> None:
        self.observation.statuses.append((self._since(status.stamp), status))

    def _take_odometry(self, odometry: Odometry) -> None:
        at = self._since(odometry.stamp)
        self.observation.odometry.append((at, odometry.linear_mps, odometry.angular_radps))

    def _take_exploitation(self, exploitation: Exploitation) -> None:
        self.observation.exploitations.append((self._since(exploitation.stamp), exploitation))


def group_figures(seen: Observation, groups: Mapping[str, ActuatorGroup], base: BaseLimits) -> list[GroupFigures]:
    """Figures of the base, then of ``groups`` in their order."""
    return [_base_figures(seen, base), *(_joint_figures(seen, group) for group in groups.values())]


def spans(times: Sequence[float], values: Sequence[str | None]) -> list[tuple[float, float, str]]:
    """Runs of one value that is not None: (begin, end, value). The last sample ends the last run."""
    found: list[tuple[float, float, str]] = []
    start, current = 0.0, None
    for at, value in zip(times, values, strict=True):
        if value == current:
            continue
        if current is not None:
            found.append((start, at, current))
        start, current = at, value
    if current is not None and times:
        found.append((start, times[-1], current))
    return found


def behavior_spans(seen: Observation, group: str) -> list[tuple[float, float, str]]:
    """When which behavior commanded ``group``."""
    mine = [(at, each.behavior) for at, each in seen.exploitations if each.group == group]
    return spans([at for at, _ in mine], [behavior for _, behavior in mine])


def mode_spans(seen: Observation, group: str) -> list[tuple[float, float, str]]:
    """When the guard of ``group`` was in which state."""
    return spans([at for at, _ in seen.statuses], [_guard(status, group)[0] for _, status in seen.statuses])


def positions(seen: Observation, joint: str) -> tuple[Floats, Floats]:
    """Times (s) and positions (rad or m) of ``joint``, each (N,)."""
    rows = [(at, state.positions[state.names.index(joint)]) for at, state in seen.joints if joint in state.names]
    table = np.array(rows, dtype=np.float64).reshape(-1, 2)
    return table[:, 0], table[:, 1]


def speeds(times: Floats, values: Floats) -> Floats:
    """Speed of each sample (N,): the difference to the sample about :data:`_SPAN_S` earlier, over the time between."""
    if len(times) < 2:
        return np.zeros(len(times))
    earlier = np.maximum(np.searchsorted(times, times - _SPAN_S, side="right") - 1, 0)
    gaps = times - times[earlier]
    return np.where(gaps > 0, np.abs(values - values[earlier]) / np.where(gaps > 0, gaps, 1.0), 0.0)


def rest_after(times: Floats, moving: NDArray[np.bool_], stopped_at: float | None) -> float | None:
    """Seconds from ``stopped_at`` to the last sample that moves; None without a stop, or where nothing moved then."""
    if stopped_at is None or not len(times):
        return None
    at_stop = moving[(times > stopped_at - _SPAN_S) & (times <= stopped_at)]
    if not at_stop.any():
        return None
    later = times[moving & (times > stopped_at)]
    return float(later[-1] - stopped_at) if len(later) else 0.0


def _guard(status: LinkStatus, group: str) -> tuple[str, float | None]:
    """State of the guard of ``group``, and the age (s) of its newest command."""
    if group == BASE:
        return status.guard, status.command_age_s
    return next(((each.guard, each.command_age_s) for each in status.groups if each.group == group), ("", None))


def _lengths(runs: Sequence[tuple[float, float, str]]) -> dict[str, float]:
    total: dict[str, float] = {}
    for start, end, value in runs:
        total[value] = total.get(value, 0.0) + end - start
    return total


def _oldest(seen: Observation, group: str, acting: str) -> float | None:
    ages = [age for _, status in seen.statuses for mode, age in [_guard(status, group)] if mode == acting]
    return max((age for age in ages if age is not None), default=None)


def _base_figures(seen: Observation, limits: BaseLimits) -> GroupFigures:
    table = np.abs(np.array(seen.odometry, dtype=np.float64).reshape(-1, 3))
    times, linear, angular = table[:, 0], table[:, 1], table[:, 2]
    fastest = max(linear.max(initial=0.0) / limits.linear_mps, angular.max(initial=0.0) / limits.angular_radps)
    return GroupFigures(
        BASE,
        behaviors=_lengths(behavior_spans(seen, BASE)),
        modes=_lengths(mode_spans(seen, BASE)),
        oldest_s=_oldest(seen, BASE, "driving"),
        speed=float(fastest),
        beyond=0.0,
        rest_s=rest_after(times, (linear > _REST) | (angular > _REST), seen.stopped_at),
    )


def _joint_figures(seen: Observation, group: ActuatorGroup) -> GroupFigures:
    fastest = beyond = 0.0
    rests: list[float] = []
    for limits in group.joints:
        times, values = positions(seen, limits.name)
        speed = speeds(times, values)
        fastest = max(fastest, float(speed.max(initial=0.0)) / limits.velocity)
        over = np.maximum(values - limits.upper, limits.lower - values).max(initial=0.0)
        beyond = max(beyond, float(over))
        # What is within the span of a difference is not the joint's motion after the stop.
        rest = rest_after(times, speed > _REST, seen.stopped_at)
        if rest is not None:
            rests.append(max(rest - _SPAN_S, 0.0))
    return GroupFigures(
        group.name,
        behaviors=_lengths(behavior_spans(seen, group.name)),
        modes=_lengths(mode_spans(seen, group.name)),
        oldest_s=_oldest(seen, group.name, "moving"),
        speed=fastest,
        beyond=beyond,
        rest_s=max(rests, default=None),
    )
