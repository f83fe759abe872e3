"""Records of the program about itself. Recorded and replayed as any other message; no module acts on them. A closed
filter's divisor is inf."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Struct

from app.messages.attention import Divisor
from app.messages.base import Stamp, doc

ModuleStatus = Literal["starting", "running", "failed", "hung", "stopped"]
#: The layers of the architecture (thesis, figure 4.2).
ModuleRole = Literal["sensors", "perception", "motivations", "behaviors", "actuation", "other"]
RecorderState = Literal["idle", "recording", "ring", "stopped"]


@dataclass(frozen=True, slots=True)
class Divisors:
    """φ of every filter that attention controls, after a change: ``divisors[i]`` (inf: closed) of ``filters[i]``."""

    stamp: float
    filters: tuple[str, ...]
    divisors: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SubscriptionCounters:
    """The counters of one consumer's end of a channel, since the start."""

    divisor: Divisor
    received: Annotated[int, doc("Messages offered, or left out by the source on behalf of the filters.")]
    passed: Annotated[int, doc("... let through by the filter.")]
    decimated: Annotated[int, doc("... stopped by the filter, or left out, as wanted.")]
    dropped: Annotated[int, doc("... pushed out of a full inbox.")]
    age_ms: Annotated[float | None, doc("Age of the last message when it was taken.")]


@dataclass(frozen=True, slots=True)
class ModuleInput(SubscriptionCounters):
    """A module's input and its counters since the start."""

    name: str
    channel: str


@dataclass(frozen=True, slots=True)
class ModuleOutput:
    """A module's output."""

    name: str
    channel: Annotated[str | None, doc("null: nothing is connected.")]
    divisor: Divisor
    offered: int


@dataclass(frozen=True, slots=True)
class ModuleReport:
    """One module, its load and its counters."""

    name: str
    title: str
    state: ModuleStatus
    cpu: Annotated[float, doc("Per cent of one core, over the last second.")]
    cpu_budget: Annotated[float | None, doc("What it is expected to stay under.")]
    message_cpu_us: Annotated[float | None, doc("CPU time for each message taken (µs).")]
    restarts: int
    problem: str | None
    inputs: tuple[ModuleInput, ...]
    outputs: tuple[ModuleOutput, ...]
    role: Annotated[ModuleRole, doc("Its layer in the architecture, by the package that it comes from.")] = "other"


class StrategyLoad(Struct, frozen=True, rename={"cls": "class"}):
    """CPU of a strategy at work, in per cent of one core."""

    name: str
    cls: str
    declared: Annotated[float, doc("As its file says, or as calibrated on this computer.")]
    measured: Annotated[float | None, doc("Over the last second; null: it was not at work all that time.")]
    estimated: Annotated[float, doc("By all that was measured.")]
    used: Annotated[float, doc("What attention reckons with.")]


@dataclass(frozen=True, slots=True)
class LoopReport:
    """Attention's closed loop: costs follow what is measured, the budget of the CPU the pressure on the computer."""

    budget: Annotated[float, doc("As it was set, in per cent of one core.")]
    share: Annotated[float, doc("What pressure leaves of it, at most 1.")]
    used: Annotated[float, doc("CPU of all modules at work for strategies, measured over the last second.")]
    waiting: Annotated[
        float, doc("Share of the time they wanted in which the program's threads had no core.", nullable=True)
    ]
    room: Annotated[float, doc("Idle time of the program's cores, in per cent of one core.", nullable=True)]
    stalled: Annotated[
        float, doc("Share of the time in which some task of the computer had no core (PSI).", nullable=True)
    ]
    runnable: Annotated[float, doc("Tasks that could run, over those cores.", nullable=True)]
    late_ms: Annotated[float, doc("How late the event loop was on average.", nullable=True)]
    strategies: Annotated[tuple[StrategyLoad, ...], doc("Those at work that take CPU.")]
    why: Annotated[str, doc("Why costs or share changed last, in words; empty: they never did.")] = ""


@dataclass(frozen=True, slots=True)
class LoadReport:
    """What the modules take of the computer, once a second."""

    stamp: Stamp
    window_s: Annotated[float, doc("The time that it was measured over.")]
    process_cpu: Annotated[float, doc("Per cent of one core.")]
    budget: Annotated[float | None, doc("Per cent that attention may give; null: no limit.")]
    modules: tuple[ModuleReport, ...]
    loop: Annotated[LoopReport | None, doc("What attention makes of it; null: its loop is not closed.")] = None


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
