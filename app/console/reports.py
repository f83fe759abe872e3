"""What REST and the live stream tell of the robot, as JSON-able values; both say the same thing in the same words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from app.attention.desires import SCALE
from app.attention.serialize import desire_class_to_json
from app.attention.timeline_writer import divisor_json
from app.messages import Exploitation, Landmarks, LinkStatus, Odometry
from app.runtime.channel import SubscriptionStatistics
from app.runtime.freshness import Freshness, sources
from app.runtime.graph import Graph, ModuleSlot

if TYPE_CHECKING:
    from app.program.system import System

#: A report of who drives older than this says nothing about now.
EXPLOITATION_FRESH_S = 0.5
#: The body reports 20 times a second; after this long without a word it is silent.
SILENT_AFTER_S = 0.5


def robot_json(system: System, *, replayed: bool = False) -> dict[str, Any]:
    """What the body is, and what people must know of how its program is configured; ``replayed``: it replays a
    recording, and cannot be driven or stopped."""
    description = system.link.description
    limits = description.limits
    return {
        "name": description.name,
        "simulated": description.simulated,
        "replayed": replayed,
        "limits": {
            "linear_mps": limits.linear_mps,
            "angular_radps": limits.angular_radps,
            "linear_mps2": limits.linear_mps2,
            "angular_radps2": limits.angular_radps2,
        },
        "footprint": [[round(x, 4), round(y, 4)] for x, y in description.footprint],
        "cautions": [asdict(caution) for caution in system.cautions],
    }


def scale_json() -> dict[str, float]:
    """The ends of the scales of intensity and utility."""
    return {"intensity": SCALE, "utility": SCALE}


def class_json(system: System, name: str) -> dict[str, Any]:
    """A desire class, and whether a strategy of this program's modules serves it: else no desire for it comes true."""
    served = any(strategy.cls == name for strategy in system.table.strategies)
    return desire_class_to_json(system.classes[name]) | {"served": served}


def guard_json(status: LinkStatus | None, now: float, rate: float = 1.0, problem: str = "") -> dict[str, Any]:
    """What the guard says; before its first word, or when it has fallen silent, that it says nothing.

    ``problem``: why the body does not answer, where that is known. Its last report is then kept but for the state, and
    the age of its last command goes on growing. ``rate``: seconds of the robot's clock in one real second; not 1 where
    a recording is played faster or slower than it was recorded.
    """
    if status is None:
        return {
            "state": "waiting",
            "reason": "The robot's link has not reported yet.",
            "e_stopped": False,
            "command_age_ms": None,
            "applied": {"linear_mps": 0.0, "angular_radps": 0.0},
        }
    silence_s = now - status.stamp
    silent = problem != "" or silence_s > SILENT_AFTER_S * rate
    age_s = status.command_age_s
    if silent and age_s is not None:
        age_s += silence_s
    return {
        "state": "silent" if silent else status.guard,
        "reason": (problem or f"The body has reported nothing for {silence_s:.1f} s.") if silent else status.reason,
        "e_stopped": status.e_stopped,
        "command_age_ms": None if age_s is None else round(1e3 * age_s, 1),
        "applied": {
            "linear_mps": 0.0 if problem else round(status.applied.linear_mps, 4),
            "angular_radps": 0.0 if problem else round(status.applied.angular_radps, 4),
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


def exploited(exploitation: Exploitation | None, now: float, rate: float = 1.0) -> str | None:
    """The behavior that drives now; ``rate`` as for :func:`guard_json`."""
    return exploitation.behavior if exploitation is not None and _is_fresh(exploitation, now, rate) else None


def limited(exploitation: Exploitation | None, now: float, rate: float = 1.0) -> str:
    """Why the collision monitor slowed or stopped whoever drives, "" where it did not; ``rate`` as before."""
    return exploitation.limited if exploitation is not None and _is_fresh(exploitation, now, rate) else ""


def _is_fresh(exploitation: Exploitation, now: float, rate: float) -> bool:
    return now - exploitation.stamp <= EXPLOITATION_FRESH_S * rate


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


def sources_json(graph: Graph, channels: Mapping[str, Freshness]) -> list[dict[str, Any]]:
    """How fresh each channel with a nominal rate is, of those that something can come on; ``channels`` as sampled."""
    there = sources(graph)
    return [
        {"channel": name, **freshness_json(channels[name])}
        for name, spec in graph.specs.items()
        if spec.rate_hz is not None and name in there
    ]


def freshness_json(freshness: Freshness) -> dict[str, Any]:
    """How fresh a channel is, measured beside commanded."""
    age, rate, expected = freshness.age_s, freshness.rate_hz, freshness.commanded_hz
    return {
        "state": freshness.state,
        "age_ms": None if age is None else round(1e3 * age, 1),
        "rate_hz": None if rate is None else round(rate, 2),
        "expected_hz": None if expected is None else round(expected, 2),
    }


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
