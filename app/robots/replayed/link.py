"""The body of a log: every stream says what was recorded, when it was recorded; the wheels are nobody's.

Driven by a clock alone: a message is delivered once the clock has come to the time it arrived at, so a clock that
stands delivers nothing. Reading and decoding happen in a thread, a bounded piece of the log ahead. On a loop of virtual
time, which stands while a thread owes a result, two replays of one log deliver the same in the same order.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from collections import Counter
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from app.link import LinkFailed, RobotDescription
from app.logs.log import Log, LogError, Logged
from app.logs.mcap.damage import LogDamaged
from app.messages import Audio, Twist
from app.robots.replayed.log_source import LogPosition, LogSource
from app.runtime.clock import Clock

log = logging.getLogger("hbba.replay")

#: These streams run whether anybody says so or not, once somebody is attached.
ALWAYS_ON = ("odometry", "joints", "status")


class LogFeed:
    """A channel of the log handed on as it is; delivers only while :meth:`demand` says so."""

    def __init__(self, receive: Callable[[Any], None], changed: Callable[[], None]) -> None:
        self.receive = receive
        self.wanted = False
        self._changed = changed

    def demand(self, wanted: bool) -> None:
        """Tell whether anybody listens: what nobody wants is not decoded."""
        if wanted != self.wanted:
            self.wanted = wanted
            self._changed()


class ReplayedLink:
    """Implements ``app.link.RobotLink`` for a ``log``.

    ``streams`` says which channel of the log each stream of ``description`` comes from; one without stays silent.
    Delivered is what arrived from ``begin`` to ``end`` (s; None: of the log). With ``hold``, nothing is before
    :meth:`release`: whoever puts the program together says when everybody listens. The log is the caller's to close,
    after :meth:`stop`.
    """

    def __init__(
        self,
        log: Log,
        clock: Clock,
        description: RobotDescription,
        streams: Mapping[str, str],
        *,
        begin: float | None = None,
        end: float | None = None,
        hold: bool = False,
    ) -> None:
        self.log = log
        self._clock = clock
        self._description = description
        self._channels = dict(streams)
        self.begin = log.info.begin if begin is None else begin
        self.end = log.info.end if end is None else end
        #: Set once everything has been delivered and the clock has come to the end; cleared by :meth:`seek`.
        self.finished = asyncio.Event()
        #: Called with the time (s) of the first message of each piece of the log when it is about to be delivered.
        self.on_piece: Callable[[float], None] = lambda _: None
        #: Called with True when what comes next must be waited for, with False when it is there: whoever moves a clock
        #: that runs by itself can hold it meanwhile, so that time does not outrun the reading.
        self.on_waiting: Callable[[bool], None] = lambda _: None
        #: Called by :meth:`seek`, before anything of the new place is delivered.
        self.on_seek: Callable[[], None] = lambda: None
        #: Called when the clock comes to a part of the log that cannot be read; it goes on behind that.
        self.on_damage: Callable[[LogDamaged], None] = lambda _: None
        #: Whether it lives on, silent to the end or to a seek, where the log does not say what follows its damage.
        self.survives = False
        #: What could not be read so far, each part once, in the order it was come to.
        self.damages: list[LogDamaged] = []
        #: Messages delivered so far, whoever took them.
        self.delivered = 0
        self._receivers: dict[str, list[Callable[[Any], None]]] = {name: [] for name in description.streams}
        self._wanted: set[str] = set(ALWAYS_ON)
        self._feeds: dict[str, list[LogFeed]] = {}
        self._open: dict[str, float] = {}
        self._at = self.begin
        self._passed: Counter[str] = Counter()
        self._released = asyncio.Event()
        if not hold:
            self._released.set()
        self._reader: ThreadPoolExecutor | None = None
        self._pump: asyncio.Task[None] | None = None
        self._restart: asyncio.Handle | None = None
        self._asleep = False
        self._warned: set[tuple[float, float]] = set()
        self._failure: asyncio.Future[LinkFailed] | None = None

    # --- RobotLink ---------------------------------------------------------------------------------------------------

    @property
    def description(self) -> RobotDescription:
        """What this body is: the recorded one, with the streams that the log has."""
        return self._description

    async def start(self) -> None:
        """Begin to read."""
        self._reader = ThreadPoolExecutor(1, thread_name_prefix="log reader")
        self._failure = asyncio.get_running_loop().create_future()
        self._pump = asyncio.create_task(self._run(None), name="replayed body")

    async def stop(self) -> None:
        """Read no more; the log may be closed then. Idempotent."""
        if self._restart is not None:
            self._restart.cancel()
            self._restart = None
        pump, self._pump = self._pump, None
        if pump is not None:
            pump.cancel()
            await asyncio.wait({pump})
        reader, self._reader = self._reader, None
        if reader is not None:
            await asyncio.get_running_loop().run_in_executor(None, reader.shutdown)

    async def wait_failed(self) -> LinkFailed:
        """Wait until the log cannot be read on; return why."""
        if self._failure is None:
            return LinkFailed("The replay was not started.")
        return await asyncio.shield(self._failure)

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """Call ``receive(message)`` on the loop for each message of ``stream``; returns the detacher."""
        receivers = self._of(stream)
        receivers.append(receive)
        self._changed()

        def detach() -> None:
            with contextlib.suppress(ValueError):
                receivers.remove(receive)
            self._changed()

        return detach

    def demand(self, stream: str, wanted: bool) -> None:
        """Tell whether anybody listens to ``stream``; an unwanted one is not even decoded."""
        self._of(stream)
        if stream not in ALWAYS_ON and wanted != (stream in self._wanted):
            (self._wanted.add if wanted else self._wanted.discard)(stream)
            self._changed()

    def command(self, twist: Twist) -> None:
        """What was driven was driven: goes nowhere."""

    def play(self, audio: Audio) -> None:
        """A recording is heard by nobody there."""

    def e_stop(self, reason: str) -> None:
        """Nothing moves: goes nowhere."""

    def clear_e_stop(self) -> None:
        """Nothing was latched."""

    # --- For whoever replays -----------------------------------------------------------------------------------------

    def feed(self, channel: str, receive: Callable[[Any], None]) -> LogFeed:
        """Call ``receive(message)`` for each message of the log's ``channel`` while the feed's demand says so."""
        feed = LogFeed(receive, self._changed)
        self._feeds.setdefault(channel, []).append(feed)
        return feed

    def release(self) -> None:
        """Deliver from now on."""
        self._released.set()

    def seek(self, position: float) -> None:
        """Go on with the first message that arrived after ``position`` (s); emits nothing by itself.

        The clock has been moved to ``position``, or stands.
        """
        self._at = math.nextafter(position, math.inf)
        self._passed.clear()
        self._open = {}
        self._warned.clear()
        self.finished.clear()
        self.on_seek()
        self._restart_reading()

    def show(self, channel: str, message: Any) -> None:
        """Give ``message``, recorded on ``channel``, to whoever listens to that channel's stream or feed, now."""
        for receive in self._receivers_of(channel):
            self._hand(receive, channel, message)

    @property
    def listened(self) -> set[str]:
        """The channels of the log that somebody wants now."""
        heard = [stream for stream, receivers in self._receivers.items() if receivers and stream in self._wanted]
        streams = {self._channels[stream] for stream in heard if stream in self._channels}
        return streams | {channel for channel, feeds in self._feeds.items() if any(feed.wanted for feed in feeds)}

    @property
    def reading(self) -> bool:
        """Whether the next message is still being read: the clock must not be moved on meanwhile.

        False once the body waits for the clock, before :meth:`release`, and at the end.
        """
        return self._released.is_set() and not self._asleep and not self.finished.is_set()

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _of(self, stream: str) -> list[Callable[[Any], None]]:
        try:
            return self._receivers[stream]
        except KeyError:
            streams = ", ".join(self._receivers) or "none"
            raise KeyError(f"{self._description.name} has no stream {stream!r}; it has {streams}") from None

    def _changed(self) -> None:
        """Somebody came, went, or wants something else: once all have said so, read what is wanted then."""
        if self._restart is None and self._pump is not None and self.listened != self._open.keys():
            self._restart = asyncio.get_running_loop().call_soon(self._rewire)

    def _rewire(self) -> None:
        self._restart = None
        if self.listened != self._open.keys():
            self._restart_reading()

    def _restart_reading(self) -> None:
        former = self._pump
        if former is None or self._failed:
            return
        self._asleep = False
        former.cancel()
        self._pump = asyncio.create_task(self._run(former), name="replayed body")

    @property
    def _failed(self) -> bool:
        return self._failure is not None and self._failure.done()

    async def _run(self, former: asyncio.Task[None] | None) -> None:
        """Deliver from the present place to the end."""
        if former is not None:
            await asyncio.wait({former})
        await self._released.wait()
        try:
            try:
                await self._deliver_all(self._source())
            except LogError as failure:
                if not self.survives:
                    raise
                await self._come_to(LogDamaged(str(failure), self._clock.now(), self.end))
            self._asleep = True
            await self._sleep_until(self.end)
        except LogError as failure:
            self._fail(LinkFailed(str(failure)))
            return
        except Exception as failure:
            log.exception("reading %s failed", self.log.info.path)
            self._fail(LinkFailed(f"{self.log.info.path} cannot be read on: {type(failure).__name__}: {failure}"))
            return
        finally:
            self._asleep = False
        self.finished.set()

    def _fail(self, failure: LinkFailed) -> None:
        if self._failure is not None and not self._failure.done():
            self._failure.set_result(failure)

    def _source(self) -> LogSource:
        """What is wanted now, from here on; of channels newly wanted only what arrives from now on."""
        now = max(self._clock.now(), self._at)
        self._open = {channel: self._open.get(channel, now) for channel in self.listened}
        return LogSource(self.log, self._open, LogPosition(self._at, dict(self._passed), dict(self._open)), self.end)

    async def _deliver_all(self, source: LogSource) -> None:
        assert self._reader is not None
        ahead: Future[list[Logged]] = self._reader.submit(source.piece)
        try:
            # The next piece is read while this one is delivered; it is waited for alike, however long it takes.
            while True:
                try:
                    piece = await self._read(ahead)
                except LogDamaged as damage:
                    ahead = self._reader.submit(source.piece)
                    await self._come_to(damage)
                    continue
                if not piece:
                    return
                ahead = self._reader.submit(source.piece)
                self.on_piece(piece[0].at)
                for logged in piece:
                    self._asleep = True
                    await self._sleep_until(logged.at)
                    self._asleep = False
                    self._deliver(logged)
        finally:
            ahead.cancel()
            self._reader.submit(source.close)

    async def _come_to(self, damage: LogDamaged) -> None:
        """Tell of it when it is its time, once but for seeks."""
        self._asleep = True
        await self._sleep_until(damage.begin)
        self._asleep = False
        part = (damage.begin, damage.end)
        if part in self._warned:
            return
        self._warned.add(part)
        if all(part != (known.begin, known.end) for known in self.damages):
            self.damages.append(damage)
        self.on_damage(damage)

    async def _read(self, ahead: Future[list[Logged]]) -> list[Logged]:
        self.on_waiting(True)
        try:
            return await asyncio.get_running_loop().run_in_executor(None, ahead.result)
        finally:
            self.on_waiting(False)

    async def _sleep_until(self, at: float) -> None:
        await self._clock.sleep_until(at)
        while self._clock.now() < at:  # woken by a jump of the clock
            await self._clock.sleep_until(at)

    def _deliver(self, logged: Logged) -> None:
        if logged.at != self._at:
            self._at = logged.at
            self._passed.clear()
        self._passed[logged.channel] += 1
        self.delivered += 1
        for receive in self._receivers_of(logged.channel):
            self._hand(receive, logged.channel, logged.message)

    def _receivers_of(self, channel: str) -> list[Callable[[Any], None]]:
        streams = [
            r for s, c in self._channels.items() if c == channel and s in self._wanted for r in self._receivers[s]
        ]
        return streams + [feed.receive for feed in self._feeds.get(channel, ()) if feed.wanted]

    def _hand(self, receive: Callable[[Any], None], channel: str, message: Any) -> None:
        try:
            receive(message)
        except Exception as failure:  # noqa: BLE001  # one receiver's fault must not cut the others off, nor pass in silence
            asyncio.get_running_loop().call_exception_handler(
                {"message": f"a receiver of {channel} raised", "exception": failure}
            )
