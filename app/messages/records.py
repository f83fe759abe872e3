"""Records of the program about itself. Recorded and replayed as any other message; no module acts on them. A closed
filter's divisor is inf."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LaneState = Literal["fulfilled", "degraded", "unfulfilled", "inhibited", "undesired", "needed"]
RecorderState = Literal["idle", "recording", "ring", "stopped"]


@dataclass(frozen=True, slots=True)
class DesireRecord:
    """One desire at one moment: ``params`` is JSON; ``expires`` (robot's clock, s) is +inf without an expiry."""

    id: str
    cls: str
    intensity: float
    utility: float
    security: bool
    params: str
    source_kind: str
    source_name: str
    created: float
    expires: float


@dataclass(frozen=True, slots=True)
class DesiresRecord:
    """Every desire in the Intention Workspace after a change of it."""

    stamp: float
    desires: tuple[DesireRecord, ...]


@dataclass(frozen=True, slots=True)
class Divisors:
    """φ of every filter that attention controls, after a change: ``divisors[i]`` (inf: closed) of ``filters[i]``."""

    stamp: float
    filters: tuple[str, ...]
    divisors: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class LaneRow:
    """Desire class ``cls``: ``intensity`` and desired ``utility`` of its strongest desire (None: there is none).

    ``divisor`` is φ of the input that its strategies at work live by (inf: closed), ``divisors[i]`` that of every
    filter ``filters[i]`` of these strategies. ``rate`` in [0, 1] is messages let through over messages offered, in the
    last second; 0 when closed, None when nothing was offered. ``state`` and ``text`` are the reason.
    """

    cls: str
    intensity: float | None
    utility: float | None
    rate: float | None
    divisor: float
    filters: tuple[str, ...]
    divisors: tuple[float, ...]
    state: LaneState
    text: str


@dataclass(frozen=True, slots=True)
class Lanes:
    """One row for each desire class, in a fixed order."""

    stamp: float
    rows: tuple[LaneRow, ...]


@dataclass(frozen=True, slots=True)
class LoadRecord:
    """CPU over the last window of ``window_s``: ``cpu[i]`` % of a core for ``modules[i]``, ``process`` in all."""

    stamp: float
    window_s: float
    modules: tuple[str, ...]
    cpu: tuple[float, ...]
    process: float


@dataclass(frozen=True, slots=True)
class ModuleRecord:
    """A module's state changed: ``status`` as ``app.runtime.supervisor`` names it, ``problem`` in words."""

    stamp: float
    module: str
    status: str
    restarts: int
    problem: str


@dataclass(frozen=True, slots=True)
class EventRecord:
    """One event of the timeline: ``data`` is JSON, ``text`` a sentence for people, ``id`` its number there, 0: none."""

    stamp: float
    kind: str
    subject: str
    text: str
    data: str
    id: int = 0


@dataclass(frozen=True, slots=True)
class LogLine:
    """One line of the program's log: ``level`` as in ``logging`` (10 debug … 50 critical), ``source`` its logger."""

    stamp: float
    level: int
    source: str
    text: str


@dataclass(frozen=True, slots=True)
class RecorderStatus:
    """What the Recorder does, each second and at every change.

    ``state``: ``idle``; ``recording`` into one file; ``ring`` (the last minutes are kept); ``stopped`` by itself
    though still desired (``reason`` says why: disk full, disk too slow). ``name`` is the recording's, "" while idle.
    ``duration_s``, ``bytes`` and ``messages`` are those of the file, or of what the ring holds now.
    ``dropped`` messages could not be queued for the disk; ``queued_bytes`` wait for it now.
    """

    stamp: float
    state: RecorderState
    name: str
    began: float
    duration_s: float
    bytes: int
    messages: int
    dropped: int
    queued_bytes: int
    reason: str
