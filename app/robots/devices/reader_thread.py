"""Reader thread of one device: reads while there is demand, and passes items to the event loop."""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Generic, Protocol, TypeVar

from app.robots.devices.image_inputs import InputUnavailable

T = TypeVar("T")
Item = TypeVar("Item", covariant=True)

#: Time (s) without demand after which a live device is released: a camera's light goes out.
LINGER_S = 5.0
RETRY_S = 3.0

log = logging.getLogger("hbba.devices")


class DeviceInput(Protocol[Item]):
    """An open device or file."""

    live: bool

    def read(self) -> Item | None:
        """Wait for the next item; None at the end. Raises InputUnavailable."""
        ...

    def skip(self) -> None:
        """Discard the buffered items of a live device."""
        ...

    def close(self) -> None: ...


class InputReader(Generic[T]):
    """Opens, reads, delivers, closes, and opens again after a loss.

    ``take(item)`` is called on the loop with each item, unless ``most_waiting`` of them wait there already: then the
    item is dropped and counted. ``pause_s()``: time to wait after an item of a file.
    """

    def __init__(
        self,
        name: str,
        open_source: Callable[[], DeviceInput[T]],
        take: Callable[[T], None],
        *,
        pause_s: Callable[[], float],
        most_waiting: int,
    ) -> None:
        self.name = name
        self.dropped = 0
        self._open_source = open_source
        self._take = take
        self._pause_s = pause_s
        self._most_waiting = most_waiting
        self._waiting = 0
        self._condition = threading.Condition()
        self._wanted = False
        self._ending = False
        self._last_problem = ""
        self._thread: threading.Thread | None = None

    async def start(self) -> str:
        """Start the thread; returns "" once the device is open, or why it cannot be (it is tried again while there is
        demand).

        Raises any other error of opening it.
        """
        loop = asyncio.get_running_loop()
        opened: asyncio.Future[str] = loop.create_future()
        self._thread = threading.Thread(target=self._run, args=(loop, opened), name=self.name, daemon=True)
        self._thread.start()
        return await opened

    def want(self, wanted: bool) -> None:
        """Set whether there is demand."""
        with self._condition:
            self._wanted = wanted
            self._condition.notify()

    async def stop(self) -> None:
        """End and release the device. A thread blocked in a device ends with the program."""
        with self._condition:
            self._ending = True
            self._condition.notify()
        if self._thread is not None:
            await asyncio.get_running_loop().run_in_executor(None, self._thread.join, 0.5)

    def _run(self, loop: asyncio.AbstractEventLoop, opened: asyncio.Future[str]) -> None:
        try:
            source, problem = self._try_open()
        except BaseException as failure:  # noqa: BLE001  # raised in start()
            _call_in_loop(loop, partial(_settle, opened, failure))
            return
        _call_in_loop(loop, partial(_settle, opened, problem))
        rested = True
        while not self._ending:
            wanted = self._wanted
            if source is None:
                self._wait_while(wanted, RETRY_S if wanted else None)
                if self._asked:
                    source, _ = self._try_open()
            elif not wanted:
                rested = True
                self._wait_while(wanted, LINGER_S if source.live else None)
                if source.live and not self._asked:
                    source.close()
                    source = None
            else:
                if rested and source.live:
                    source.skip()
                rested = False
                source = self._read(loop, source)
        if source is not None:
            source.close()

    @property
    def _asked(self) -> bool:
        return self._wanted and not self._ending

    def _read(self, loop: asyncio.AbstractEventLoop, source: DeviceInput[T]) -> DeviceInput[T] | None:
        try:
            item = source.read()
        except InputUnavailable as failure:
            self._log_problem(str(failure))
            source.close()
            return None
        if item is None:
            self._log_problem(f"{self.name}: that was all of it")
            with self._condition:
                while not self._ending:
                    self._condition.wait()
            return source
        with self._condition:
            full = self._waiting >= self._most_waiting
            self._waiting += not full
        if full:
            self.dropped += 1
        else:
            _call_in_loop(loop, partial(self._deliver, item))
        if not source.live:
            self._wait_out(self._pause_s())
        return source

    def _deliver(self, item: T) -> None:
        with self._condition:
            self._waiting -= 1
        self._take(item)

    def _try_open(self) -> tuple[DeviceInput[T] | None, str]:
        try:
            source = self._open_source()
        except InputUnavailable as failure:
            self._log_problem(str(failure))
            return None, str(failure)
        if self._last_problem:
            log.info("%s is there again", self.name)
        self._last_problem = ""
        return source, ""

    def _log_problem(self, problem: str) -> None:
        """Log a problem once, when it begins."""
        if problem != self._last_problem:
            self._last_problem = problem
            log.warning("%s", problem)

    def _wait_while(self, wanted: bool, timeout_s: float | None) -> None:
        """Wait while the demand equals ``wanted``, at most ``timeout_s``."""
        with self._condition:
            self._condition.wait_for(lambda: self._ending or self._wanted != wanted, timeout_s)

    def _wait_out(self, seconds: float) -> None:
        """Wait for this time, unless the thread ends."""
        until = time.monotonic() + seconds
        with self._condition:
            while not self._ending and (left := until - time.monotonic()) > 0:
                self._condition.wait(left)


def _settle(opened: asyncio.Future[str], outcome: str | BaseException) -> None:
    if opened.done():  # the waiting task was cancelled
        return
    if isinstance(outcome, str):
        opened.set_result(outcome)
    else:
        opened.set_exception(outcome)


def _call_in_loop(loop: asyncio.AbstractEventLoop, call: Callable[[], object]) -> None:
    try:
        loop.call_soon_threadsafe(call)
    except RuntimeError:  # the loop is closed
        log.debug("the event loop is gone")
