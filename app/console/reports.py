"""What REST and the live stream tell of the robot, as JSON-able values; both say the same thing in the same words."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

from app.attention.chronicle import divisor_json
from app.attention.desires import SCALE
from app.link import RobotLink
from app.messages import Exploitation, Landmarks, LinkStatus, Odometry
from app.runtime.channel import Channel, SubscriptionStatistics
from app.runtime.graph import Graph, ModuleSlot

if TYPE_CHECKING:
    from app.system import System

#: A report of who drives older than this says nothing about now.
EXPLOITATION_FRESH_S = 0.5


def robot_json(link: RobotLink) -> dict[str, Any]:
    """What the body is."""
    description = link.description
    limits = description.limits
    return {
        "name": description.name,
        "simulated": description.simulated,
        "limits": {
            "linear_mps": limits.linear_mps,
            "angular_radps": limits.angular_radps,
            "linear_mps2": limits.linear_mps2,
            "angular_radps2": limits.angular_radps2,
        },
    }


def scale_json() -> dict[str, float]:
    """The ends of the scales of intensity and utility."""
    return {"intensity": SCALE, "utility": SCALE}


def guard_json(status: LinkStatus | None) -> dict[str, Any]:
    """What the guard says; before its first word, that it has said nothing."""
    if status is None:
        return {
            "state": "waiting",
            "reason": "The robot's link has not reported yet.",
            "e_stopped": False,
            "command_age_ms": None,
            "applied": {"linear_mps": 0.0, "angular_radps": 0.0},
        }
    return {
        "state": status.guard,
        "reason": status.reason,
        "e_stopped": status.e_stopped,
        "command_age_ms": None if status.command_age_s is None else round(1e3 * status.command_age_s, 1),
        "applied": {
            "linear_mps": round(status.applied.linear_mps, 4),
            "angular_radps": round(status.applied.angular_radps, 4),
        },
    }


def odometry_json(odometry: Odometry | None) -> dict[str, float] | None:
    """Where the robot believes to be and how it moves."""
    if odometry is None:
        return None
    pose = odometry.X_OB
    return {
        "x": round(pose.x, 4),
        "y": round(pose.y, 4),
        "theta": round(pose.theta, 5),
        "linear_mps": round(odometry.linear_mps, 4),
        "angular_radps": round(odometry.angular_radps, 4),
    }


def exploited(exploitation: Exploitation | None, now: float) -> str | None:
    """The behavior that drives now."""
    if exploitation is None or now - exploitation.stamp > EXPLOITATION_FRESH_S:
        return None
    return exploitation.behavior


def landmarks_json(message: Landmarks | None) -> list[dict[str, Any]]:
    """Every landmark, in ``odom``."""
    if message is None:
        return []
    return [
        {
            "text": landmark.text,
            "x": landmark.p_OQ[0],
            "y": landmark.p_OQ[1],
            "z": landmark.p_OQ[2],
            "sigma_m": landmark.sigma_m,
            "sightings": landmark.sightings,
            "first_seen": landmark.first_seen,
            "last_seen": landmark.last_seen,
        }
        for landmark in message.landmarks
    ]


def latest(graph: Graph, channel: str) -> Any:
    """The newest message of a channel, None before the first or if this robot has no such channel."""
    found = graph.channels.get(channel)
    return None if found is None else found.latest


class SourceWatch:
    """How fresh each channel with a nominal rate is; :meth:`sample` is called 20 times a second."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._channels = {name: spec for name, spec in graph.specs.items() if spec.rate_hz is not None}
        self._counts: dict[str, deque[tuple[float, int]]] = {name: deque() for name in self._channels}
        self._wanted_since: dict[str, float] = {}

    def sample(self, now: float) -> list[dict[str, Any]]:
        """State, age and rate of each channel at ``now`` (seconds)."""
        return [self._source(name, self._graph.channels[name], now) for name in self._channels]

    def _source(self, name: str, channel: Channel[Any], now: float) -> dict[str, Any]:
        statistics = channel.statistics()
        counts = self._counts[name]
        counts.append((now, statistics.published))
        while len(counts) > 2 and counts[1][0] <= now - 1.0:
            counts.popleft()
        elapsed = counts[-1][0] - counts[0][0]
        rate = (counts[-1][1] - counts[0][1]) / elapsed if elapsed > 0 else None
        divisor = self._source_divisor(name)
        open_now = channel.wanted and divisor is not None
        since = self._wanted_since.setdefault(name, now) if open_now else self._wanted_since.pop(name, now)
        age = None if statistics.last_stamp is None else now - statistics.last_stamp
        return {
            "channel": name,
            "state": self._state(name, open_now, age, now - since, divisor or 1),
            "age_ms": None if age is None else round(1e3 * age, 1),
            "rate_hz": None if rate is None else round(rate, 2),
            "expected_hz": round((self._channels[name].rate_hz or 0.0) / divisor, 2) if divisor is not None else 0.0,
        }

    def _state(self, name: str, open_now: bool, age: float | None, open_for: float, divisor: int) -> str:
        if not open_now:
            return "closed"
        limit = self._channels[name].stale_after_s(divisor)
        fresh = age is not None and (limit is None or age <= limit)
        if fresh:
            return "live"
        # A source that was just asked for is given its time before it counts as stale.
        return "waiting" if age is None or (limit is not None and open_for <= max(1.0, 2 * limit)) else "stale"

    def _source_divisor(self, channel: str) -> int | None:
        """φ of the output that feeds a channel, None when closed."""
        producer = self._graph.producers.get(channel)
        return 1 if producer is None else divisor_json(self._graph.filters.divisors()[producer])


