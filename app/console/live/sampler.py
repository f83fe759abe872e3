"""What the stream tells at fixed rates: status and lanes at 20 Hz, what is perceived, where the robot is and where it
goes at up to 10 Hz, load at 1 Hz, landmarks as they change; and what the lanes were, for who comes later."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from app.console import reports
from app.console.live import lane_history
from app.console.live.lanes import LaneSampler
from app.console.live.recorded_lanes import Spoke, recorded_lanes
from app.console.perceived import perceived_json
from app.console.percepts import Percepts
from app.console.playback import rate
from app.console.way import WayReport
from app.console.wire import encode_text
from app.messages import Exploitation, Landmarks, LinkStatus, Odometry

if TYPE_CHECKING:
    from app.program.system import System

PERIOD_S = 0.05
#: What is told at up to 10 Hz is looked at every so many periods.
SLOW_BEATS = 2
#: So much of a recording's attention is looked back on after a jump (s).
RECORDED_S = 60.0


class Audience(Protocol):
    """Where frames go."""

    link_status: LinkStatus | None

    @property
    def moving(self) -> bool:
        """Whether a recording's time is just being moved: what is said meanwhile is of no time."""
        ...

    def broadcast(self, kind: str, frame: str) -> None:
        """Give everybody the newest frame of ``kind``."""
        ...

    def broadcast_status(self, status: dict[str, Any]) -> None:
        """Give everybody the status, completed with who drives."""
        ...


class Sampler:
    """Samples the program: :meth:`run` while somebody watches, :meth:`remember` always."""

    def __init__(self, system: System, audience: Audience, percepts: Percepts, way: WayReport) -> None:
        self._system = system
        self._audience = audience
        self._percepts = percepts
        self._way = way
        #: By type, what was told last on change.
        self._told: dict[str, dict[str, Any]] = {}
        self._lanes = LaneSampler(system.graph, system.classes, system.table.strategies)
        self._history = lane_history.LaneHistory(system.classes)
        self._modules = reports.ModuleReport(system)
        self._sequence = 0
        self._load_stamp = 0.0
        self._exploitation: Exploitation | None = None
        self._odometry: Odometry | None = None

    def channels(self) -> dict[str, Callable[[Any], None]]:
        """The channels to tap while it runs, with what takes their messages."""
        return {
            "exploitation": self._on_exploitation,
            "odometry": self._on_odometry,
            "landmarks": self._on_landmarks,
        }

    def _on_exploitation(self, message: Exploitation) -> None:
        self._exploitation = message

    def _on_odometry(self, message: Odometry) -> None:
        self._odometry = message

    def _on_landmarks(self, message: Landmarks) -> None:
        landmarks = reports.landmarks_json(message)
        self._audience.broadcast("landmarks", encode_text({"type": "landmarks", "landmarks": landmarks}))

    async def run(self) -> None:
        """Sample until cancelled. Beats missed are skipped, never made up for."""
        pace = self._system.pace
        due = pace.now()
        while True:
            self._sample(self._system.clock.now())
            due = max(due + PERIOD_S, pace.now())
            await pace.sleep_until(due)

    async def remember(self) -> None:
        """Note the lanes for later until cancelled."""
        clock = self._system.clock
        due = clock.now()
        while True:
            now = clock.now()
            self._history.add(now, self._rows(now))
            # A recording's time may have gone back.
            due = min(max(due, now - lane_history.PERIOD_S), now) + lane_history.PERIOD_S
            await clock.sleep_until(due)

    def begin_anew(self, stamp: float, attention: Sequence[Any], spoke: Spoke) -> None:
        """Time has jumped to ``stamp``: the past is now what the recording tells of its ``attention`` before, and of
        when channels ``spoke``."""
        self._lanes.forget()
        self._history.forget()
        begin = stamp - RECORDED_S
        for at, rows in recorded_lanes(
            self._lanes, attention, begin=begin, end=stamp, period_s=lane_history.PERIOD_S, spoke=spoke
        ):
            self._history.add(at, rows)
        self._exploitation = None
        self._odometry = None
        # Whoever watches has forgotten it: the same is news again.
        self._told = {}

    def _sample(self, now: float) -> None:
        self._sequence += 1
        self._audience.broadcast_status(self._status(now))
        if self._audience.moving:
            return
        lanes = {"type": "lanes", "seq": self._sequence, "stamp": now, "rows": self._rows(now)}
        self._audience.broadcast("lanes", encode_text(lanes))
        if self._sequence % SLOW_BEATS == 0:
            for kind, frame in self._news(now):
                self._audience.broadcast(kind, frame)
        if self._system.load.latest.stamp != self._load_stamp:
            self._load_stamp = self._system.load.latest.stamp
            self._modules.sample()
            self._audience.broadcast("load", self.load_frame())

    def _news(self, now: float) -> Iterator[tuple[str, str]]:
        """The frames of what has changed, by type; that of a place each time that it was found."""
        for kind, told in {"perceived": perceived_json(self._percepts.at(now)), **self._way_now()}.items():
            compared = told if kind == "localization" else told | {"stamp": 0}
            if compared != self._told.get(kind):
                self._told[kind] = compared
                yield kind, encode_text({"type": kind, **told})

    def _way_now(self) -> dict[str, dict[str, Any]]:
        way = self._way
        told = {"localization": way.localization(), "navigation": way.navigation(), "zones": way.zones()}
        return {kind: value for kind, value in told.items() if value is not None}

    def way_frames(self) -> dict[str, str]:
        """Where the robot is and where it goes, now, as far as it is known: frames by type."""
        return {kind: encode_text({"type": kind, **told}) for kind, told in self._way_now().items()}

    def perceived_frame(self) -> str:
        """What is perceived now."""
        perceived = perceived_json(self._percepts.at(self._system.clock.now()))
        return encode_text({"type": "perceived", **perceived})

    def _status(self, now: float) -> dict[str, Any]:
        status = self._audience.link_status
        return {
            "type": "status",
            "seq": self._sequence,
            "stamp": now,
            "guard": reports.guard_json(status, now, rate(self._system.clock), self._system.body_restarter.problem),
            "world_rate": 1.0 if status is None else round(status.world_rate, 4),
            "odometry": reports.odometry_json(self._odometry),
            "exploited": reports.exploited(self._exploitation, now, rate(self._system.clock)),
            "limited": reports.limited(self._exploitation, now, rate(self._system.clock)),
            "sources": reports.sources_json(self._system.graph, self._system.freshness.read(now)),
        }

    def _rows(self, now: float) -> list[dict[str, Any]]:
        current = self._system.translator.current
        return self._lanes.sample(
            now,
            self._system.workspace.strongest(),
            () if current is None else [strategy.name for strategy in current.strategies],
            {} if current is None else current.reasons,
        )

    def history_frame(self) -> str:
        """The lanes of the last minutes."""
        return self._history.frame()

    def load_frame(self) -> str:
        """The last load window."""
        load = self._system.load.latest
        return encode_text(
            {
                "type": "load",
                "stamp": load.stamp,
                "process_cpu": round(load.process, 2),
                "budget": self._system.translator.capacities.get("cpu"),
                "modules": self._modules.modules(),
            }
        )
