"""The robot's clock: real, or virtual for tests and replay.

Nothing outside this file reads the time. Stamps are seconds since the Unix epoch, but they never jump when the
computer's wall clock is set: the offset between the monotonic clock and the epoch is taken once.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import selectors
import time
from collections.abc import Callable, Coroutine
from concurrent.futures import Executor
from typing import Any, ParamSpec, Protocol, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

_SHORTEST_SLEEP_S = 1e-6


class Clock(Protocol):
    """Time as modules see it."""

    def now(self) -> float:
        """Seconds since the Unix epoch, never decreasing."""
        ...

    async def sleep(self, seconds: float) -> None:
        """Wait; a negative or zero time yields to other tasks once."""
        ...

    async def sleep_until(self, stamp: float) -> None:
        """Wait until ``now() >= stamp``."""
        ...


class RealClock:
    """The computer's monotonic clock, shifted once so that it reads as Unix time.

    ``offset`` (s) is what was added to ``time.monotonic()``: another process on the same computer that adds the
    same offset reads the same clock.
    """

    def __init__(self) -> None:
        self.offset = time.time() - time.monotonic()

    def now(self) -> float:
        """Seconds since the Unix epoch, never decreasing."""
        return time.monotonic() + self.offset

    async def sleep(self, seconds: float) -> None:
        """Wait ``seconds``."""
        await asyncio.sleep(seconds)

    async def sleep_until(self, stamp: float) -> None:
        """Wait until ``stamp``."""
        await _sleep_until(self, stamp)


class VirtualClock:
    """A clock that only a :class:`VirtualTimeLoop` moves; ``origin`` is its reading when the loop starts."""

    def __init__(self, origin: float = 1_000_000.0) -> None:
        self.origin = origin
        self._latest = origin

    def now(self) -> float:
        """``origin`` plus the virtual seconds that have passed on the running loop; its last reading outside one."""
        # Outside any loop time stands still.
        with contextlib.suppress(RuntimeError):
            self._latest = self.origin + asyncio.get_running_loop().time()
        return self._latest

    async def sleep(self, seconds: float) -> None:
        """Let ``seconds`` of virtual time pass."""
        await asyncio.sleep(seconds)

    async def sleep_until(self, stamp: float) -> None:
        """Let virtual time pass until ``stamp``."""
        await _sleep_until(self, stamp)


async def _sleep_until(clock: Clock, stamp: float) -> None:
    await asyncio.sleep(stamp - clock.now())
    # asyncio may wake a timer early by its resolution, and a stamp has more digits before the point than a delay.
    while clock.now() < stamp:  # noqa: ASYNC110  # time is the event
        await asyncio.sleep(max(stamp - clock.now(), _SHORTEST_SLEEP_S))


class _JumpingSelector(selectors.DefaultSelector):
    """Instead of waiting for a timer, moves the loop's time to it, unless a worker thread still owes a result."""

    loop: VirtualTimeLoop

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None or timeout <= 0:
            return super().select(timeout)
        if self.loop.outstanding_jobs:
            ready = super().select(self.loop.patience_s)
            if ready:
                return ready
            # A thread that never comes back must not hold time up for ever.
            self.loop.outstanding_jobs.clear()
        ready = super().select(0)
        if not ready:
            self.loop.virtual_time += timeout
        return ready


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop whose time stands still while anything runs and jumps to the next timer when everything waits.

    Work in threads counts as running, as long as it was started with ``run_in_executor`` (so ``asyncio.to_thread``
    and ``Module.compute`` too): a run is deterministic however slow the machine. Only a thread that does not come back
    within ``patience_s`` real seconds is given up, and time goes on without it.
    """

    def __init__(self, patience_s: float = 10.0) -> None:
        self.virtual_time = 0.0
        self.patience_s = patience_s
        self.outstanding_jobs: set[asyncio.Future[Any]] = set()
        selector = _JumpingSelector()
        super().__init__(selector)
        selector.loop = self

    def time(self) -> float:
        """Virtual seconds since the loop was made."""
        return self.virtual_time

    def run_in_executor(  # type: ignore[override]  # typeshed names the variadics differently
        self, executor: Executor | None, func: Callable[..., T], *args: Any
    ) -> asyncio.Future[T]:
        """As in asyncio, remembering that a thread owes a result."""
        future: asyncio.Future[T] = super().run_in_executor(executor, func, *args)
        self.outstanding_jobs.add(future)
        future.add_done_callback(self.outstanding_jobs.discard)
        return future


def run_virtual(main: Coroutine[Any, Any, T], *, patience_s: float = 10.0) -> T:
    """Run ``main`` to its end in virtual time and return its result; see :class:`VirtualTimeLoop`."""
    with asyncio.Runner(loop_factory=lambda: VirtualTimeLoop(patience_s)) as runner:
        return runner.run(main)


def in_virtual_time(function: Callable[P, Coroutine[Any, Any, T]]) -> Callable[P, T]:
    """Decorate an ``async`` test: each call of it runs to its end in virtual time."""

    @functools.wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        return run_virtual(function(*args, **kwargs))

    return run
