"""Moves a running program to any position of its recording, with the state of that position."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Coroutine, Set
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from app.logs.log import Log, Logged
from app.logs.replay.state_at import ACCUMULATED, RecordedState
from app.messages import (
    Audio,
    Desires,
    Image,
    Lanes,
    LaserScan,
    LogLine,
    LoudNoise,
    PerceptEvent,
    SeparatedSound,
    TeleopCommand,
    TimelineEvent,
    Twist,
)
from app.program.system import System
from app.robots.replayed.link import ReplayedLink
from app.runtime.replay_clock import ReplayClock

T = TypeVar("T")

#: Messages of a moment: commands, events and sounds are not published again at a jump. A frame of sound alone is a
#: click, which a detector of noises would report.
OF_THE_MOMENT = (TeleopCommand, Twist, TimelineEvent, LogLine, Audio, SeparatedSound, LoudNoise, PerceptEvent)
#: The time (s) before a jump of which recorded lanes are read, and the period (s) between two.
LANES_S = 60.0
LANES_PERIOD_S = 0.5
#: A step where the recording has neither images nor scans.
STEP_S = 0.1
#: After a jump, modules get this long (real s) to start, and then to process the messages shown.
START_WITHIN_S = 2.0
SHOW_WITHIN_S = 0.3
#: While the body reads, it is asked so often (s) whether it is done.
_READ_AGAIN_S = 0.001


class ReplaySeeker:
    """Call :meth:`open` first, :meth:`close` at the end. ``log`` is read in a thread of its own."""

    def __init__(self, system: System, body: ReplayedLink, clock: ReplayClock, log: Log) -> None:
        self._system = system
        self._body = body
        self._clock = clock
        self._info = log.info
        self._past = RecordedState(log)
        self._reader: ThreadPoolExecutor | None = None
        #: True during a jump: from the stop of all modules until observers of the jump are notified.
        self.moving = False
        #: The recorded lanes of the minute before the last jump, two a second, in order.
        self.lanes: list[Lanes] = []

    def open(self) -> None:
        """Be ready to read."""
        self._reader = ThreadPoolExecutor(1, thread_name_prefix="playback reader")

    async def close(self) -> None:
        """Stop reading; the log may be closed then."""
        if self._reader is not None:
            await asyncio.get_running_loop().run_in_executor(None, self._reader.shutdown)

    async def go(self, position: float, jumped: Callable[[float], None]) -> None:
        """Restart every module at ``position`` (s) and publish the state there; the clock must be paused.

        ``jumped`` is called when all former state is cleared, before anything of the new position is published. Raises
        LogError; if the position cannot be read, nothing changes.
        """
        system, body = self._system, self._body
        known, wishes, lanes = await self._read(self._standing, position)
        self.moving = True
        try:
            await system.reset(lambda: self._jump(position, known))
            await _patiently(system.supervisor.started(), START_WITHIN_S)
            for logged in wishes:
                body.show(logged.channel, logged.message)
            # Desires at the position decide which channels are shown; how attention reaches its selection is no
            # recorded event.
            await _patiently(system.translator.settled(), START_WITHIN_S)
            system.timeline.clear()
            self.lanes = lanes
        finally:
            self.moving = False
        jumped(position)
        await self.show(self._info.channels.keys())
        await self.worked()

    async def show(self, channels: Set[str], unless: Callable[[], bool] = lambda: False) -> None:
        """Publish the last message of ``channels`` that are wanted, ``unless`` that returns True meanwhile.

        Raises LogError.
        """
        for logged in await self._read(lambda position: self._scene(position, channels), self._clock.now()):
            if not unless():
                self._body.show(logged.channel, logged.message)

    async def next_step(self) -> float:
        """When the next image of the first camera arrived, or the next scan, or in 0.1 s; never beyond the recording.

        Raises LogError.
        """
        return await self._read(self._next_step, self._clock.now())

    async def quiet(self) -> None:
        """Wait until every task waits for time or for an event from outside."""
        pending, translator = self._system.graph.pending_work, self._system.translator
        while True:
            await translator.settled()
            await pending.quiet()
            if self._body.reading:
                await asyncio.sleep(_READ_AGAIN_S)
            elif translator.is_settled:
                return

    async def worked(self) -> None:
        """Wait, for a limited time, until the messages shown are processed."""
        await _patiently(self.quiet(), SHOW_WITHIN_S)

    def _jump(self, position: float, known: list[Logged]) -> None:
        self._clock.jump(position)
        self._body.seek(position)
        channels = self._system.graph.channels
        for logged in known:
            channel = channels.get(logged.channel)
            if channel is not None and channel.message_type is type(logged.message):
                channel.publish(logged.message)

    def _standing(self, position: float) -> tuple[list[Logged], list[Logged], list[Lanes]]:
        """State that modules need at ``position``, the desires there, and the lanes before."""
        past = self._past
        lanes: list[Lanes] = past.now_and_then(Lanes, position - LANES_S, position, LANES_PERIOD_S)
        return past.of_types(ACCUMULATED, position), past.of_types((Desires,), position), lanes

    def _scene(self, position: float, channels: Set[str]) -> list[Logged]:
        shown = {c.name for c in self._info.channels.values() if c.message_type not in (Desires, *OF_THE_MOMENT)}
        return self._past.scene(position, self._body.listened & shown & channels)

    def _next_step(self, position: float) -> float:
        for kind in (Image, LaserScan):
            for name, channel in self._info.channels.items():
                if channel.message_type is kind and channel.count:
                    later = self._past.next_at(name, position)
                    return self._info.end if later is None else later
        return position + STEP_S

    async def _read(self, function: Callable[[float], T], position: float) -> T:
        assert self._reader is not None
        return await asyncio.get_running_loop().run_in_executor(self._reader, function, position)


async def _patiently(waiting: Coroutine[Any, Any, None], within_s: float) -> None:
    """Wait, but no longer than that: what takes longer goes on by itself."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(within_s):
            await waiting
