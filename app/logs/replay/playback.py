"""Playback of a recording with a console: play, pause, speed, seek, step."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterable, Sequence, Set
from contextlib import ExitStack
from functools import partial
from typing import Any, TypeVar

from app.attention.intention import Intention
from app.base.observers import Observers
from app.logs.log import Log, LogError
from app.logs.mcap.damage import LogDamaged, missing
from app.logs.replay.playback_state import Phase, PlaybackState, checked_speed
from app.logs.replay.seek import ReplaySeeker
from app.messages import Lanes
from app.program.system import System
from app.robots.replayed.link import ReplayedLink
from app.runtime.channel import Channel
from app.runtime.filter import CLOSED
from app.runtime.replay_clock import ReplayClock

T = TypeVar("T")

log = logging.getLogger("hbba.playback")


class Playback:
    """Drives the clock, the body and the program of a replay: ``async with playback`` while it runs.

    ``log`` is a handle of the recording of its own, besides the body's: it is read in another thread, and not closed.
    """

    def __init__(
        self,
        system: System,
        body: ReplayedLink,
        clock: ReplayClock,
        log: Log,
        *,
        speed: float | None = 1.0,
        playing: bool = True,
    ) -> None:
        """Begins with ``speed`` and ``playing``, at the clock's time. Raises ValueError for an invalid speed."""
        self.system = system
        self._body = body
        self._clock = clock
        self.info = log.info
        self._end = min(log.info.end, clock.end)
        self._seeker = ReplaySeeker(system, body, clock, log)
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
        #: Channels that became wanted while playback is paused.
        self._unseen: set[str] = set()
        #: Latched channels that became wanted: their last message, perhaps of long ago, is still valid.
        self._recalled: set[str] = set()
        self._changed = asyncio.Event()
        self._watching = ExitStack()
        self._opened: Set[str] = frozenset()
        self._observers: Observers[[PlaybackState]] = Observers("playback")
        self._jump_observers: Observers[[float]] = Observers("jumps of playback")
        self._driver: asyncio.Task[None] | None = None

    # --- Life --------------------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Playback:
        """Start playback. The program (:attr:`system`) must be running; the state at the beginning is shown at once."""
        self._seeker.open()
        if self._clock.now() > self.info.begin:
            self._target = self._clock.now()
        self._body.on_waiting = self._on_waiting
        self._body_waits = self._body.reading
        self._body.survives = True
        self._body.on_damage = self._on_damage
        for damage in self._body.damages:
            self._on_damage(damage)
        for name in self.info.channels.keys() & self.system.graph.channels.keys():
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
        await self._seeker.close()
        for future in (*self._waiting, *self._steps):
            future.cancel()

    # --- What it is --------------------------------------------------------------------------------------------------

    @property
    def state(self) -> PlaybackState:
        """The current state of playback."""
        phase: Phase
        if self._target is not None or self._jumping:
            phase = "seeking"
        elif self._ended:
            phase = "ended"
        else:
            phase = "playing" if self._playing else "paused"
        position = self._target if self._target is not None else self._clock.now()
        return PlaybackState(
            min(max(position, self.info.begin), self._end),
            self.info.begin,
            end=self._end,
            speed=self._speed,
            playing=self._playing,
            phase=phase,
            problem=self._problem,
        )

    def observe(self, callback: Callable[[PlaybackState], None]) -> Callable[[], None]:
        """Call ``callback(state)`` at every change but that of the position; returns a function that ends this."""
        return self._observers.add(callback)

    def on_jump(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call ``callback(position)`` at every jump: after all state is cleared, before messages of the new position
        are published. Returns a function that ends this."""
        return self._jump_observers.add(callback)

    @property
    def moving(self) -> bool:
        """Whether a jump is under way: from the stop of all modules until observers of the jump are notified."""
        return self._seeker.moving

    @property
    def lanes(self) -> Sequence[Lanes]:
        """The recorded lanes of the minute before the last jump, two a second; none where none were recorded."""
        return self._seeker.lanes

    # --- Commands -----------------------------------------------------------------------------------------------------

    def play(self) -> None:
        """Go on, behind what cannot be read here; from the end, begin again."""
        self._problem = ""
        if self._ended and self._target is None:
            self._target = self.info.begin
        self._playing = True
        self._update()

    def pause(self) -> None:
        """Stand still."""
        self._playing = False
        self._update()

    def set_speed(self, speed: float | None) -> None:
        """Seconds of the recording in a real second, 0.1 to 20; None: as fast as possible with nothing dropped.

        Raises ValueError saying what is allowed.
        """
        self._speed = checked_speed(speed)
        self._update()

    async def seek(self, position: float) -> None:
        """Go to ``position`` (robot's clock, s; beyond an end: to that end), playing or paused as before.

        Returns once the state there is shown, or that of a newer seek: of several in a row only the newest is carried
        out. Within a damaged part, the state before it is shown and playback pauses (``problem``). Raises LogError if
        the recording cannot be read at all; the position does not change then.
        """
        self._check_alive()
        self._problem = ""
        self._target = min(max(position, self.info.begin), self._end)
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
        self._update()
        await done

    def _check_alive(self) -> None:
        """Raise LogError if the task that carries out commands has failed."""
        driver = self._driver
        if driver is not None and driver.done() and not driver.cancelled():
            raise LogError(f"playback failed: {driver.exception()}")

    # --- Time --------------------------------------------------------------------------------------------------------

    def _update(self) -> None:
        """After a change: set the rate of time, and notify the observers."""
        free = self._target is None and not self._jumping and not self._steps and not self._ended
        self._rate = self._speed if free and self._playing and self._speed is not None else 0.0
        self._run()
        if free and self._playing:
            self._unseen.clear()
        self._changed.set()
        self._observers.notify(self.state)

    def _run(self) -> None:
        rate = 0.0 if self._body_waits else self._rate
        if rate != self._clock.rate:
            self._clock.run(rate)

    def _on_waiting(self, waits: bool) -> None:
        self._body_waits = waits
        self._run()

    def _on_damage(self, damage: LogDamaged) -> None:
        """Pause before a missing part, so that it is not taken for a pause of the robot."""
        self._problem = missing(damage, self.info)
        log.warning("%s: %s", self.info.path.name, self._problem)
        self._playing = False
        self._update()

    async def _drive(self) -> None:
        self._update()
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
            log.critical("playback failed; start the replay again", exc_info=failure)
            _fail([*self._waiting, *self._steps], LogError(f"playback failed: {failure}"))

    async def _pass(self) -> None:
        """Let time pass by itself until something is said or everything up to the end is delivered."""
        end = asyncio.create_task(self._body.finished.wait(), name="recording ends")
        said = asyncio.create_task(self._changed.wait(), name="playback changes")
        try:
            await asyncio.wait({end, said}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            end.cancel()
            said.cancel()
        if self._body.finished.is_set():
            # The last messages are processed before playback ends.
            await self._seeker.worked()
            self._end_if_there()

    async def _advance(self) -> None:
        """Advance time to the next waiting sleeper, once no task has work left now."""
        await self._seeker.quiet()
        if self._changed.is_set():
            return
        self._clock.advance_to(self._next_due())
        if self._clock.now() >= self._end:
            await self._pass()

    def _next_due(self) -> float:
        due = self._clock.next_due
        return self._end if due is None else min(due, self._end)

    def _end_if_there(self) -> None:
        if self._clock.now() >= self._end and self._target is None and not self._ended:
            self._ended = True
            self._playing = False
            self._update()

    async def _step_once(self) -> None:
        done = self._steps[0]
        try:
            until = min(await self._seeker.next_step(), self._end)
            while self._target is None and self._clock.now() < until:
                await self._seeker.quiet()
                self._clock.advance_to(min(self._next_due(), until))
            # Messages of the step are processed before its caller continues.
            await self._seeker.worked()
        except LogError as failure:
            _fail([done], failure)
        else:
            _finish([done])
        self._steps.remove(done)
        self._end_if_there()
        self._update()

    # --- Place -------------------------------------------------------------------------------------------------------

    async def _seek_once(self) -> None:
        """Go to the newest target; one that comes meanwhile is gone to next."""
        position = self._target
        assert position is not None
        self._jumping = True
        failure: LogError | None = None
        try:
            await self._seeker.go(position, self._jumped)
        except LogError as error:
            log.error("cannot go to %.3f s: %s", position - self.info.begin, error)
            failure = error
        finally:
            self._jumping = False
        if self._target == position:
            # Of several seeks in a row only the newest is carried out: the callers of all wait for it.
            self._target = None
            waiting, self._waiting = self._waiting, []
            if failure is None:
                _finish(waiting)
            else:
                _fail(waiting, failure)
        self._end_if_there()
        self._update()

    def _jumped(self, position: float) -> None:
        self._ended = False
        self._jump_observers.notify(position)

    def _want(self, channels: Set[str]) -> None:
        """``channels`` became wanted; while playback is paused, they would get no message."""
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
        self._want({inputs[name] for name in newly if name in inputs} & self.info.channels.keys())

    async def _show_unseen(self) -> None:
        """Show the current messages of channels that became wanted while playback is paused."""
        await self._seeker.quiet()
        channels, self._unseen = self._unseen, set()
        try:
            # Once playback runs, messages come by themselves.
            await self._seeker.show(channels, lambda: self._playing or bool(self._steps) or self._target is not None)
        except LogError as failure:
            log.error("cannot show the state here: %s", failure)

    async def _recall(self) -> None:
        """Say again what latched channels said last, unless they say something themselves meanwhile."""
        channels, self._recalled = self._recalled, set()
        for name in channels:
            channel = self.system.graph.channels[name]
            try:
                await self._seeker.show({name}, partial(self._has_said_more, channel, channel.published))
            except LogError as failure:
                log.error("cannot show the state here: %s", failure)

    def _has_said_more(self, channel: Channel[Any], said: int) -> bool:
        return channel.published != said or self._target is not None


def _finish(futures: Iterable[asyncio.Future[None]]) -> None:
    for future in futures:
        if not future.done():
            future.set_result(None)


def _fail(futures: Iterable[asyncio.Future[None]], failure: LogError) -> None:
    for future in futures:
        if not future.done():
            future.set_exception(LogError(str(failure)))
