"""Settings of the Python interpreter and of Linux that keep an event loop on time."""

from __future__ import annotations

import contextlib
import gc
import os
import sys
import threading
from collections.abc import Iterator

#: Seconds after which a thread that waits for the interpreter lock (GIL) asks its holder to release it. Python's
#: default is 5 ms: a control cycle goes from the loop to a thread and back, so it was up to 10 ms late beside modules
#: that compute.
SWITCH_INTERVAL_S = 0.001
#: Niceness of a thread that controls motion, relative to the process: a lower value runs first on Linux.
NICENESS_OFFSET = -5


@contextlib.contextmanager
def garbage_held() -> Iterator[None]:
    """Collect no garbage inside, until :func:`tune_for_latency`.

    A start-up makes some hundred thousand objects, hardly any of them garbage. To go through them again and again took
    a fifth of its time.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def tune_for_latency() -> None:
    """Shorten the interpreter's pauses; call it once, after start-up.

    It shortens the switch interval of threads, collects garbage, freezes every object alive (``gc.freeze``) and ends
    :func:`garbage_held`: later full collections skip these objects. A collection of a whole program holds all threads
    for about 0.1 s.
    """
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    gc.collect()
    gc.freeze()
    gc.enable()


def raise_thread_priority() -> None:
    """Raise the priority of the calling thread, whose short work the robot's motion waits for.

    Linux grants this to root and to users with the limit ``ulimit -e 25`` or more; elsewhere nothing changes.
    """
    if sys.platform == "linux":
        niceness = os.getpriority(os.PRIO_PROCESS, os.getpid()) + NICENESS_OFFSET
        with contextlib.suppress(PermissionError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
