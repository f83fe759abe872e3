"""Playing a recording for people who watch: play, pause, speed, seek, step; the console works on it meanwhile."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Coroutine, Iterable, Set
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, Protocol, TypeVar

from app.attention.intention import Intention
from app.link import RobotLink
from app.messages import (
    DesiresRecord,
    Divisors,
    EventRecord,
    Image,
    IntentionRecord,
    LaserScan,
    LogLine,
    OperatorDrive,
    Twist,
)
from app.recording.log import Log, LogError, Logged, LogInfo
from app.replay.past import ACCUMULATED, Past
from app.runtime.filter import CLOSED
from app.runtime.replay_clock import ReplayClock
from app.system import System

T = TypeVar("T")

Phase = Literal["playing", "paused", "ended", "seeking"]

SLOWEST = 0.1
FASTEST = 20.0
#: These were meant for their moment: what was commanded or noted long ago is not said again at a jump.
OF_THE_MOMENT = (OperatorDrive, Twist, EventRecord, LogLine)
#: What a recording tells of its attention; and for how long (s) before a jump it is told again.
OF_ATTENTION = (DesiresRecord, IntentionRecord, Divisors)
ATTENTION_S = 60.0
#: A step where the recording has neither images nor scans.
STEP_S = 0.1
#: After a jump, modules get this long (real s) to start, and then to work on what they are shown.
START_WITHIN_S = 2.0
SHOW_WITHIN_S = 0.3
#: While the body reads, it is asked so often (s) whether it is done.
_READ_AGAIN_S = 0.001

log = logging.getLogger("hbba.playback")


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

    #: Called with True when it must wait for the file, with False when it goes on: time waits with it.
    on_waiting: Callable[[bool], None]

    @property
    def listened(self) -> Set[str]:
        """The channels of the log that somebody wants now."""
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
    """Drives the clock, the body and the program that relives the recording: ``async with playback`` while it runs.

    ``log`` is a handle of the recording of its own, besides the body's: it is read in another thread, and not closed.
    """

    def __init__(
        self,
        system: System,
        body: ReplayBody,
        clock: ReplayClock,
        log: Log,
        *,
        speed: float | None = 1.0,
        playing: bool = True,
    ) -> None:
        """``speed`` and ``playing`` are how it begins, where the clock stands. Raises ValueError for such a speed."""
        self.system = system
        self._body = body
        self._clock = clock
        self._info = log.info
        self._past = Past(log)
        self._speed = checked_speed(speed)
        self._playing = playing
        self._ended = False
        self._target: float | None = None
        #: At what rate time passes, but while the body waits for the file.
        self._rate = 0.0
        #: What the recording tells of its attention in the minute before the last jump: the messages of
        #: ``OF_ATTENTION``, in order, from those that stood when that minute began.
        self.attention: list[Any] = []
        self._body_waits = False
        self._jumping = False
        self._moving = False
        self._waiting: list[asyncio.Future[None]] = []
        self._steps: list[asyncio.Future[None]] = []
        #: Channels that somebody began to want while time stands.
        self._unseen: set[str] = set()
        self._changed = asyncio.Event()
        self._watching = ExitStack()
        self._opened: Set[str] = frozenset()
        self._observers: list[Callable[[PlaybackState], None]] = []
        self._jump_observers: list[Callable[[float], None]] = []
        self._reader: ThreadPoolExecutor | None = None
        self._driver: asyncio.Task[None] | None = None

    # --- Life --------------------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Playback:
        """Begin to play. The program (:attr:`system`) must be running; the scene where it begins is shown at once."""
        self._reader = ThreadPoolExecutor(1, thread_name_prefix="playback reader")
        if self._clock.now() > self._info.begin:
            self._target = self._clock.now()
        self._body.on_waiting = self._on_waiting
        self._body_waits = self._body.reading
        for name in self._info.channels.keys() & self.system.graph.channels.keys():
            wanted = partial(self._want_one, name)
            self._watching.callback(self.system.graph.channels[name].on_wanted(wanted))
        self._watching.callback(self.system.translator.observe(self._on_intention))
        self._unseen.clear()
        self._driver = asyncio.create_task(self._drive(), name="playback")
        self._driver.add_done_callback(self._driver_ended)
        return self

    async def __aexit__(self, *_: object) -> None:
        """Stand still; the log may be closed then."""
        self._body.on_waiting = lambda _: None
        self._clock.run(0)
        self._watching.close()
        if self._driver is not None:
            self._driver.cancel()
            await asyncio.wait({self._driver})
        if self._reader is not None:
            await asyncio.get_running_loop().run_in_executor(None, self._reader.shutdown)
        for future in (*self._waiting, *self._steps):
            future.cancel()

    # --- What it is --------------------------------------------------------------------------------------------------

    @property
    def info(self) -> LogInfo:
        """What is played."""
        return self._info

    @property
    def state(self) -> PlaybackState:
        """Where it is now."""
        phase: Phase
        if self._target is not None or self._jumping:
            phase = "seeking"
        elif self._ended:
            phase = "ended"
        else:
            phase = "playing" if self._playing else "paused"
        position = self._target if self._target is not None else self._clock.now()
        return PlaybackState(
            min(max(position, self._info.begin), self._info.end),
            self._info.begin,
            self._info.end,
            self._speed,
            self._playing,
            phase,
        )

    def observe(self, callback: Callable[[PlaybackState], None]) -> Callable[[], None]:
        """Call ``callback(state)`` at every change but the mere passing of time; returns what ends it."""
        return _listed(self._observers, callback)

    def on_jump(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call ``callback(position)`` at every jump, when everything before it is forgotten and before anything of
        the new place is shown; returns what ends it."""
        return _listed(self._jump_observers, callback)

    @property
    def moving(self) -> bool:
        """Whether it is just between two places: from the end of all modules until the jump is told."""
        return self._moving

    # --- What it can be told -----------------------------------------------------------------------------------------

    def play(self) -> None:
        """Go on; from the end, begin again."""
        if self._ended and self._target is None:
            self._target = self._info.begin
        self._playing = True
        self._tell()

    def pause(self) -> None:
        """Stand still."""
        self._playing = False
        self._tell()

    def set_speed(self, speed: float | None) -> None:
        """Seconds of the recording in a real second, 0.1 to 20; None: as fast as possible with nothing dropped.

        Raises ValueError saying what is allowed.
        """
        self._speed = checked_speed(speed)
        self._tell()

    async def seek(self, position: float) -> None:
        """Be at ``position`` (robot's clock, s; beyond an end: at that end), playing or standing as before.

        Returns once the scene there is shown, or that of a newer seek: of several in a row only the newest counts.
        Raises LogError where the recording cannot be read; playback stays where it was.
        """
        self._target = min(max(position, self._info.begin), self._info.end)
        done: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.append(done)
        self._tell()
        await done

    async def step(self) -> None:
        """On to the next image of the first camera, where there is none the next scan, else 0.1 s; then stand.

        Raises LogError where the recording cannot be read.
        """
        self._playing = False
        done: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._steps.append(done)
        self._tell()
        await done

    # --- Time --------------------------------------------------------------------------------------------------------

    def _tell(self) -> None:
        """Something changed: have time pass as it should from now on, and say so."""
        free = self._target is None and not self._jumping and not self._steps and not self._ended
        self._rate = self._speed if free and self._playing and self._speed is not None else 0.0
        self._run()
        if free and self._playing:
            self._unseen.clear()
        self._changed.set()
        state = self.state
        for observer in tuple(self._observers):
            observer(state)

    def _run(self) -> None:
        rate = 0.0 if self._body_waits else self._rate
        if rate != self._clock.rate:
            self._clock.run(rate)

    def _on_waiting(self, waits: bool) -> None:
        self._body_waits = waits
        self._run()

    async def _drive(self) -> None:
        self._tell()
        while True:
            self._changed.clear()
            if self._target is not None:
                await self._seek_once()
            elif self._steps:
                await self._step_once()
            elif self._playing and not self._ended:
                await (self._advance() if self._speed is None else self._pass())
            elif self._unseen:
                await self._show_unseen()
            else:
                await self._changed.wait()

    def _driver_ended(self, driver: asyncio.Task[None]) -> None:
        if not driver.cancelled() and (failure := driver.exception()) is not None:
            log.critical("playback failed; start the replay anew", exc_info=failure)
            _fail([*self._waiting, *self._steps], LogError(f"playback failed: {failure}"))

    async def _pass(self) -> None:
        """Let time pass by itself until something is said or the end is reached."""
        end = asyncio.create_task(self._clock.sleep_until(self._info.end), name="recording ends")
        said = asyncio.create_task(self._changed.wait(), name="playback changes")
        try:
            await asyncio.wait({end, said}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            end.cancel()
            said.cancel()
        self._end_if_there()

    async def _advance(self) -> None:
        """Move time on by hand to the next thing that waits for it, once nothing is left to be done now."""
        await self._quiet()
        if self._changed.is_set():
            return
        self._clock.advance_to(self._next_due())
        self._end_if_there()

    def _next_due(self) -> float:
        due = self._clock.next_due
        return self._info.end if due is None else min(due, self._info.end)

    def _end_if_there(self) -> None:
        if self._clock.now() >= self._info.end and self._target is None and not self._ended:
            self._ended = True
            self._playing = False
            self._tell()

    async def _quiet(self) -> None:
        """Wait until everybody waits: for time, or for somebody outside."""
        activity, translator = self.system.graph.activity, self.system.translator
        while True:
            await translator.settled()
            await activity.quiet()
            if self._body.reading:
                await asyncio.sleep(_READ_AGAIN_S)
            elif translator.is_settled:
                return

    async def _step_once(self) -> None:
        done = self._steps[0]
        try:
            until = min(await self._read(self._next_step, self._clock.now()), self._info.end)
            while self._target is None and self._clock.now() < until:
                await self._quiet()
                self._clock.advance_to(min(self._next_due(), until))
            # What came then is worked on before anybody is told.
            await _patiently(self._quiet(), SHOW_WITHIN_S)
        except LogError as failure:
            _fail([done], failure)
        else:
            _finish([done])
        self._steps.remove(done)
        self._end_if_there()
        self._tell()

    def _next_step(self, position: float) -> float:
        for kind in (Image, LaserScan):
            for name, channel in self._info.channels.items():
                if channel.message_type is kind and channel.count:
                    later = self._past.next_at(name, position)
                    return self._info.end if later is None else later
        return position + STEP_S

    # --- Place -------------------------------------------------------------------------------------------------------

    async def _seek_once(self) -> None:
        """Go to the newest target; one that comes meanwhile is gone to next."""
        assert self._target is not None
        position, waiting, self._waiting = self._target, self._waiting, []
        self._jumping = True
        failure: LogError | None = None
        try:
            await self._go(position)
        except LogError as error:
            log.error("cannot go to %.3f s: %s", position - self._info.begin, error)
            failure = error
        finally:
            self._jumping = False
        if self._target == position:
            self._target = None
        if failure is not None:
            _fail(waiting, failure)
        elif self._target is None:
            _finish(waiting)
        else:
            # Of several in a row only the newest counts: whoever asked before waits for that one.
            self._waiting = [*waiting, *self._waiting]
        self._end_if_there()
        self._tell()

    async def _go(self, position: float) -> None:
        system, body = self.system, self._body
        # Read before anything is ended: where the recording cannot be read, all stays as it is.
        known, wishes, attention = await self._read(self._standing, position)
        self._moving = True
        try:
            await system.begin_anew(lambda: self._jump(position, known))
            await _patiently(system.supervisor.started(), START_WITHIN_S)
            for logged in wishes:
                body.show(logged.channel, logged.message)
            # What is wanted there decides what is shown there; how attention came to it is no event of the recording.
            await _patiently(system.translator.settled(), START_WITHIN_S)
            system.timeline.clear()
            self.attention = attention
        finally:
            self._moving = False
        for observer in tuple(self._jump_observers):
            observer(position)
        for logged in await self._read(lambda at: self._scene(at, self._info.channels.keys()), position):
            body.show(logged.channel, logged.message)
        await _patiently(self._quiet(), SHOW_WITHIN_S)

    def _want(self, channels: Set[str]) -> None:
        """Somebody begins to listen to ``channels``; while time stands, nothing of them would come."""
        if channels and not self._jumping:
            self._unseen |= channels
            self._changed.set()

    def _want_one(self, channel: str, wanted: bool) -> None:
        self._want({channel} if wanted else frozenset())

    def _on_intention(self, intention: Intention) -> None:
        opened = {name for name, divisor in intention.divisors.items() if divisor != CLOSED}
        newly, self._opened = opened - self._opened, opened
        inputs = self.system.graph.inputs()
        self._want({inputs[name] for name in newly if name in inputs} & self._info.channels.keys())

    async def _show_unseen(self) -> None:
        """Show who came while time stands what there is to be seen."""
        await self._quiet()
        channels, self._unseen = self._unseen, set()
        try:
            scene = await self._read(lambda position: self._scene(position, channels), self._clock.now())
        except LogError as failure:
            log.error("cannot show what stands here: %s", failure)
            return
        # Once it moves, more comes by itself.
        if not self._playing and not self._steps and self._target is None:
            for logged in scene:
                self._body.show(logged.channel, logged.message)

    def _jump(self, position: float, known: list[Logged]) -> None:
        self._ended = False
        self._clock.jump(position)
        self._body.seek(position)
        channels = self.system.graph.channels
        for logged in known:
            channel = channels.get(logged.channel)
            if channel is not None and channel.message_type is type(logged.message):
                channel.publish(logged.message)

    def _standing(self, position: float) -> tuple[list[Logged], list[Logged], list[Any]]:
        """What modules that begin at ``position`` must know at once, what was desired there, and attention before."""
        past = self._past
        attention = [logged.message for logged in past.since(position - ATTENTION_S, position, OF_ATTENTION)]
        return past.of_types(ACCUMULATED, position), past.of_types((DesiresRecord,), position), attention

    def _scene(self, position: float, channels: Set[str]) -> list[Logged]:
        shown = {c.name for c in self._info.channels.values() if c.message_type not in (DesiresRecord, *OF_THE_MOMENT)}
        return self._past.scene(position, self._body.listened & shown & channels)

    async def _read(self, function: Callable[[float], T], position: float) -> T:
        assert self._reader is not None
        return await asyncio.get_running_loop().run_in_executor(self._reader, function, position)


def checked_speed(speed: float | None) -> float | None:
    """``speed`` if it may be. Raises ValueError saying what is allowed."""
    if speed is not None and not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"a speed is from {SLOWEST:g} to {FASTEST:g}, or none for as fast as possible, not {speed!r}")
    return speed


def _listed(observers: list[T], callback: T) -> Callable[[], None]:
    observers.append(callback)

    def end() -> None:
        if callback in observers:
            observers.remove(callback)

    return end


async def _patiently(waiting: Coroutine[Any, Any, None], within_s: float) -> None:
    """Wait, but no longer than that: what takes longer goes on by itself."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(within_s):
            await waiting


def _finish(futures: Iterable[asyncio.Future[None]]) -> None:
    for future in futures:
        if not future.done():
            future.set_result(None)


def _fail(futures: Iterable[asyncio.Future[None]], failure: LogError) -> None:
    for future in futures:
        if not future.done():
            future.set_exception(LogError(str(failure)))
