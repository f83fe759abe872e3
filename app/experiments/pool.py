"""Trials in child processes, several at a time, each with any number of results: a crash loses no other trial."""

from __future__ import annotations

import os
import pickle
import signal
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Generic, TypeVar

from app.base.child_processes import end_with_parent, safe_path
from app.robots.simulated.gl import gl_environment

T = TypeVar("T")
R = TypeVar("R")

#: One thread each: there is one process per core.
_SINGLE = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class TrialLost(Exception):
    """A child process died in a trial; the message names it and what is left."""


@dataclass(frozen=True, slots=True)
class _Result(Generic[R]):
    value: R


@dataclass(frozen=True, slots=True)
class _Over:
    """End of a trial, by ``error`` if it failed."""

    error: Exception | None = None


class TrialSeries(Generic[T, R]):
    """Results of ``work(trial, give)`` for every one of ``trials`` in ``jobs`` processes; all must be picklable."""

    def __init__(self, work: Callable[[T, Callable[[R], None]], None], trials: Sequence[T], jobs: int) -> None:
        self._work = work
        self._trials = trials
        self._jobs = max(1, min(jobs, len(trials)))

    def __iter__(self) -> Iterator[tuple[T, R]]:
        """Each result with its trial, on arrival. Raises the errors of ``work``, and TrialLost."""
        for name in _SINGLE:
            os.environ.setdefault(name, "1")  # children inherit it; it is read when they load the library
        for name, value in gl_environment().items():  # as is how to draw, when they import MuJoCo
            os.environ.setdefault(name, value)
        context = get_context("spawn")
        waiting = deque(self._trials)
        children: list[SpawnProcess] = []
        under_way: dict[Connection, T] = {}
        try:
            while waiting and len(children) < self._jobs:
                ours, theirs = context.Pipe()
                child = context.Process(target=_serve, args=(theirs, self._work))
                with safe_path():
                    child.start()
                theirs.close()
                children.append(child)
                under_way[ours] = trial = waiting.popleft()
                _give(ours, trial)
            while under_way:
                for connection in wait(list(under_way)):
                    assert isinstance(connection, Connection)
                    trial = under_way[connection]
                    answer: _Result[R] | _Over = _taken(connection)
                    if isinstance(answer, _Result):
                        yield trial, answer.value
                    elif answer.error is not None:
                        raise answer.error
                    elif waiting:
                        under_way[connection] = trial = waiting.popleft()
                        _give(connection, trial)
                    else:
                        del under_way[connection]
                        connection.close()
        finally:
            for connection in under_way:
                connection.close()
            for child in children:  # a running trial is ended only so
                child.terminate()
            for child in children:
                child.join()


def _give(connection: Connection, trial: object) -> None:
    try:
        connection.send(trial)
    except OSError:
        raise _lost() from None


def _taken(connection: Connection) -> _Result[R] | _Over:
    try:
        answer: _Result[R] | _Over = connection.recv()
    except (EOFError, OSError):
        raise _lost() from None
    return answer


def _lost() -> TrialLost:
    return TrialLost(
        "A child process of the experiment died (out of memory?). Results are kept: start it again to go on."
    )


def _serve(connection: Connection, work: Callable[[T, Callable[[R], None]], None]) -> None:
    """In a child: run trials until there are no more."""

    def give(result: R) -> None:
        connection.send(_Result(result))

    _quiet()
    while True:
        try:
            trial = connection.recv()
        except EOFError:
            return
        try:
            work(trial, give)
        except Exception as error:  # noqa: BLE001 - it is raised again, in the parent
            connection.send(_Over(_portable(error)))
        else:
            connection.send(_Over())


def _portable(error: Exception) -> Exception:
    """``error`` in a picklable form, with its traceback."""
    where = "".join(traceback.format_exception(error))
    try:
        copy: Exception = pickle.loads(pickle.dumps(error))
    except Exception:  # noqa: BLE001 - what an error's own pickling may raise is anything
        return RuntimeError(f"In a child process:\n{where}")
    copy.add_note(f"In a child process:\n{where}")
    return copy


def _quiet() -> None:
    """Ignore Ctrl-C, which the parent handles, and end with the parent."""
    import cv2

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    cv2.setNumThreads(1)
