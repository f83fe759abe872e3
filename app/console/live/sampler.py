"""What the stream carries at a fixed rate and is on no channel: the status, 20 times a second."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from app.console import reports
from app.console.live import messages
from app.console.playback import rate
from app.console.records.program import SourceState
from app.messages import Exploitation, JointState, LinkStatus, Odometry

if TYPE_CHECKING:
    from app.program.system import System

PERIOD_S = 0.05
#: Freshness of sources is judged again after so long (s): it reads every channel of the program.
SOURCES_PERIOD_S = 0.2


class StatusAudience(Protocol):
    """Where frames go."""

    link_status: LinkStatus | None

    def broadcast_status(self, status: messages.Status) -> None:
        """Give every page the status, completed with who drives."""
        ...


class Sampler:
    """Samples the program: :meth:`run` while there are viewers."""

    def __init__(self, system: System, audience: StatusAudience) -> None:
        self._system = system
        self._audience = audience
        self._sequence = 0
        self._exploitation: Exploitation | None = None
        #: The newest by group of joints.
        self._exploitations: dict[str, Exploitation] = {}
        self._odometry: Odometry | None = None
        self._sources: tuple[SourceState, ...] = ()
        self._sources_judged = -math.inf
        #: The last two.
        self._joints: tuple[JointState | None, JointState | None] = (None, None)

    def channels(self) -> dict[str, Callable[[Any], None]]:
        """The channels to tap while it runs, with what takes their messages."""
        taps: dict[str, Callable[[Any], None]] = {
            name: self._on_group
            for name, channel in self._system.graph.channels.items()
            if channel.message_type is Exploitation
        }
        return {**taps, "exploitation": self._on_exploitation, "odometry": self._on_odometry, "joints": self._on_joints}

    def _on_exploitation(self, message: Exploitation) -> None:
        self._exploitation = message

    def _on_group(self, message: Exploitation) -> None:
        self._exploitations[message.group] = message

    def _on_joints(self, message: JointState) -> None:
        self._joints = (self._joints[1], message)

    def _on_odometry(self, message: Odometry) -> None:
        self._odometry = message

    async def run(self) -> None:
        """Sample until cancelled. Beats missed are skipped, never made up for."""
        pace = self._system.pace
        due = pace.now()
        while True:
            self._sample(self._system.clock.now())
            due = max(due + PERIOD_S, pace.now())
            await pace.sleep_until(due)

    def clear(self) -> None:
        """Time has jumped."""
        self._exploitation = None
        self._exploitations.clear()
        self._odometry = None
        self._joints = (None, None)
        self._sources_judged = -math.inf

    def _sample(self, now: float) -> None:
        self._sequence += 1
        self._audience.broadcast_status(self._status(now))

    def _status(self, now: float) -> messages.Status:
        status, speed = self._audience.link_status, rate(self._system.clock)
        speeds = reports.joint_speeds(*self._joints, self._system.link.description.groups)
        return messages.Status(
            seq=self._sequence,
            stamp=now,
            guard=reports.guard(status, now, speed, self._system.body_restarter.problem),
            world_rate=1.0 if status is None else round(status.world_rate, 4),
            odometry=reports.odometry_report(self._odometry),
            driver=None,
            asker=None,
            speaker=None,
            exploited=reports.exploited(self._exploitation, now, speed),
            limited=reports.limited(self._exploitation, now, speed),
            groups=reports.groups(status, self._exploitations, speeds, now, rate=speed),
            waits="",
            sources=self._source_states(now),
        )

    def _source_states(self, now: float) -> tuple[SourceState, ...]:
        if not 0.0 <= now - self._sources_judged < SOURCES_PERIOD_S:
            self._sources = reports.source_states(self._system.graph, self._system.freshness.read(now))
            self._sources_judged = now
        return self._sources
