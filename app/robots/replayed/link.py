"""The body of a log: every stream delivers the recorded messages at their recorded times; commands have no effect.

Driven by a clock alone: a message is delivered once the clock reaches its time of arrival, so a stopped clock delivers
nothing. A thread reads and decodes a bounded piece of the log ahead. On a loop of virtual time, which waits for
threads, two replays of one log deliver the same messages in the same order.
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
from app.messages import Audio, JointCommand, Twist
from app.robots.replayed.log_source import LogPosition, LogSource
from app.runtime.clock import Clock

log = logging.getLogger("hbba.replay")

#: Streams that run independent of demand, once they have a receiver.
ALWAYS_ON = ("odometry", "joints", "status")


class LogFeed:
    """A channel of the log, delivered unchanged while :meth:`demand` is set."""

    def __init__(self, receive: Callable[[Any], None], changed: Callable[[], None]) -> None:
        self.receive = receive
        self.wanted = False
        self._changed = changed

    def demand(self, wanted: bool) -> None:
        """Set whether there are subscribers: without demand, messages are not decoded."""
        if wanted != self.wanted:
            self.wanted = wanted
            self._changed()


class ReplayedLink:
    """Implements ``app.link.RobotLink`` for a ``log``.

    ``streams``: the log's channel of each stream of ``description``; a stream without one stays silent. ``begin``,
    ``end`` (s; None: of the log): interval of arrival of the delivered messages. With ``hold``, delivery starts at
    :meth:`release`, when all receivers are attached. The caller closes the log, after :meth:`stop`.
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
        self.description = description
        self._channels = dict(streams)
        self.begin = log.info.begin if begin is None else begin
        self.end = log.info.end if end is None else end
        #: Set once all messages are delivered and the clock has reached the end; cleared by :meth:`seek`.
        self.finished = asyncio.Event()
        #: Called with the time (s) of the first message of each piece before its delivery.
        self.on_piece: Callable[[float], None] = lambda _: None
        #: Called with True when the next message is not read yet, with False when it is: a clock that runs by itself
        #: can pause meanwhile, so that time does not overtake the reading.
        self.on_waiting: Callable[[bool], None] = lambda _: None
        #: Called by :meth:`seek`, before any message of the new position.
        self.on_seek: Callable[[], None] = lambda: None
        #: Called when the clock reaches an unreadable part of the log; delivery goes on behind it.
        self.on_damage: Callable[[LogDamaged], None] = lambda _: None
        #: Whether the body stays up, silent until the end or a seek, where the log does not show what follows a damage.
        self.survives = False
        #: Unreadable parts so far, each once, in order.
        self.damages: list[LogDamaged] = []
        #: Number of delivered messages.
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

    async def start(self) -> None:
        self._reader = ThreadPoolExecutor(1, thread_name_prefix="log reader")
        self._failure = asyncio.get_running_loop().create_future()
        self._pump = asyncio.create_task(self._run(None), name="replayed body")

    async def stop(self) -> None:
        """End reading; the log may be closed then. Idempotent."""
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
        """Wait until the log becomes unreadable; return why."""
        if self._failure is None:
            return LinkFailed("The replay was not started.")
        return await asyncio.shield(self._failure)

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        receivers = self._of(stream)
        receivers.append(receive)
        self._changed()

        def detach() -> None:
            with contextlib.suppress(ValueError):
                receivers.remove(receive)
            self._changed()

        return detach

    def demand(self, stream: str, rate_hz: float) -> None:
        """Set the rate at which ``stream`` is wanted: at 0 its messages are not decoded, else all are delivered."""
        self._of(stream)
        wanted = rate_hz > 0
        if stream not in ALWAYS_ON and wanted != (stream in self._wanted):
            (self._wanted.add if wanted else self._wanted.discard)(stream)
            self._changed()

    def periods(self, stream: str) -> int:
        """1: every recorded message is delivered."""
        self._of(stream)
        return 1

    def command(self, command: Twist | JointCommand) -> None:
        """No effect: the motion is recorded."""

    def play(self, audio: Audio) -> None:
        """No effect."""

    def e_stop(self, reason: str) -> None:
        """No effect: nothing moves."""

    def clear_e_stop(self) -> None:
        """No effect."""

    # --- Control of the replay ---------------------------------------------------------------------------------------

    def feed(self, channel: str, receive: Callable[[Any], None]) -> LogFeed:
        """Call ``receive(message)`` for each message of the log's ``channel`` while the feed has demand."""
        feed = LogFeed(receive, self._changed)
        self._feeds.setdefault(channel, []).append(feed)
        return feed

    def release(self) -> None:
        """Start delivery."""
        self._released.set()

    def seek(self, position: float) -> None:
        """Continue with the first message that arrived after ``position`` (s); delivers nothing by itself.

        The clock has been moved to ``position``, or is stopped.
        """
        self._at = math.nextafter(position, math.inf)
        self._passed.clear()
        self._open = {}
        self._warned.clear()
        self.finished.clear()
        self.on_seek()
        self._restart_reading()

    def show(self, channel: str, message: Any) -> None:
        """Deliver ``message``, recorded on ``channel``, to that channel's stream or feed now."""
        for receive in self._receivers_of(channel):
            self._hand(receive, channel, message)

    @property
    def listened(self) -> set[str]:
        """The channels of the log with demand."""
        heard = [stream for stream, receivers in self._receivers.items() if receivers and stream in self._wanted]
        streams = {self._channels[stream] for stream in heard if stream in self._channels}
        return streams | {channel for channel, feeds in self._feeds.items() if any(feed.wanted for feed in feeds)}

    @property
    def reading(self) -> bool:
        """Whether the next message is not read yet: the clock must not be moved on meanwhile.

        False once the body waits for the clock, before :meth:`release`, and at the end.
        """
        return self._released.is_set() and not self._asleep and not self.finished.is_set()

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _of(self, stream: str) -> list[Callable[[Any], None]]:
        try:
            return self._receivers[stream]
        except KeyError:
            streams = ", ".join(self._receivers) or "none"
            raise KeyError(f"{self.description.name} has no stream {stream!r}; it has {streams}") from None

    def _changed(self) -> None:
        """The demand changed: once all changes are in, read with the new demand."""
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
        """Deliver from the current position to the end."""
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
        """A source of all channels with demand from the current position; new channels start now."""
        now = max(self._clock.now(), self._at)
        self._open = {channel: self._open.get(channel, now) for channel in self.listened}
        return LogSource(self.log, self._open, LogPosition(self._at, dict(self._passed), dict(self._open)), self.end)

    async def _deliver_all(self, source: LogSource) -> None:
        assert self._reader is not None
        ahead: Future[list[Logged]] = self._reader.submit(source.piece)
        try:
            # The next piece is read while this one is delivered, and awaited however long it takes.
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
        """Report a damaged part when the clock reaches it, once except after seeks."""
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
        while self._clock.now() < at:  # a jump of the clock wakes it
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
        except Exception as failure:  # noqa: BLE001  # must neither affect other receivers nor pass in silence
            asyncio.get_running_loop().call_exception_handler(
                {"message": f"a receiver of {channel} raised", "exception": failure}
            )
