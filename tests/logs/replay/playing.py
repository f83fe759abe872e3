"""A recording played on a real loop, for tests."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from app.logs.log import Log
from app.logs.replay.options import ReplayOptions
from app.logs.replay.playback import Playback
from app.logs.replay.playback_state import PlaybackState
from app.logs.replay.replay import Replay
from app.runtime.replay_clock import ReplayClock
from tests.patience import PATIENCE_S


@dataclass
class Played:
    """A recording at play, and what it said of itself."""

    playback: Playback
    replay: Replay
    clock: ReplayClock
    states: list[PlaybackState]
    jumps: list[float]

    async def phase(self, phase: str) -> PlaybackState:
        """Wait until it is in ``phase``."""
        return await self._until(lambda state: state.phase == phase)

    async def problem(self) -> PlaybackState:
        """Wait until it has a problem."""
        return await self._until(lambda state: state.problem != "")

    async def _until(self, so: Callable[[PlaybackState], bool]) -> PlaybackState:
        async with asyncio.timeout(PATIENCE_S):
            while not so(state := self.playback.state):
                changed = asyncio.Event()
                end = self.playback.observe(lambda _, changed=changed: changed.set())  # type: ignore[misc]
                await changed.wait()
                end()
        return state


def prepare(log: Log, options: ReplayOptions | None = None) -> tuple[Log, ReplayClock, Replay]:
    """What is to be played; off the loop, since it reads files."""
    clock = ReplayClock(log.info.begin, log.info.end)
    return log, clock, Replay(log, clock, options)


@asynccontextmanager
async def played(
    prepared: tuple[Log, ReplayClock, Replay],
    *,
    playing: bool = False,
    speed: float | None = 1.0,
    past: Log | None = None,
) -> AsyncIterator[Played]:
    """Play it; ``past`` is the log's other handle, where it needs one."""
    log, clock, replay = prepared
    async with (
        replay,
        Playback(replay.system, replay.body, clock, past or log, playing=playing, speed=speed) as playback,
    ):
        play = Played(playback, replay, clock, [], [])
        playback.observe(play.states.append)
        playback.on_jump(play.jumps.append)
        yield play
