"""Observation of a running program: ages of its messages, regularity, detections."""

from __future__ import annotations

import asyncio
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
import psutil

from app.messages import Exploitation, Faces, Landmarks, LinkStatus, LoudNoise, SceneTruth, SoundSources
from app.program.system import System

#: Channels of perceptions and behaviors, whose messages carry the stamp of their input.
RESULTS = (
    "qr_codes",
    "faces",
    "loud_noises",
    "sound_sources",
    "camera_jpeg",
    "point_cloud",
    "robot_audio",
    "exploitation",
)
BEHAVIOR_PERIOD_S = 0.1
#: Period (s) above which a tick of a 10 Hz behavior counts as missed.
MISSED_S = 0.15
LOOP_BEAT_S = 0.01


@dataclass(frozen=True, slots=True)
class Ages:
    """Ages of a channel's messages on arrival (s): ``count``, median, 95th percentile, maximum."""

    count: int
    median: float
    p95: float
    worst: float

    @staticmethod
    def of(ages: Sequence[float]) -> Ages:
        """Statistics of ``ages``; NaN without any."""
        if not ages:
            return Ages(0, math.nan, math.nan, math.nan)
        return Ages(len(ages), float(np.median(ages)), float(np.percentile(ages, 95)), max(ages))


@dataclass(frozen=True, slots=True)
class Outcome:
    """One condition of the experiment over ``seconds``.

    ``cpu`` of the program and ``body_cpu`` of its world in % of a core; ``world_rate`` simulated time over real time.
    ``ages`` by channel. ``dropped``: messages dropped by full inboxes, by ``Module.port``; ``lost_audio``: frames of
    sound among them. ``beats``: ticks of the base's arbiter (10 Hz), of which ``missed`` came later than 150 ms.
    ``stops``: stops by the guard for stale commands. ``loop_late_p99_s`` of the event loop. ``found``: codes, faces,
    noises and voices, by kind. ``series``: (s, age) by channel, for the plot. ``utilities`` served at the end by class.
    ``others_cpu``: CPU of all other programs, % of a core. ``script``: progress of the drive, in words.
    """

    attention: bool
    seconds: float
    cpu: float
    body_cpu: float
    world_rate: float
    ages: dict[str, Ages]
    rates: dict[str, float]
    dropped: dict[str, int]
    beats: int
    missed: int
    stops: int
    loop_late_p99_s: float
    found: dict[str, int]
    true_claps: int
    failures: int
    series: dict[str, list[tuple[float, float]]]
    utilities: dict[str, float]
    others_cpu: float = 0.0
    script: str = ""


def document(outcomes: Sequence[Outcome], settings: dict[str, Any]) -> dict[str, Any]:
    entries = []
    for outcome in outcomes:
        entry = asdict(outcome)
        del entry["series"]
        entries.append(entry)
    return {**settings, "outcomes": plain(entries)}


