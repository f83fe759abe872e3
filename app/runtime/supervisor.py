"""Starts modules, watches them, restarts those that raise or hang; the others never notice.

A module that raises is restarted after 0.5 s, 1 s, 2 s ... 30 s; the delay starts afresh once it has run for a
minute. A module that takes nothing for ``hang_after_s`` though messages wait, or whose timer does not come round for
ten periods (at least ``hang_after_s``), is *hung*: reported, abandoned and restarted.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from app.runtime.clock import Clock
from app.runtime.graph import ModuleSlot
from app.runtime.load import MeteredCoroutine
from app.runtime.worker import ModuleWorker

log = logging.getLogger("hbba.supervisor")

FIRST_DELAY_S = 0.5
LONGEST_DELAY_S = 30.0
#: A module that ran this long without failing is trusted again.
TRUSTED_AFTER_S = 60.0
WATCH_PERIOD_S = 0.1
#: A cancelled module gets this long to end before its task is abandoned.
CANCEL_GRACE_S = 0.5

Status = Literal["starting", "running", "failed", "hung", "stopped"]


@dataclass(frozen=True, slots=True)
class ModuleState:
    """How a module is: its ``status``, since when, how often it was restarted, and its last problem in words.

    ``stale`` says that its outputs must not be trusted (it is not running).
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


class ModuleHung(Exception):
    """A module makes no progress; the message says on what."""


class Supervisor:
    """Runs a graph's modules: ``async with supervisor:`` starts them all and stops them all."""

    def __init__(self, slots: Mapping[str, ModuleSlot], clock: Clock) -> None:
        self._slots = slots
        self._clock = clock
        self._observers: list[Callable[[ModuleState], None]] = []
        self._tasks: list[asyncio.Task[None]] = []
        self.states = {name: ModuleState(name, "stopped", 0.0) for name in slots}

    def observe(self, callback: Callable[[ModuleState], None]) -> None:
        """Call ``callback(state)`` at every change of a module's state."""
        self._observers.append(callback)

    async def __aenter__(self) -> Supervisor:
        self._tasks = [
            asyncio.create_task(self._supervise(slot), name=f"supervise {name}") for name, slot in self._slots.items()
        ]
        return self

    async def __aexit__(self, *_: object) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for slot in self._slots.values():
            slot.context.worker.shutdown()

    async def _supervise(self, slot: ModuleSlot) -> None:
        delay = FIRST_DELAY_S
        first = True
        try:
            while True:
                module = slot.module if first else slot.renew()
                first = False
                self._change(slot, status="running", problem=self.states[slot.name].problem)
                began = self._clock.now()
                task = asyncio.create_task(
                    MeteredCoroutine(module.run(), slot.context.meter), name=f"module {slot.name}"
                )
                problem, status = await self._watch(slot, task)
                if self._clock.now() - began >= TRUSTED_AFTER_S:
                    delay = FIRST_DELAY_S
                log.error("%s %s: %s; restarting in %g s", slot.name, status, problem, delay)
                self._change(slot, status=status, problem=problem)
                await self._clock.sleep(delay)
                delay = min(2 * delay, LONGEST_DELAY_S)
                self._change(slot, restarts=self.states[slot.name].restarts + 1)
        finally:
            self._change(slot, status="stopped")

    async def _watch(self, slot: ModuleSlot, task: asyncio.Task[None]) -> tuple[str, Status]:
        """Wait until ``task`` ends or hangs; leave nothing of it running. Returns the problem and what it means."""
        try:
            while True:
                done, _ = await asyncio.wait({task}, timeout=WATCH_PERIOD_S)
                if done:
                    return _why(task), "failed"
                if stuck := stuck_on(slot, self._clock.now()):
                    await _abandon(task)
                    # Its thread may never come back: the next instance gets a new one.
                    slot.context.worker.shutdown()
                    slot.context.worker = ModuleWorker(slot.name)
                    return stuck, "hung"
        except asyncio.CancelledError:
            await _abandon(task)
            raise

    def _change(self, slot: ModuleSlot, **changes: object) -> None:
        before = self.states[slot.name]
        state = replace(before, since=self._clock.now(), **changes)  # type: ignore[arg-type]
        if state == replace(before, since=state.since):
            return
        self.states[slot.name] = state
        for observer in self._observers:
            observer(state)


def stuck_on(slot: ModuleSlot, now: float) -> str | None:
    """What a module makes no progress on, in words, or None: pure, on the slot's own progress stamps."""
    limit = slot.spec.hang_after_s
    for port in slot.context.inputs.values():
        since = port.subscription.busy_since if port.connected else None
        if since is not None and now - since > limit:
            return f"takes nothing from {port.name} for {now - since:.1f} s though messages wait"
    for name, (stamp, period_s) in slot.context.ticks.items():
        if now - stamp > max(10 * period_s, limit):
            return f"its {name} did not come round for {now - stamp:.1f} s"
    return None


async def _abandon(task: asyncio.Task[None]) -> None:
    task.cancel()
    await asyncio.wait({task}, timeout=CANCEL_GRACE_S)


def _why(task: asyncio.Task[None]) -> str:
    if task.cancelled():
        return "was cancelled"
    error = task.exception()
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return f"{type(error).__name__}: {error}" if error is not None else "ended by itself"
