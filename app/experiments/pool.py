"""Trials in child processes, a few at a time: a world that takes its process down takes no other trial with it."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Generic, TypeVar

T = TypeVar("T")
R = TypeVar("R")

#: One thread each: there is a process for every core.
_SINGLE = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_PR_SET_PDEATHSIG = 1


class TrialLost(Exception):
    """A child process died in a trial; the message says which and what is left to do."""


class Trials(Generic[T, R]):
    """``work(trial)`` for every one of ``trials`` in ``jobs`` processes; both must be picklable."""

    def __init__(self, work: Callable[[T], R], trials: Sequence[T], jobs: int) -> None:
        self._work = work
        self._trials = trials
        self._jobs = max(1, min(jobs, len(trials)))

    def __iter__(self) -> Iterator[tuple[T, R]]:
        """Trials with their results, as they end. Raises what ``work`` raises, and TrialLost."""
        for name in _SINGLE:
            os.environ.setdefault(name, "1")  # children inherit it; it is read when they load the library
        waiting = iter(self._trials)
        under_way: dict[Future[R], T] = {}
        pool = ProcessPoolExecutor(self._jobs, mp_context=get_context("spawn"), initializer=_quiet)
        try:
            while True:
                while len(under_way) < self._jobs + 1 and (trial := next(waiting, None)) is not None:
                    under_way[pool.submit(self._work, trial)] = trial
                if not under_way:
                    return
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    trial = under_way.pop(future)
                    yield trial, future.result()
        except BrokenProcessPool:
            raise TrialLost(
                "A child process of the experiment died (out of memory?). Results are kept: start it again to go on."
            ) from None
        finally:
            children = list((pool._processes or {}).values())  # a trial under way has no other end
            pool.shutdown(wait=False, cancel_futures=True)
            for child in children:
                child.terminate()


def _quiet() -> None:
    """Leave Ctrl-C to the parent, which ends its children, and do not outlive it."""
    import cv2

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    cv2.setNumThreads(1)
