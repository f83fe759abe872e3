"""Playing a recording for people who watch: play, pause, speed, seek, step; the console works on it meanwhile."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterable, Sequence, Set
from contextlib import ExitStack
from functools import partial
from typing import Any, TypeVar

from app.attention.intention import Intention
from app.logs.log import Log, LogError, LogInfo
from app.logs.mcap.damage import LogDamaged, missing
from app.logs.replay.playback_state import Phase, PlaybackState, checked_speed
from app.logs.replay.replay_body import ReplayBody
from app.logs.replay.seek import Places
from app.program.system import System
from app.runtime.channel import Channel
from app.runtime.filter import CLOSED
from app.runtime.replay_clock import ReplayClock

T = TypeVar("T")

log = logging.getLogger("hbba.playback")


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
        self._end = min(log.info.end, clock.end)
        self._places = Places(system, body, clock, log)
        self._speed = checked_speed(speed)
        self._playing = playing
        self._ended = False
        self._problem = ""
        self._target: float | None = None
        #: At what rate time passes, but while the body waits for the file.
        self._rate = 0.0
        self._body_waits = False
        self._jumping = False
        self._waiting: list[asyncio.Future[None]] = []
        self._steps: list[asyncio.Future[None]] = []
        #: Channels that somebody began to want while time stands.
        self._unseen: set[str] = set()
        #: Latched channels that somebody began to want: what they said last, perhaps long ago, still holds.
        self._recalled: set[str] = set()
        self._changed = asyncio.Event()
        self._watching = ExitStack()
        self._opened: Set[str] = frozenset()
        self._observers: list[Callable[[PlaybackState], None]] = []
        self._jump_observers: list[Callable[[float], None]] = []
        self._driver: asyncio.Task[None] | None = None

    # --- Life --------------------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Playback:
        """Begin to play. The program (:attr:`system`) must be running; the scene where it begins is shown at once."""
        self._places.open()
        if self._clock.now() > self._info.begin:
            self._target = self._clock.now()
        self._body.on_waiting = self._on_waiting
        self._body_waits = self._body.reading
        self._body.survives = True
        self._body.on_damage = self._on_damage
        for damage in self._body.damages:
            self._on_damage(damage)
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
        self._body.on_damage = lambda _: None
        self._clock.run(0)
        self._watching.close()
        if self._driver is not None:
            self._driver.cancel()
            await asyncio.wait({self._driver})
        await self._places.close()
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
            min(max(position, self._info.begin), self._end),
            self._info.begin,
            end=self._end,
            speed=self._speed,
            playing=self._playing,
            phase=phase,
            problem=self._problem,
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
        return self._places.moving

    @property
    def attention(self) -> Sequence[Any]:
        """What the recording tells of its attention in the minute before the last jump: DesiresRecord, IntentionRecord
        and Divisors in their order, first those that stood when that minute began."""
        return self._places.attention

    def spoke(self, channel: str, begin: float, end: float) -> bool:
        """Whether ``channel`` said anything from ``begin`` to ``end`` (s), in the minute before the last jump.

        True where the recording cannot tell without being gone through.
        """
        if (spoken := self._places.spoken) is None:
            return True
        return any(first <= end and last >= begin for first, last in spoken.get(channel, ()))

    # --- What it can be told -----------------------------------------------------------------------------------------

    def play(self) -> None:
        """Go on, behind what cannot be read here; from the end, begin again."""
        self._problem = ""
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
        What stood before a damaged part is shown within it, and it stands there (``problem``). Raises LogError where
        the recording cannot be read at all; playback stays where it was.
        """
        self._check_alive()
        self._problem = ""
        self._target = min(max(position, self._info.begin), self._end)
        await self._done(self._waiting)

    async def step(self) -> None:
        """On to the next image of the first camera, where there is none the next scan, else 0.1 s; then stand.

        Raises LogError where the recording cannot be read.
        """
        self._check_alive()
        self._problem = ""
        self._playing = False
        await self._done(self._steps)

    async def _done(self, asked: list[asyncio.Future[None]]) -> None:
        """Ask for what ``asked`` is the list of, and wait until it is done."""
        done: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        asked.append(done)
        self._tell()
        await done

    def _check_alive(self) -> None:
        """Raise LogError where nobody would do it any more."""
        driver = self._driver
        if driver is not None and driver.done() and not driver.cancelled():
            raise LogError(f"playback failed: {driver.exception()}")

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

    def _on_damage(self, damage: LogDamaged) -> None:
        """Stand before what is missing, so that nobody takes it for a pause of the robot."""
        self._problem = missing(damage, self._info)
        log.warning("%s: %s", self._info.path.name, self._problem)
        self._playing = False
        self._tell()

    async def _drive(self) -> None:
        self._tell()
        while True:
            self._changed.clear()
            if self._target is not None:
                await self._seek_once()
            elif self._steps:
                await self._step_once()
            elif self._recalled:
                await self._recall()
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
        end = asyncio.create_task(self._clock.sleep_until(self._end), name="recording ends")
        said = asyncio.create_task(self._changed.wait(), name="playback changes")
        try:
            await asyncio.wait({end, said}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            end.cancel()
            said.cancel()
        await self._come_to_the_end()

    async def _advance(self) -> None:
        """Move time on by hand to the next thing that waits for it, once nothing is left to be done now."""
        await self._places.quiet()
        if self._changed.is_set():
            return
        self._clock.advance_to(self._next_due())
        await self._come_to_the_end()

    async def _come_to_the_end(self) -> None:
        if self._clock.now() >= self._end:
            # What came last is worked on before it is over.
            await self._places.worked()
            self._end_if_there()

    def _next_due(self) -> float:
        due = self._clock.next_due
        return self._end if due is None else min(due, self._end)

    def _end_if_there(self) -> None:
        if self._clock.now() >= self._end and self._target is None and not self._ended:
            self._ended = True
            self._playing = False
            self._tell()

    async def _step_once(self) -> None:
        done = self._steps[0]
        try:
            until = min(await self._places.next_step(), self._end)
            while self._target is None and self._clock.now() < until:
                await self._places.quiet()
                self._clock.advance_to(min(self._next_due(), until))
            # What came then is worked on before anybody is told.
            await self._places.worked()
        except LogError as failure:
            _fail([done], failure)
        else:
            _finish([done])
        self._steps.remove(done)
        self._end_if_there()
        self._tell()

    # --- Place -------------------------------------------------------------------------------------------------------

    async def _seek_once(self) -> None:
        """Go to the newest target; one that comes meanwhile is gone to next."""
        position = self._target
        assert position is not None
        self._jumping = True
        failure: LogError | None = None
        try:
            await self._places.go(position, self._jumped)
        except LogError as error:
            log.error("cannot go to %.3f s: %s", position - self._info.begin, error)
            failure = error
        finally:
            self._jumping = False
        if self._target == position:
            # Of several in a row only the newest counts: whoever asked before waited for this one.
            self._target = None
            waiting, self._waiting = self._waiting, []
            if failure is None:
                _finish(waiting)
            else:
                _fail(waiting, failure)
        self._end_if_there()
        self._tell()

    def _jumped(self, position: float) -> None:
        self._ended = False
        for observer in tuple(self._jump_observers):
            observer(position)

    def _want(self, channels: Set[str]) -> None:
        """Somebody begins to listen to ``channels``; while time stands, nothing of them would come."""
        if channels and not self._jumping and (self._ended or not self._playing):
            self._unseen |= channels
            self._changed.set()

    def _want_one(self, channel: str, wanted: bool) -> None:
        self._want({channel} if wanted else frozenset())
        latched = self.system.graph.specs[channel].latched
        if wanted and latched and channel not in self._unseen and not self._jumping:
            self._recalled.add(channel)
            self._changed.set()

    def _on_intention(self, intention: Intention) -> None:
        opened = {name for name, divisor in intention.divisors.items() if divisor != CLOSED}
        newly, self._opened = opened - self._opened, opened
        inputs = self.system.graph.inputs()
        self._want({inputs[name] for name in newly if name in inputs} & self._info.channels.keys())

    async def _show_unseen(self) -> None:
        """Show who came while time stands what there is to be seen."""
        await self._places.quiet()
        channels, self._unseen = self._unseen, set()
        try:
            # Once it moves, more comes by itself.
            await self._places.show(channels, lambda: self._playing or bool(self._steps) or self._target is not None)
        except LogError as failure:
            log.error("cannot show what stands here: %s", failure)

    async def _recall(self) -> None:
        """Say again what latched channels said last, unless they say something themselves meanwhile."""
        channels, self._recalled = self._recalled, set()
        for name in channels:
            channel = self.system.graph.channels[name]
            try:
                await self._places.show({name}, partial(self._has_said_more, channel, channel.published))
            except LogError as failure:
                log.error("cannot show what stands here: %s", failure)

    def _has_said_more(self, channel: Channel[Any], said: int) -> bool:
        return channel.published != said or self._target is not None


def _listed(observers: list[T], callback: T) -> Callable[[], None]:
    observers.append(callback)

    def end() -> None:
        if callback in observers:
            observers.remove(callback)

    return end


def _finish(futures: Iterable[asyncio.Future[None]]) -> None:
    for future in futures:
        if not future.done():
            future.set_result(None)


def _fail(futures: Iterable[asyncio.Future[None]], failure: LogError) -> None:
    for future in futures:
        if not future.done():
            future.set_exception(LogError(str(failure)))
