"""The supervisor starts modules, watches them, and restarts those that raise or hang, without an effect on the others.

A module that raises is restarted after 0.5 s, 1 s, 2 s ... 30 s (exponential back-off); the delay is reset once it has
run for a minute. A module is *hung* if it takes no message for ``hang_after_s`` while messages wait, if its timer is
not called for ten periods (at least ``hang_after_s``), or if it does not start within ``start_within_s``: it is
reported, cancelled and restarted. While a module is down, its outputs are stale, its inboxes keep what they can hold
and count the rest, and no sender waits for it.
"""

from __future__ import annotations

import asyncio
import logging
import time
import traceback
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from app.base.observers import Observers
from app.messages import ModuleStatus
from app.runtime.clock import Clock
from app.runtime.errors import ModuleFailed
from app.runtime.graph import ModuleSlot
from app.runtime.half_imports import forget_half_imports
from app.runtime.hang_detector import HangDetector, LoopTime
from app.runtime.load import MeteredCoroutine
from app.runtime.worker import ModuleWorker

log = logging.getLogger("hbba.supervisor")

FIRST_DELAY_S = 0.5
LONGEST_DELAY_S = 30.0
#: A module that ran this long without failing is trusted again.
TRUSTED_AFTER_S = 60.0
WATCH_PERIOD_S = 0.1
#: Inboxes and periodic handlers of idle modules that are glanced at each time: all of some hundred modules. Of 2000
#: with an input each, one that hangs is reported up to 0.4 s later.
GLANCE = 1000
#: A cancelled module gets this long to end before its task is left behind.
CANCEL_GRACE_S = 0.5
#: In the end modules' threads get this long for the jobs they are at.
LET_END_S = 0.3

Status = ModuleStatus


@dataclass(frozen=True, slots=True)
class ModuleState:
    """The state of a module: its ``status``, the time of the last change, the number of restarts, and its last problem.

    ``stale``: the module does not run, so its outputs must not be used.
    """

    name: str
    status: Status
    since: float
    restarts: int = 0
    problem: str = ""

    @property
    def stale(self) -> bool:
        """Whether what it last published counts as stale."""
        return self.status != "running"


class _ModuleRun:
    """One run of a module: its task, when it began to serve, and what blocks it."""

    def __init__(self, slot: ModuleSlot, given: float, hung: asyncio.Future[str]) -> None:
        self.slot = slot
        self.began_at = given
        self.serving_since: float | None = None
        self.hung = hung
        self._progress: HangDetector | None = None
        #: While none is true there is nothing to look at; ``wakes`` are those that may become true by themselves.
        self.signs: tuple[Collection[object], ...] = ((self,),)
        self.wakes: tuple[Collection[object], ...] = ()

    def serve(self, now: float, given: float) -> None:
        """Note that it has started: at ``now`` of the robot's clock, ``given`` of the time modules have to work."""
        self.serving_since = now
        inputs = self.slot.context.inputs.values()
        self._progress = HangDetector(inputs, self.slot.module.ticks, self.slot.spec.hang_after_s, given)
        self.signs, self.wakes = self._progress.signs, self._progress.wakes

    def look(self, given: float) -> None:
        """Resolve ``hung`` if the module is."""
        if self._progress is not None:
            stuck = self._progress.look(given)
        else:
            limit_s = self.slot.spec.start_within_s
            stuck = f"did not start within {limit_s:g} s" if given - self.began_at > limit_s else None
        if stuck and not self.hung.done():
            self.hung.set_result(stuck)


