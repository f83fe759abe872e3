"""Detects that the event loop is blocked and names the module that blocks it: for people, not for safety.

A thread of this process cannot run while a C call holds the interpreter lock, and reports only afterwards. The guard in
the link's process stops the wheels.
"""

from __future__ import annotations

import asyncio
import logging
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType

from app.runtime.load import CpuMeter

log = logging.getLogger("hbba.watchdog")

LIMIT_S = 0.2
PERIOD_S = 0.05
#: Frames of these folders are the project's own.
PROJECT_ROOTS = (Path(__file__).resolve().parents[1],)
#: The machinery every module is run by; it is named only when nothing above it is the project's.
_MACHINERY = Path(__file__).resolve().parent
#: Frames outside of this one started the loop; they do not cause what the loop runs.
_LOOP_TURN = asyncio.BaseEventLoop._run_once.__code__  # type: ignore[attr-defined]  # not in typeshed


@dataclass(frozen=True, slots=True)
class Blockage:
    """A blockage of the event loop: reported once when it is noticed, and once with its whole length (``over``).

    ``module`` is the one whose step it was, "" for work outside any module. ``where`` is ``file:line in function`` of
    the innermost frame of the project, "" if there is none; ``blocking`` is the innermost frame of all, "" if no Python
    frame ran: the computer had no time for the program, or a C call held the interpreter lock.
    """

    module: str
    where: str
    blocking: str
    lasted_s: float
    over: bool

    def __str__(self) -> str:
        who = self.module or "something outside any module"
        if not self.blocking:
            return (
                f"the event loop was blocked for {self.lasted_s:.2f} s, not by Python code: the computer had no "
                "time for this program, or a call held the interpreter lock"
            )
        place = f" at {self.where}" if self.where else ""
        inner = f" (in {self.blocking})" if self.blocking != self.where else ""
        verb = "blocked" if self.over else "blocks"
        return f"{who} {verb} the event loop{place}{inner} for {self.lasted_s:.2f} s"


@dataclass(frozen=True, slots=True)
class WatchdogStatistics:
    """``beats`` of the loop so far, ``blockages`` over the limit, the ``worst_lateness_s`` and ``last_lateness_s``, and
    the ``total_lateness_s`` of all beats."""

    beats: int
    blockages: int
    worst_lateness_s: float
    last_lateness_s: float
    total_lateness_s: float


class LoopWatchdog:
    """``async with LoopWatchdog(meters):`` watches the running loop from a daemon thread.

    ``meters`` are the modules' CPU meters by name; they know which module's step runs. ``report`` is called in the
    watchdog's thread with each :class:`Blockage`, on entering and when it is over; it must not wait for the loop.
    """

    def __init__(
        self,
        meters: Mapping[str, CpuMeter],
        report: Callable[[Blockage], None] | None = None,
        *,
        limit_s: float = LIMIT_S,
        period_s: float = PERIOD_S,
        roots: tuple[Path, ...] = PROJECT_ROOTS,
    ) -> None:
        self._meters = meters
        self._report = report or _log_blockage
        self._limit_s = limit_s
        self._period_s = period_s
        self._roots = roots
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._loop_thread = 0
        self._due = 0.0
        #: Lateness of beats over the limit that the thread has not reported yet.
        self._late: deque[float] = deque()
        self._beats = self._blockages = 0
        self._worst_s = self._last_s = self._total_s = 0.0

    async def __aenter__(self) -> LoopWatchdog:
        self._loop = asyncio.get_running_loop()
        self._loop_thread = threading.get_ident()
        self._stopping.clear()
        self._next()
        self._thread = threading.Thread(target=self._watch, name="loop watchdog", daemon=True)
        self._thread.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        self._stopping.set()
        if self._timer is not None:
            self._timer.cancel()

    def statistics(self) -> WatchdogStatistics:
        return WatchdogStatistics(self._beats, self._blockages, self._worst_s, self._last_s, self._total_s)

    # --- on the loop ---

    def _next(self) -> None:
        assert self._loop is not None
        self._due = time.monotonic() + self._period_s
        self._timer = self._loop.call_later(self._period_s, self._beat)

    def _beat(self) -> None:
        self._last_s = max(0.0, time.monotonic() - self._due)
        self._worst_s = max(self._worst_s, self._last_s)
        self._total_s += self._last_s
        self._beats += 1
        if self._last_s > self._limit_s:
            self._blockages += 1
            self._late.append(self._last_s)
        self._next()

    # --- in the thread ---

    def _watch(self) -> None:
        caught: Blockage | None = None
        while not self._stopping.wait(self._period_s):
            if self._late:
                lasted_s = self._late.popleft()
                seen = caught or Blockage("", "", "", 0.0, False)
                caught = None
                self._report(Blockage(seen.module, seen.where, seen.blocking, lasted_s, True))
            elif caught is None and (late_s := time.monotonic() - self._due) > self._limit_s:
                caught = self._look(late_s)
                if caught is not None:
                    self._report(caught)

    def _look(self, late_s: float) -> Blockage | None:
        # The meters are read first: they name the module of this moment; the stack is read a moment later.
        module = next((name for name, meter in self._meters.items() if meter.stepping), "")
        frame = sys._current_frames().get(self._loop_thread)
        frames = list(_outwards(frame))
        if not frames:
            return None
        own = [f for f in frames if any(_inside(f[0], root) for root in self._roots)]
        blamed = next((f for f in own if not _inside(f[0], _MACHINERY)), own[0] if own else None)
        return Blockage(module, _place(blamed) if blamed else "", _place(frames[0]), late_s, over=False)


def _outwards(frame: FrameType | None) -> Iterator[tuple[CodeType, int]]:
    """The frames of what the loop runs, from the innermost out; none if the loop itself waits (for its CPU, then)."""
    while frame is not None and frame.f_code is not _LOOP_TURN:
        if frame.f_back is not None and frame.f_back.f_code is _LOOP_TURN and frame.f_code.co_name == "select":
            return
        yield frame.f_code, frame.f_lineno
        frame = frame.f_back


def _inside(code: CodeType, folder: Path) -> bool:
    return Path(code.co_filename).is_relative_to(folder)


def _place(frame: tuple[CodeType, int]) -> str:
    code, line = frame
    path = Path(code.co_filename)
    name = next((path.relative_to(root.parent) for root in PROJECT_ROOTS if path.is_relative_to(root)), path)
    return f"{name}:{line} in {code.co_name}"


def _log_blockage(blockage: Blockage) -> None:
    log.log(logging.INFO if blockage.over else logging.ERROR, "%s", blockage)
