"""Records of the program about itself. Recorded and replayed as any other message; no module acts on them. A closed
filter's divisor is inf."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

RecorderState = Literal["idle", "recording", "ring", "stopped"]


@dataclass(frozen=True, slots=True)
class Divisors:
    """φ of every filter that attention controls, after a change: ``divisors[i]`` (inf: closed) of ``filters[i]``."""

    stamp: float
    filters: tuple[str, ...]
    divisors: tuple[float, ...]


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