class Supervisor:
    """Runs a graph's modules: ``async with supervisor:`` starts them all and stops them all."""

    def __init__(self, slots: Mapping[str, ModuleSlot], clock: Clock, pace: Clock | None = None) -> None:
        """``pace`` is the time that modules get to work in, if it is not ``clock``'s: a recording's clock may be paused
        or run faster than any module."""
        self._slots = slots
        self._clock = clock
        self._pace = pace or clock
        self._given = LoopTime(clock, self._pace)
        self._observers: Observers[[ModuleState]] = Observers("the states of modules")
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._watching: asyncio.Task[None] | None = None
        self._runs: dict[str, _ModuleRun] = {}
        #: Runs that show signs of work, and what may wake the others, by turns; None: to be looked up.
        self._busy: list[_ModuleRun] = []
        self._idle: deque[tuple[Collection[object], ...]] | None = None
        #: Shut down, and at their last job.
        self._leaving: list[ModuleWorker] = []
        self.states = {name: ModuleState(name, "stopped", 0.0) for name in slots}

    def observe(self, callback: Callable[[ModuleState], None]) -> Callable[[], None]:
        """Call ``callback(state)`` at every change of a module's state; returns a function that ends this."""
        return self._observers.add(callback)

    async def __aenter__(self) -> Supervisor:
        self.start_modules()
        self._watching = asyncio.create_task(self._watch(), name="watch modules")
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._watching is not None:
            self._watching.cancel()
            _report_failures(await asyncio.gather(self._watching, return_exceptions=True))
        await self.stop_modules()
        for slot in self._slots.values():
            self._replace_workers(slot)
        # A thread within a library's C++ when the interpreter ends is unwound through it, which aborts the process.
        await asyncio.get_running_loop().run_in_executor(None, _joined, self._leaving, LET_END_S)

    def start_modules(self) -> None:
        """Have every module live, a fresh instance each that counts no restarts."""
        for name, slot in self._slots.items():
            self.states[name] = replace(self.states[name], restarts=0, problem="")
            self._tasks[name] = asyncio.create_task(self._supervise(slot), name=f"supervise {name}")

    async def started(self) -> None:
        """Wait until every module serves, or has failed to start once."""
        waiting = {name for name in self._tasks if self.states[name].status in ("stopped", "starting")}
        changed = asyncio.Event()

        def note(state: ModuleState) -> None:
            if state.status not in ("stopped", "starting"):
                waiting.discard(state.name)
                changed.set()

        end = self.observe(note)
        try:
            while waiting:
                changed.clear()
                await changed.wait()
        finally:
            end()

    async def stop_modules(self) -> None:
        """End every module's life, and wait until nothing of it runs (what does not end is left behind, as ever)."""
        tasks, self._tasks = self._tasks, {}
        for task in tasks.values():
            task.cancel()
        _report_failures(await asyncio.gather(*tasks.values(), return_exceptions=True))

    async def _watch(self) -> None:
        while True:
            given = self._given.now()
            # A glance at idle modules is nearly all that an idle program's watch takes: of thousands, some at a time.
            if self._idle is None or any(self._idle[0]):
                self._busy = [run for run in self._runs.values() if any(run.signs)]
                busy = set(self._busy)
                wakes = [sign for run in self._runs.values() if run not in busy for sign in run.wakes]
                self._idle = deque(tuple(wakes[at : at + GLANCE]) for at in range(0, max(len(wakes), 1), GLANCE))
            self._idle.rotate(-1)
            for run in self._busy:
                run.look(given)
                if not any(run.signs):
                    self._idle = None
            await self._pace.sleep(WATCH_PERIOD_S)

    async def _supervise(self, slot: ModuleSlot) -> None:
        delay = FIRST_DELAY_S
        failed_before = False
        try:
            while True:
                run = _ModuleRun(slot, self._given.now(), asyncio.get_running_loop().create_future())
                status, problem = await self._live(run, failed_before)
                if run.serving_since is not None and self._clock.now() - run.serving_since >= TRUSTED_AFTER_S:
                    delay = FIRST_DELAY_S
                log.error("%s %s: %s; restarting in %g s", slot.name, status, problem, delay)
                if half := forget_half_imports():
                    log.info("forgot %d modules of Python that a failed import left behind", len(half))
                self._change(slot, status=status, problem=problem)
                await self._clock.sleep(delay)
                delay = min(2 * delay, LONGEST_DELAY_S)
                failed_before = True
        finally:
            self._change(slot, status="stopped")

    async def _live(self, run: _ModuleRun, again: bool) -> tuple[Status, str]:
        """Run a module until it ends or hangs and leave nothing of it running; returns how it ended, and why."""
        slot = run.slot
        restarts = self.states[slot.name].restarts + again
        self._change(slot, status="starting", restarts=restarts)
        try:
            module = slot.take()
        except Exception as error:  # noqa: BLE001  # becomes the module's problem
            return "failed", _in_words(error)
        for port, lost in slot.adopt_inputs().items():
            log.warning("%s.%s lost %d messages while the module was down", slot.name, port, lost)

        def started() -> None:
            run.serve(self._clock.now(), self._given.now())
            self._idle = None
            self._change(slot, status="running")
            if again:
                log.info("%s runs again", slot.name)

        life = MeteredCoroutine(module.run(started), slot.context.meter)
        task = asyncio.create_task(life, name=f"module {slot.name}")
        ends: tuple[asyncio.Future[Any], ...] = (task, run.hung)
        self._runs[slot.name] = run
        self._idle = None
        try:
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            if task.done():
                if task.cancelled():
                    return "failed", "was cancelled"
                log.debug("%s failed", slot.name, exc_info=task.exception())
                return "failed", _in_words(task.exception())
            # Set before its task is cancelled, which takes time: from now on its outputs must not be used.
            self._change(slot, status="hung", problem=run.hung.result())
            return "hung", run.hung.result()
        finally:
            del self._runs[slot.name]
            self._idle = None
            slot.leave_inputs()
            await _end(task, slot.name)
            # A thread that is stuck may never come back: the next instance gets a new one.
            self._replace_workers(slot)

    def _replace_workers(self, slot: ModuleSlot) -> None:
        for worker in (slot.context.worker, slot.context.background_worker):
            worker.shutdown(cancel_futures=True)
            self._leaving.append(worker)
        self._leaving = [worker for worker in self._leaving if worker.alive]
        slot.context.worker = ModuleWorker(slot.name)
        slot.context.background_worker = ModuleWorker(f"{slot.name}, background")

    def _change(self, slot: ModuleSlot, *, status: Status, **changes: object) -> None:
        before = self.states[slot.name]
        since = before.since if status == before.status else self._clock.now()
        state = replace(before, status=status, since=since, **changes)  # type: ignore[arg-type]
        if state == before:
            return
        self.states[slot.name] = state
        self._observers.notify(state)