class ModuleReport:
    """Load and counters of every module; CPU per message is taken between two calls of :meth:`sample`."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._counted: dict[str, tuple[int, int]] = {}
        self._message_cpu_us: dict[str, float | None] = {}

    def sample(self) -> list[dict[str, Any]]:
        """Measure CPU per message since the last call (or the start), and report."""
        for name, slot in self._system.graph.modules.items():
            taken = sum(p.subscription.statistics().taken for p in slot.context.inputs.values() if p.connected)
            before_ns, before = self._counted.get(name, (0, 0))
            self._counted[name] = (slot.context.meter.cpu_ns, taken)
            cpu_us = 1e-3 * (slot.context.meter.cpu_ns - before_ns)
            self._message_cpu_us[name] = round(cpu_us / (taken - before), 1) if taken > before else None
        return self.modules()

    def modules(self) -> list[dict[str, Any]]:
        """Every module now."""
        return [self.module(slot) for slot in self._system.graph.modules.values()]

    def module(self, slot: ModuleSlot) -> dict[str, Any]:
        """One module now."""
        state = self._system.supervisor.states[slot.name]
        return {
            "name": slot.name,
            "title": slot.title,
            "state": state.status,
            "cpu": round(self._system.load.latest.modules.get(slot.name, 0.0), 2),
            "cpu_budget": slot.spec.cpu_budget,
            "message_cpu_us": self._message_cpu_us.get(slot.name),
            "restarts": state.restarts,
            "problem": state.problem or None,
            "inputs": [
                {"name": port.name, "channel": port.channel.name, **subscription_json(port.subscription.statistics())}
                for port in slot.context.inputs.values()
                if port.connected and port.channel is not None
            ],
            "outputs": [
                {
                    "name": port.name,
                    "channel": None if port.channel is None else port.channel.name,
                    "divisor": divisor_json(port.filter.divisor),
                    "offered": port.offered,
                }
                for port in slot.context.outputs.values()
            ],
        }


def subscription_json(statistics: SubscriptionStatistics) -> dict[str, Any]:
    """The counters of one consumer's end of a channel."""
    return {
        "divisor": divisor_json(statistics.divisor),
        "received": statistics.received,
        "passed": statistics.passed,
        "decimated": statistics.decimated,
        "dropped": statistics.dropped,
        "age_ms": None if statistics.age_s is None else round(1e3 * statistics.age_s, 2),
    }
