"""The report of a recording's playback for REST and the live stream."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.console.records.recordings import PlaybackReport
from app.runtime.clock import Clock
from app.runtime.replay_clock import ReplayClock

if TYPE_CHECKING:
    from app.logs.replay.playback import Playback

#: While it plays, its position is sent this often (s, real).
PERIOD_S = 0.1


def playback_report(playback: Playback) -> PlaybackReport:
    """State of the playback; stamps are the recording's."""
    state = playback.state
    return PlaybackReport(
        file=playback.info.path.name,
        begin=state.begin,
        end=state.end,
        position=state.position,
        speed=state.speed,
        playing=state.playing,
        phase=state.phase,
        problem=state.problem or None,
    )


def rate(clock: Clock) -> float:
    """How many seconds of ``clock`` pass in a real one, at least 1: what the computer's hiccups must be measured by."""
    return max(1.0, clock.rate) if isinstance(clock, ReplayClock) else 1.0