def _report_failures(results: Iterable[object]) -> None:
    for result in results:
        if isinstance(result, Exception):
            log.error("the supervisor itself failed", exc_info=result)


def _joined(workers: Sequence[ModuleWorker], within_s: float) -> None:
    end = time.monotonic() + within_s
    for worker in workers:
        worker.join(end - time.monotonic())


async def _end(task: asyncio.Task[None], name: str) -> None:
    """Cancel ``task`` if it still runs, and see that it ends; one that will not is reported and left behind."""
    if task.done():
        return
    task.cancel()
    await asyncio.wait({task}, timeout=CANCEL_GRACE_S)
    if not task.done():
        log.error("%s does not end %g s after it was cancelled; left behind", name, CANCEL_GRACE_S)
        task.add_done_callback(lambda left: _report_end(left, name))
    else:
        _report_end(task, name)


def _report_end(task: asyncio.Task[None], name: str) -> None:
    if not task.cancelled() and (error := task.exception()) is not None:
        log.error("%s failed while it was stopped: %s", name, _in_words(error))


def _in_words(error: BaseException | None) -> str:
    """Name an error, its message and the line it came from; of several the first."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    if error is None:
        return "ended by itself"
    if isinstance(error, ModuleFailed):
        return str(error)  # written for people
    frames = traceback.extract_tb(error.__traceback__)
    where = f" ({frames[-1].filename.rsplit('/', 1)[-1]}:{frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {error}{where}"