class Observer:
    """Observes ``system`` between :meth:`begin` and :meth:`outcome` without any demand of its own."""

    def __init__(self, system: System, body: int | None) -> None:
        self._system = system
        self._process = psutil.Process()
        self._body = None if body is None else psutil.Process(body)
        self._ages: dict[str, list[float]] = defaultdict(list)
        self._series: dict[str, list[tuple[float, float]]] = defaultdict(list)
        self._tracks: dict[str, set[Any]] = defaultdict(set)
        self._noises = 0
        self._claps: set[str] = set()
        self._beats: list[float] = []
        self._stops = 0
        self._guard = ""
        self._world_rates: list[float] = []
        self._late: list[float] = []
        self._ends: list[Callable[[], object]] = []
        self._origin = 0.0
        self._spent = (0.0, 0.0, 0.0)
        self._dropped: Counter[str] = Counter()

    def begin(self) -> None:
        """Start the observation."""
        system = self._system
        self._origin = system.clock.now()
        for name in (*RESULTS, "landmarks"):
            if name in system.graph.channels:
                self._ends.append(system.graph.channels[name].observe(partial(self._take, name)))
        self._ends.append(system.link.attach("status", self._watch_guard))
        if "scene_truth" in system.link.description.streams:
            self._ends.append(system.link.attach("scene_truth", self._learn))
            system.link.demand("scene_truth", math.inf)
        self._dropped = self._drops()
        self._spent = self._spend()
        beat = asyncio.create_task(self._measure_loop_delay(), name="loop lateness")
        self._ends.append(beat.cancel)

    def outcome(self, *, attention: bool, script: str = "") -> Outcome:
        """The observation since :meth:`begin`; ends it."""
        system = self._system
        seconds = system.clock.now() - self._origin
        ours, bodys, busy = (now - then for now, then in zip(self._spend(), self._spent, strict=True))
        for end in self._ends:
            end()
        gaps = np.diff(self._beats) if len(self._beats) > 1 else np.zeros(0)
        missed = int(np.sum(np.maximum(np.round(gaps / BEHAVIOR_PERIOD_S) - 1, gaps > MISSED_S)))
        intention = system.translator.current
        return Outcome(
            attention=attention,
            seconds=seconds,
            cpu=100 * ours / seconds,
            body_cpu=100 * bodys / seconds,
            world_rate=float(np.mean(self._world_rates)) if self._world_rates else math.nan,
            ages={name: Ages.of(self._ages[name]) for name in RESULTS if self._ages[name]},
            rates={name: len(ages) / seconds for name, ages in self._ages.items()},
            dropped=dict(self._drops() - self._dropped),
            beats=len(self._beats),
            missed=missed,
            stops=self._stops,
            loop_late_p99_s=float(np.percentile(self._late, 99)) if self._late else math.nan,
            found={
                "codes": len(self._tracks["codes"]),
                "faces": len(self._tracks["faces"]),
                "noises": self._noises,
                "voices": len(self._tracks["voices"]),
            },
            true_claps=len(self._claps),
            failures=sum(state.restarts for state in system.supervisor.states.values()),
            series=dict(self._series),
            utilities={s.cls: s.utility for s in intention.strategies} if intention is not None else {},
            others_cpu=100 * max(busy - ours - bodys, 0.0) / seconds,
            script=script,
        )

    def _take(self, channel: str, message: Any) -> None:
        now = self._system.clock.now()
        if channel in RESULTS:
            self._ages[channel].append(now - message.stamp)
            self._series[channel].append((now - self._origin, now - message.stamp))
        self._note(message)

    def _note(self, message: Any) -> None:
        match message:
            case Exploitation(group="base"):
                self._beats.append(self._system.clock.now())
            case Faces():
                self._tracks["faces"].update(face.track for face in message.faces)
            case LoudNoise():
                self._noises += 1
            case Landmarks():
                self._tracks["codes"].update(landmark.text for landmark in message.landmarks)
            case SoundSources():
                self._tracks["voices"].update(s.track for s in message.sources if s.speech >= 0.5)

    def _learn(self, truth: SceneTruth) -> None:
        self._claps.update(sound.name for sound in truth.sounds if sound.kind == "clap" and sound.began > self._origin)

    def _watch_guard(self, status: LinkStatus) -> None:
        self._world_rates.append(status.world_rate)
        if status.guard == "stale_command" and self._guard == "driving":
            self._stops += 1
        self._guard = status.guard

    def _spend(self) -> tuple[float, float, float]:
        """CPU time (s) of the program, of its body and of all programs; NaN for a body without a process of its own."""
        if self._body is None:
            return math.nan, math.nan, math.nan
        return _cpu_s([self._process]), _cpu_s([self._body, *self._body.children(recursive=True)]), _busy_s()

    def _drops(self) -> Counter[str]:
        return Counter(
            {
                name: statistics.dropped
                for channel in self._system.graph.channels.values()
                for name, statistics in channel.statistics().subscriptions.items()
                if statistics.dropped
            }
        )

    async def _measure_loop_delay(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            due = loop.time() + LOOP_BEAT_S
            await asyncio.sleep(LOOP_BEAT_S)
            self._late.append(loop.time() - due)


def _cpu_s(processes: Iterable[psutil.Process]) -> float:
    return sum(p.cpu_times().user + p.cpu_times().system for p in processes)


def _busy_s() -> float:
    """CPU time of all programs of this computer (s)."""
    times = psutil.cpu_times()
    return float(sum(times) - times.idle - getattr(times, "iowait", 0.0) - getattr(times, "guest", 0.0))


def plain(value: Any) -> Any:
    """``value`` as JSON has it: numbers that are none are null."""
    if isinstance(value, float):
        return round(value, 6) if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value
