"""Playing a recording for people who watch: play, pause, speed, seek, step; the console works on it meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from app.link import RobotLink
from app.recording.log import Log, LogInfo
from app.runtime.replay_clock import ReplayClock
from app.system import System

Phase = Literal["playing", "paused", "ended", "seeking"]

SLOWEST = 0.1
FASTEST = 20.0


class ReplayBody(RobotLink, Protocol):
    """What playback asks of a body that relives a recording (``app.robots.replayed``), driven by the clock."""

    def seek(self, position: float) -> None:
        """Go on with the first message that arrived after ``position`` (robot's clock, s); emits nothing by itself.

        The clock stands and has been moved to ``position``.
        """
        ...

    def show(self, channel: str, message: Any) -> None:
        """Give ``message``, recorded on ``channel``, to whoever is attached to that channel's stream, now.

        Channels that are no stream of the body are passed over.
        """
        ...

    @property
    def reading(self) -> bool:
        """Whether the next message is still being read: the clock must not be moved on meanwhile.

        False once it sleeps on the clock until that message's time, and at the recording's end.
        """
        ...


@dataclass(frozen=True, slots=True)
class PlaybackState:
    """Where playback is. ``position``, ``begin`` and ``end``: robot's clock (s); ``speed`` None: as fast as possible.

    ``playing``: time goes on now or will after the seek under way.
    """

    position: float
    begin: float
    end: float
    speed: float | None
    playing: bool
    phase: Phase


class Playback:
    """Owns the clock, the body and the program that relives the recording: ``async with playback`` while it runs.

    ``log`` is a handle of the recording of its own, besides the body's: it is read in another thread.
    """

    def __init__(
        self, system: System, body: ReplayBody, clock: ReplayClock, log: Log, *, speed: float | None = 1.0
    ) -> None:
        self.system = system
        self._body = body
        self._clock = clock
        self._log = log
        self._speed = speed

    async def __aenter__(self) -> Playback:
        """Begin to play. The program (:attr:`system`) must be running."""
        raise NotImplementedError

    async def __aexit__(self, *_: object) -> None:
        """Stop; closes the log given."""

    @property
    def info(self) -> LogInfo:
        """What is played."""
        return self._log.info

    @property
    def state(self) -> PlaybackState:
        """Where it is now."""
        raise NotImplementedError

    def observe(self, callback: Callable[[PlaybackState], None]) -> Callable[[], None]:
        """Call ``callback(state)`` at every change but the mere passing of time; returns what ends it."""
        raise NotImplementedError

    def on_jump(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call ``callback(position)`` at every jump, when everything before it is forgotten and before anything of
        the new place is shown; returns what ends it."""
        raise NotImplementedError

    def play(self) -> None:
        """Go on; from the end, begin again."""
        raise NotImplementedError

    def pause(self) -> None:
        """Stand still."""
        raise NotImplementedError

    def set_speed(self, speed: float | None) -> None:
        """Seconds of the recording in a real second, 0.1 to 20; None: as fast as possible with nothing dropped.

        Raises ValueError saying what is allowed.
        """
        raise NotImplementedError

    async def seek(self, position: float) -> None:
        """Be at ``position`` (robot's clock, s; beyond an end: at that end), playing or standing as before.

        Returns once the scene there is shown, or that of a newer seek: of several in a row only the newest counts.
        """
        raise NotImplementedError

    async def step(self) -> None:
        """On to the next image of the first camera, where there is none the next scan, else 0.1 s; then stand."""
        raise NotImplementedError
