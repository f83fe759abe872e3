"""The robot's clock: real, or virtual for tests and replay.

What the robot senses, decides and does goes by it alone. The other files that read the computer's clock (time limits,
how long something took, a body in a process of its own) are listed in ``tests/test_clocks.py``, each with its reason,
and no others may. Stamps are seconds since the Unix epoch, but they never jump when the computer's wall clock is set:
the offset between the monotonic clock and the epoch is taken once.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import functools
import selectors
import time
from collections import deque
from collections.abc import Callable, Coroutine
from typing import Any, Generic, ParamSpec, Protocol, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

_SHORTEST_SLEEP_S = 1e-6
#: A task that never waits for more than the next turn of the loop must not keep threads' results out for ever.
_LONGEST_SPIN = 100


class Clock(Protocol):
    """Time as modules see it."""

    def now(self) -> float:
        """Seconds since the Unix epoch, never decreasing."""

    async def sleep(self, seconds: float) -> None:
        """Wait; a negative or zero time yields to other tasks once."""

    async def sleep_until(self, stamp: float) -> None:
        """Wait until ``now() >= stamp``."""


class _LoopClock:
    """Sleeps by the running loop's timers."""

    def now(self) -> float:
        raise NotImplementedError

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    async def sleep_until(self, stamp: float) -> None:
        await asyncio.sleep(stamp - self.now())
        # asyncio may wake a timer early by its resolution, and a stamp has more digits before the point than a delay.
        while self.now() < stamp:  # noqa: ASYNC110  # time is the event
            await asyncio.sleep(max(stamp - self.now(), _SHORTEST_SLEEP_S))


class RealClock(_LoopClock):
    """The computer's monotonic clock, shifted once so that it reads as Unix time, or by the ``offset`` given.

    ``offset`` (s) is what was added to ``time.monotonic()``: another process on the same computer that adds the
    same offset reads the same clock.
    """

    def __init__(self, offset: float | None = None) -> None:
        self.offset = time.time() - time.monotonic() if offset is None else offset

    def now(self) -> float:
        """Seconds since the Unix epoch, never decreasing."""
        return time.monotonic() + self.offset


class VirtualClock(_LoopClock):
    """A clock that only a :class:`VirtualTimeLoop` moves; ``origin`` is its reading when the loop starts."""

    def __init__(self, origin: float = 1_000_000.0) -> None:
        self.origin = origin
        self._latest = origin

    def now(self) -> float:
        """``origin`` plus the virtual seconds that have passed on the running loop; its last reading outside one."""
        # Outside of an event loop time does not pass. Read at every step of a world: suppress() would take half of it.
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            return self._latest
        self._latest = self.origin + loop.time()
        return self._latest


class _ThreadJob(Generic[T]):
    """Work in a thread: its ``result`` there, and the ``future`` that a task on the loop waits for."""

    def __init__(self, loop: VirtualTimeLoop, result: concurrent.futures.Future[T]) -> None:
        self.result = result
        self.future: asyncio.Future[T] = loop.create_future()
        self._loop = loop
        self._given_up = False
        self.future.add_done_callback(lambda future: result.cancel() if future.cancelled() else None)
        result.add_done_callback(self._wake)

    def deliver(self) -> None:
        """Hand the result over; called on the loop."""
        if self.future.done():
            return
        if self.result.cancelled():
            self.future.cancel()
        elif (error := self.result.exception()) is not None:
            self.future.set_exception(error)
        else:
            self.future.set_result(self.result.result())

    def give_up(self) -> None:
        """Deliver it whenever it comes."""
        self._given_up = True
        if self.result.done():
            self.deliver()

    def _wake(self, _: object) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed: nothing waits any more
            self._loop.call_soon_threadsafe(self.deliver if self._given_up else _nothing)


def _nothing() -> None:
    """Wake the loop."""


class _JumpingSelector(selectors.DefaultSelector):
    """Instead of waiting for a timer, moves the loop's time to it, unless a thread still owes a result."""

    loop: VirtualTimeLoop
    _turns = 0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        jobs = self.loop.jobs
        spinning = timeout is not None and timeout <= 0
        self._turns = self._turns + 1 if spinning else 0
        if spinning and not (jobs and self._turns > _LONGEST_SPIN):
            return super().select(0)
        # Every task waits. Results are delivered one by one in the order of their calls, not of their arrival.
        while jobs:
            if jobs[0].future.done():
                jobs.popleft()
            elif jobs[0].result.done():
                jobs.popleft().deliver()
                self._turns = 0
                return super().select(0)
            elif ready := super().select(self.loop.patience_s):
                return ready
            else:
                jobs.popleft().give_up()
        if timeout is None or spinning:
            return super().select(timeout)
        ready = super().select(0)
        if not ready:
            self.loop.virtual_time += timeout
        return ready


#: Real time (s) that a thread may take: on a busy computer, and where it compiles first.
_PATIENCE_S = 180.0


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop in virtual time: time does not pass while a task runs, and jumps to the next timer when all tasks
    wait.

    Work in threads counts as running if it was started with ``run_in_executor`` (so ``asyncio.to_thread`` and
    ``Module.compute`` too). Its results arrive in the order of the calls: a run gives the same results each time,
    however slow the machine. A thread that does not return within ``patience_s`` real seconds is given up, and time
    passes without it.
    """

    def __init__(self, patience_s: float = _PATIENCE_S) -> None:
        self.virtual_time = 0.0
        self.patience_s = patience_s
        self.jobs: deque[_ThreadJob[Any]] = deque()
        selector = _JumpingSelector()
        super().__init__(selector)
        selector.loop = self
        self._threads = concurrent.futures.ThreadPoolExecutor(thread_name_prefix="virtual time")
        self.set_default_executor(self._threads)

    def time(self) -> float:
        """Virtual seconds since the loop was made."""
        return self.virtual_time

    def run_in_executor(  # type: ignore[override]  # typeshed names the variadics differently
        self, executor: concurrent.futures.Executor | None, func: Callable[..., T], *args: Any
    ) -> asyncio.Future[T]:
        """As in asyncio; time does not pass until the thread returns its result."""
        job = _ThreadJob(self, (executor or self._threads).submit(func, *args))
        self.jobs.append(job)
        return job.future

    async def shutdown_default_executor(self, timeout: float | None = None) -> None:
        """As in asyncio, but without ``timeout``: in virtual time it would be over at once."""
        await super().shutdown_default_executor()


def run_virtual(main: Coroutine[Any, Any, T], *, patience_s: float = _PATIENCE_S) -> T:
    """Run ``main`` to its end in virtual time and return its result; see :class:`VirtualTimeLoop`."""
    with asyncio.Runner(loop_factory=lambda: VirtualTimeLoop(patience_s)) as runner:
        return runner.run(main)


def in_virtual_time(function: Callable[P, Coroutine[Any, Any, T]]) -> Callable[P, T]:
    """Decorate an ``async`` test: each call of it runs to its end in virtual time."""

    @functools.wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        return run_virtual(function(*args, **kwargs))

    return run
