"""One worker thread per module, for CPU-bound work.

A module that never returns from C code cannot be interrupted. Each module therefore has its own daemon thread: a
stuck one is abandoned with its module's next restart and can hold up neither other modules nor the program's exit
(``concurrent.futures`` threads would be joined at exit).
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _WorkerJob:
    run: Callable[[], None]
    future: Future[Any]


class ModuleWorker(Executor):
    """An executor with a single daemon thread, started with the first job."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._jobs: queue.SimpleQueue[_WorkerJob | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._shut_down = False

    def submit(self, function: Callable[..., T], /, *args: Any, **kwargs: Any) -> Future[T]:
        """Run ``function`` in the thread after the jobs before it. Raises RuntimeError after :meth:`shutdown`."""
        if self._shut_down:
            raise RuntimeError(f"the worker of {self._name} was shut down")
        future: Future[T] = Future()

        def job() -> None:
            if not future.set_running_or_notify_cancel():
                return
            try:
                result = function(*args, **kwargs)
            except BaseException as error:  # noqa: BLE001  # raised where the future is awaited
                future.set_exception(error)
            else:
                future.set_result(result)

        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name=f"module {self._name}", daemon=True)
            self._thread.start()
        self._jobs.put(_WorkerJob(job, future))
        return future

    def shutdown(self, wait: bool = False, *, cancel_futures: bool = False) -> None:
        """Let the thread end after its current job; waits for it only if ``wait``."""
        self._shut_down = True
        if cancel_futures:
            with suppress(queue.Empty):
                while (job := self._jobs.get_nowait()) is not None:
                    job.future.cancel()
        self._jobs.put(None)
        if wait and self._thread is not None:
            self._thread.join()

    def join(self, within_s: float) -> None:
        """After :meth:`shutdown`: wait until the thread has ended, ``within_s`` at most. Blocks."""
        if self._thread is not None:
            self._thread.join(max(0.0, within_s))

    @property
    def alive(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            job.run()
            # Not kept until the next one comes: its result may be large.
            del job
