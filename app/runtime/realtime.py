"""What a process does whose event loop is to be on time: the interpreter's own habits cost more than its work."""

from __future__ import annotations

import contextlib
import gc
import os
import sys
import threading

#: A thread that waits for the interpreter asks the one at work to give way after so long (s). By default 5 ms: a
#: control cycle goes from the loop to a thread and back, and so was up to 10 ms late beside modules that compute.
GIVE_WAY_S = 0.001
#: What a thread that decides where the robot drives is nicer by than the process: how Linux shares out processors.
FIRST_NICENESS = -5


def be_punctual() -> None:
    """Call it once everything stands. What there is by then stays: collections of garbage, which hold every thread for
    0.1 s where they go through all objects of a program, need not look at it again. This is the last to do so."""
    sys.setswitchinterval(GIVE_WAY_S)
    gc.collect()
    gc.freeze()


def go_first() -> None:
    """Call it in a thread of short work that the robot's motion waits for: on a busy computer it runs before others.

    Linux grants it to root and to those who may (``ulimit -e 25`` and more); elsewhere all stays as it is.
    """
    if sys.platform == "linux":
        niceness = os.getpriority(os.PRIO_PROCESS, os.getpid()) + FIRST_NICENESS
        with contextlib.suppress(PermissionError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
