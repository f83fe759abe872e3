"""Confinement: the program on one core, or a share of it, and the body's world on the others."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
from collections.abc import Iterator

import psutil

from app.base.child_processes import python
from app.base.errors import ConfigError

#: Ratio of CPU shares per step of niceness (Linux, sched(7)).
NICE_STEP = 1.25
#: Source of a process that keeps a core busy; it ends with its parent, however the parent ends.
_BUSY = """
import os, sys
while os.getppid() == int(sys.argv[1]):
    for _ in range(100000):
        pass
"""
#: Share of a core from which no other process is needed.
WHOLE = 99.0


@contextlib.contextmanager
def confined(body: int, budget: float) -> Iterator[None]:
    """Keep this process on the first of its cores, with ``budget`` % of it; the process ``body`` on the others.

    A share below a whole core is enforced by a busy process of suitable niceness, which gets the rest whenever both
    run. Undone at the end. Raises ConfigError where it is impossible.
    """
    if not hasattr(os, "sched_setaffinity"):
        raise ConfigError("a program can be kept on one core on Linux alone", "hbba experiment overload")
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) < 2:
        raise ConfigError("the world needs a core of its own beside the program's: two at least", "this computer")
    ours, others = {cores[0]}, set(cores[1:])
    try:
        _keep(os.getpid(), ours)
        for process in (body, *(child.pid for child in psutil.Process(body).children(recursive=True))):
            _keep(process, others)
        with shared(budget):
            yield
    finally:
        _keep(os.getpid(), set(cores))


@contextlib.contextmanager
def shared(budget: float) -> Iterator[None]:
    """Leave this process ``budget`` % of the cores that it may use: busy processes get the rest whenever both run."""
    neighbours = [] if budget >= WHOLE else _neighbours(budget, set(os.sched_getaffinity(0)))
    try:
        yield
    finally:
        for neighbour in neighbours:
            neighbour.kill()
            neighbour.wait()


def neighbours_niceness(budget: float) -> list[int]:
    """Niceness of each busy process that leaves ``budget`` % (0 to 100) of a core to a process of niceness 0.

    One process for shares above half, several below.
    """
    weight = 100.0 / budget - 1.0  # total weight of the busy processes, relative to 1 for this process
    count = max(1, math.ceil(weight))
    niceness = round(-math.log(weight / count) / math.log(NICE_STEP))
    return [min(19, max(0, niceness))] * count


def _neighbours(budget: float, cores: set[int]) -> list[subprocess.Popen[bytes]]:
    started = []
    for niceness in neighbours_niceness(budget):
        # In this session: Linux shares a core among sessions first (autogroup).
        process = subprocess.Popen(python("-c", _BUSY, str(os.getpid())), stdin=subprocess.DEVNULL)
        os.sched_setaffinity(process.pid, cores)
        os.setpriority(os.PRIO_PROCESS, process.pid, niceness)
        started.append(process)
    return started


def _keep(process: int, cores: set[int]) -> None:
    """Set the cores of every thread of ``process``; later threads inherit them."""
    for thread in psutil.Process(process).threads():
        with contextlib.suppress(ProcessLookupError):  # the process has just ended
            os.sched_setaffinity(thread.id, cores)
