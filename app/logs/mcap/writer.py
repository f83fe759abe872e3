"""Writes a log in a thread of its own, behind a queue bounded in bytes and in messages.

``put`` returns at once, however slow the disk is. Messages without room in the queue are dropped and counted; a disk
that stays too slow, fails or runs full ends the recording with a reason in words, and nothing else.
"""

from __future__ import annotations

import errno
import logging
import queue
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np

from app.logs.mcap.disk_time import DiskTime
from app.logs.mcap.file_sink import FileSink
from app.logs.mcap.open_file import UnrecordableMessage
from app.logs.mcap.ring import Ring

T = TypeVar("T")
#: The destination of a recording, used by the writer's thread alone.
Sink: TypeAlias = FileSink | Ring

log = logging.getLogger("hbba.recording")

MEGABYTE = 1_000_000
#: The disk is too slow if writing waits for it for this share of the time.
_DISKS_SHARE = 0.5
#: Period (s) of writing the queue in one go: a thread that woke for each message would cost more than writing it.
BEAT_S = 0.05
#: A chunk is closed at least this often (s): what a killed program loses at most.
FLUSH_S = 0.5
#: Period (s) of checking the free space.
LOOK_S = 1.0


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a writer: memory, disk space left free, and how long (s) it may drop messages."""

    queue_bytes: int = 64 * MEGABYTE
    queue_messages: int = 20_000
    least_free_bytes: int = 200 * MEGABYTE
    too_slow_after_s: float = 2.0


def weight(message: Any) -> int:
    """About how many bytes of memory ``message`` holds."""
    total = 64
    for name in _fields_of(type(message)):
        value = getattr(message, name)
        if isinstance(value, np.ndarray):
            total += value.nbytes
        elif isinstance(value, str | bytes):
            total += len(value)
        elif isinstance(value, tuple):
            total += 64 * len(value)
        else:
            total += 8
    return total


_names: dict[type[Any], tuple[str, ...]] = {}


def _fields_of(cls: type[Any]) -> tuple[str, ...]:
    if cls not in _names:
        _names[cls] = tuple(field.name for field in fields(cls))
    return _names[cls]


class RecordingWriter:
    """One recording being written; created, fed and ended by one thread (the event loop's)."""

    def __init__(
        self,
        open_sink: Callable[[], Sink],
        limits: Limits,
        now: Callable[[], float],
        *,
        on_change: Callable[[], None] = lambda: None,
        charge: Callable[[Callable[[], None]], None] = lambda work: work(),
        free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        disk: DiskTime | None = None,
    ) -> None:
        """Begin; the thread calls ``open_sink`` first, which may raise OSError. ``disk`` times the files it opens.

        ``on_change`` is called in the thread once the sink is open and once all is over; ``charge(work)`` calls
        ``work()`` there and records its CPU time.
        """
        self._open_sink = open_sink
        self._limits = limits
        self._now = now
        self._on_change = on_change
        self._charge = charge
        self._free_bytes = free_bytes
        self.began = self._newest = now()
        self._dropped = 0
        self._refused = 0
        self._refusing: set[str] = set()
        self._queue: deque[tuple[float, str, Any, int]] = deque()
        # Each is written by one thread only: the difference needs no lock.
        self._bytes_in = self._bytes_out = 0
        self._dropping_since: float | None = None
        self._disk = disk or DiskTime()
        #: When dropping began, and how long the disk had been waited for by then (s).
        self._kept_up_until = self._waited_before = 0.0
        self._ended = False
        #: Whether everything is written and closed, or given up.
        self.over = False
        #: Why it ended by itself, in words; empty while it did not.
        self.reason = ""
        self._discard = False
        self._calls: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        #: None until it is open.
        self.sink: Sink | None = None
        self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
        self._thread.start()

    # --- for the loop ---

    @property
    def dropped(self) -> int:
        """Number of messages without room in the queue, or that could not be encoded."""
        return self._dropped + self._refused

    @property
    def queued_bytes(self) -> int:
        """About how many bytes of memory wait for the disk."""
        return self._bytes_in - self._bytes_out

    @property
    def duration_s(self) -> float:
        """Seconds from the begin of its data to the newest message."""
        sink = self.sink
        return max(0.0, self._newest - (self.began if sink is None else sink.begin))

    def put(self, at: float, channel: str, message: Any) -> None:
        """Queue a message that arrived ``at`` (robot's clock, s) on ``channel``, or drop and count it; never waits."""
        if self._ended:
            return
        size = weight(message)
        held = self._bytes_in - self._bytes_out
        if held + size > self._limits.queue_bytes or len(self._queue) >= self._limits.queue_messages:
            self._dropped += 1
            if self._dropping_since is None:
                self._dropping_since = at
                self._kept_up_until, self._waited_before = time.monotonic(), self._disk.waited_s
            elif at - self._dropping_since > self._limits.too_slow_after_s:
                self._end(self._too_slow(at - self._dropping_since))
            return
        if self._dropping_since is not None and 2 * held < self._limits.queue_bytes:
            self._dropping_since = None
        self._bytes_in += size
        self._newest = at
        self._queue.append((at, channel, message, size))

    def call(self, function: Callable[[Sink], T]) -> Future[T]:
        """Have ``function(sink)`` called in the thread, after all that was put before.

        An OSError it raises ends the recording too: the disk failed it.
        """
        future: Future[T] = Future()

        def run() -> None:
            if not future.set_running_or_notify_cancel():
                return
            if self.over or self.sink is None:
                future.set_exception(OSError(self.reason or "the recording is over"))
                return
            try:
                result = function(self.sink)
            except OSError as error:  # then only `abandon` is left of the sink
                future.set_exception(error)
                raise
            except Exception as error:  # noqa: BLE001  # raised where the future is awaited
                future.set_exception(error)
            else:
                future.set_result(result)

        self._calls.put(run)
        if self.over:  # the loop is closed: no task waits for the answer
            self._refuse_calls()
        return future

    def finish(self, discard: bool = False) -> None:
        """Accept no more messages; queued ones are still written. See :meth:`Ring.close` for ``discard``."""
        self._discard = discard
        self._end("")

    def join(self, timeout_s: float | None = None) -> bool:
        """Wait until it is over, at most ``timeout_s``; returns whether it is. Not for the event loop."""
        self._thread.join(timeout_s)
        return self.over

    def _end(self, reason: str) -> None:
        if not self._ended:
            self._ended = True
            self.reason = reason
            self._calls.put(None)

    def _too_slow(self, seconds: float) -> str:
        """Whether the disk or the computer did not keep up for ``seconds``, and what to do."""
        what = f"{self._dropped} messages found no room within {seconds:.1f} s"
        passed = max(time.monotonic() - self._kept_up_until, 1e-9)
        share = min(1.0, (self._disk.waited_s - self._waited_before) / passed)
        if share >= _DISKS_SHARE:
            return f"the disk is too slow: {what}; record to a faster disk ($HBBA_RECORDINGS)"
        return (
            f"this computer is too busy to record: {what}, and the disk was waited for in only {100 * share:.0f} % of "
            "that; end other programs, or record less"
        )

    # --- the thread ---

    def _run(self) -> None:
        try:
            self._charge(self._open)
            self._on_change()
            self._live()
        except OSError as error:
            self._fail(in_words(error), error)
        except Exception as error:  # the robot goes on, and the reason is shown
            log.exception("recording ended by a mistake of ours")
            self._fail(f"recording failed: {type(error).__name__}: {error}", error)
        finally:
            self._queue.clear()
            self._bytes_out = self._bytes_in
            self.over = True
            self._refuse_calls()
            self._on_change()

    def _open(self) -> None:
        self.sink = self._open_sink()
        self._check_space()

    def _live(self) -> None:
        flushed = looked = time.monotonic()
        going = True
        while going:
            with suppress(queue.Empty):
                call = self._calls.get(timeout=BEAT_S)
                if call is None:
                    going = False
                else:
                    self._charge(self._drain)  # messages put before the call come before it
                    self._charge(call)
            self._charge(self._drain)
            now = time.monotonic()
            if now - flushed >= FLUSH_S:
                flushed = now
                self._charge(self._opened().flush)
            if now - looked >= LOOK_S:
                looked = now
                self._check_space()
        self._charge(self._close)

    def _drain(self) -> None:
        sink = self._opened()
        # As many as are queued now: those that arrive meanwhile wait for the next period, after a check of the clock.
        for _ in range(len(self._queue)):
            at, channel, message, size = self._queue.popleft()
            try:
                sink.write(at, channel, message)
            except UnrecordableMessage as error:  # one message that is wrong is no reason to lose the others
                self._refused += 1
                if channel not in self._refusing:
                    self._refusing.add(channel)
                    log.warning("left out of the recording (said once for each channel): %s", error, exc_info=error)
            self._bytes_out += size

    def _close(self) -> None:
        self._opened().close(self._discard)

    def _opened(self) -> Sink:
        if self.sink is None:
            raise RuntimeError("nothing is open")
        return self.sink

    def _check_space(self) -> None:
        folder = self._opened().folder
        check_room(folder, self._free_bytes(folder), self._limits.least_free_bytes)

    def _fail(self, reason: str, error: Exception) -> None:
        self._ended = True
        self.reason = self.reason or reason
        if self.sink is None:
            return
        if isinstance(error, DiskFull):  # no write has failed yet, and there is room for an end
            with suppress(OSError):
                self._charge(self._drain)
                self._charge(self._close)
                return
        self._charge(self.sink.abandon)

    def _refuse_calls(self) -> None:
        with suppress(queue.Empty):
            while True:
                if (call := self._calls.get_nowait()) is not None:
                    call()


class DiskFull(OSError):
    """The disk has less room than is kept free; the message is for people."""


def check_room(folder: Path, free: int, least: int) -> None:
    """Raise DiskFull where ``free`` bytes on the disk under ``folder`` are fewer than the ``least`` to stay free."""
    if free < least:
        raise DiskFull(
            f"the disk is nearly full: {free / MEGABYTE:.0f} MB free in {folder}, of which "
            f"{least / MEGABYTE:.0f} MB stay free; delete recordings or record elsewhere"
        )


def in_words(error: OSError) -> str:
    """Message for people about a failed write, with a remedy."""
    where = f" ({error.filename})" if error.filename else ""
    match error.errno:
        case None:
            return str(error)
        case errno.ENOSPC | errno.EDQUOT:
            return f"the disk is full{where}: delete recordings, or record elsewhere ($HBBA_RECORDINGS)"
        case errno.ENOENT | errno.ENOTDIR:
            return f"the folder or the file is gone{where}: was it deleted, or a disk pulled out?"
        case errno.EROFS | errno.EACCES | errno.EPERM:
            return f"nothing may be written there{where}: {error.strerror}; record elsewhere ($HBBA_RECORDINGS)"
        case errno.EIO | errno.ENXIO | errno.ENODEV:
            return f"the disk fails{where}: {error.strerror}; check it, and record to another"
        case _:
            return f"the recording cannot be written{where}: {error.strerror}"
