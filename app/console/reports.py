"""What REST and the live stream report of the robot and its program: both the same records."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.console.records.program import SourceState
from app.console.records.robot import GroupReport, Guard, LandmarkReport, OdometryReport, RobotFacts, Velocity
from app.link import ActuatorGroup
from app.messages import Exploitation, JointCommand, JointState, Landmarks, LinkStatus, Odometry
from app.runtime.freshness import Freshness, sources
from app.runtime.graph import Graph

if TYPE_CHECKING:
    from app.program.system import System

#: A report of who drives older than this says nothing about now.
EXPLOITATION_FRESH_S = 0.5
#: The body reports 20 times a second; after this long without a word it is silent.
SILENT_AFTER_S = 0.5


def robot_facts(system: System, *, replayed: bool = False) -> RobotFacts:
    """What the body is, and what people must know of how its program is configured; ``replayed``: it replays a
    recording, and cannot be driven or stopped."""
    description = system.link.description
    footprint = tuple((round(x, 4), round(y, 4)) for x, y in description.footprint)
    return RobotFacts(
        name=description.name,
        called=system.config.program.console.name or description.name,
        simulated=description.simulated,
        replayed=replayed,
        limits=description.limits,
        footprint=footprint,
        cautions=tuple(system.cautions),
    )


def guard(status: LinkStatus | None, now: float, rate: float = 1.0, problem: str = "") -> Guard:
    """What the guard says; before its first word, or when it has fallen silent, that it says nothing.

    ``problem``: why the body does not answer, where that is known. Its last report is then kept but for the state, and
    the age of its last command goes on growing. ``rate``: seconds of the robot's clock in one real second; not 1 where
    a recording is played faster or slower than it was recorded.
    """
    if status is None:
        return Guard("waiting", "The robot's link has not reported yet.", False, None, Velocity(0.0, 0.0))
    silence_s = now - status.stamp
    silent = problem != "" or silence_s > SILENT_AFTER_S * rate
    age_s = status.command_age_s
    if silent and age_s is not None:
        age_s += silence_s
    return Guard(
        state="silent" if silent else status.guard,
        reason=(problem or f"The body has reported nothing for {silence_s:.1f} s.") if silent else status.reason,
        e_stopped=status.e_stopped,
        command_age_ms=None if age_s is None else round(1e3 * age_s, 1),
        applied=Velocity(
            0.0 if problem else round(status.applied.linear_mps, 4),
            0.0 if problem else round(status.applied.angular_radps, 4),
            lateral_mps=0.0 if problem else round(status.applied.lateral_mps, 4),
        ),
    )


def groups(
    status: LinkStatus | None,
    exploitations: Mapping[str, Exploitation],
    speeds: Mapping[str, float],
    now: float,
    rate: float = 1.0,
) -> tuple[GroupReport, ...]:
    """What the guard says of each group of joints; ``exploitations`` and ``speeds`` (rad/s) by group; ``rate`` as for
    :func:`guard`."""
    if status is None:
        return ()
    silent = now - status.stamp > SILENT_AFTER_S * rate
    return tuple(
        GroupReport(
            each.group,
            state="silent" if silent else each.guard,
            reason="" if silent else each.reason,
            exploited=exploited(exploitations.get(each.group), now, rate),
            speed_radps=round(speeds.get(each.group, 0.0), 3),
        )
        for each in status.groups
    )


def joint_speeds(
    before: JointState | None, after: JointState | None, groups: Mapping[str, ActuatorGroup]
) -> dict[str, float]:
    """The greatest speed (rad/s) of the joints of each group between two messages; 0 without both."""
    if before is None or after is None or not after.stamp > before.stamp:
        return {}
    old = dict(zip(before.names, before.positions, strict=True))
    new = dict(zip(after.names, after.positions, strict=True))
    lasted_s = after.stamp - before.stamp
    return {
        name: max(
            (abs(new[j.name] - old[j.name]) / lasted_s for j in group.joints if j.name in old and j.name in new),
            default=0.0,
        )
        for name, group in groups.items()
    }


def turns_head(system: System) -> bool:
    """Whether a strategy of Teleoperation opens an output of joint positions."""
    outputs = {
        f"{slot.name}.{port}"
        for slot in system.graph.modules.values()
        for port, channel in slot.spec.outputs.items()
        if system.graph.channels[channel].message_type is JointCommand
    }
    return any(s.cls == "Teleoperation" and outputs & s.filters.keys() for s in system.table.strategies)


def odometry_report(odometry: Odometry | None) -> OdometryReport | None:
    """Where the robot believes to be and how it moves."""
    if odometry is None:
        return None
    pose = odometry.X_OB
    return OdometryReport(
        x=round(pose.x, 4),
        y=round(pose.y, 4),
        theta=round(pose.theta, 5),
        linear_mps=round(odometry.linear_mps, 4),
        angular_radps=round(odometry.angular_radps, 4),
        lateral_mps=round(odometry.lateral_mps, 4),
    )


def exploited(exploitation: Exploitation | None, now: float, rate: float = 1.0) -> str | None:
    """The behavior that drives now; ``rate`` as for :func:`guard`."""
    return exploitation.behavior if exploitation is not None and _is_fresh(exploitation, now, rate) else None


def limited(exploitation: Exploitation | None, now: float, rate: float = 1.0) -> str:
    """Why the collision monitor limited the driving behavior, "" where it did not; ``rate`` as for :func:`guard`."""
    return exploitation.limited if exploitation is not None and _is_fresh(exploitation, now, rate) else ""


def _is_fresh(exploitation: Exploitation, now: float, rate: float) -> bool:
    return now - exploitation.stamp <= EXPLOITATION_FRESH_S * rate


def landmarks(message: Landmarks | None) -> tuple[LandmarkReport, ...]:
    """Every landmark, in its message's frame."""
    if message is None:
        return ()
    return tuple(
        LandmarkReport(
            landmark.text,
            *landmark.p_FQ,
            sigma_m=landmark.sigma_m,
            sightings=landmark.sightings,
            first_seen=landmark.first_seen,
            last_seen=landmark.last_seen,
            heading=landmark.heading,
            heading_sigma=landmark.heading_sigma,
            id=landmark.id,
            frame=message.frame,
        )
        for landmark in message.landmarks
    )


def latest(graph: Graph, channel: str) -> Any:
    """The newest message of a channel, None before the first or if this robot has no such channel."""
    found = graph.channels.get(channel)
    return None if found is None else found.latest


def source_states(graph: Graph, channels: Mapping[str, Freshness]) -> tuple[SourceState, ...]:
    """How fresh each channel with a nominal rate is, of those that something can come on; ``channels`` as sampled."""
    there = sources(graph)
    return tuple(
        source_state(name, channels[name])
        for name, spec in graph.specs.items()
        if spec.rate_hz is not None and name in there
    )


def source_state(channel: str, freshness: Freshness) -> SourceState:
    """How fresh ``channel`` is, measured beside commanded."""
    age, rate, expected = freshness.age_s, freshness.rate_hz, freshness.commanded_hz
    return SourceState(
        channel=channel,
        state=freshness.state,
        age_ms=None if age is None else round(1e3 * age, 1),
        rate_hz=None if rate is None else round(rate, 2),
        expected_hz=None if expected is None else round(expected, 2),
    )
