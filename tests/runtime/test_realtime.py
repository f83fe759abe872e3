"""A process whose loop is to be on time."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from app.runtime.realtime import NICENESS_OFFSET, raise_thread_priority
from tests.patience import PATIENCE_S

CHECK = """
import gc, sys, time
from app.runtime.realtime import tune_for_latency
objects = [[number] for number in range(300_000)]
tune_for_latency()
begin = time.thread_time()
gc.collect()
assert time.thread_time() - begin < 0.005, "what stood before is looked at"
assert gc.get_freeze_count() >= 300_000
assert sys.getswitchinterval() <= 0.001
"""

HELD = """
import gc
from app.runtime.realtime import garbage_held, tune_for_latency
with garbage_held():
    assert not gc.isenabled()
    tune_for_latency()
    assert gc.isenabled()
try:
    with garbage_held():
        raise ValueError
except ValueError:
    assert gc.isenabled(), "a start that fails leaves it as it was"
"""


def test_live_objects_are_frozen_and_threads_switch_sooner() -> None:
    subprocess.run([sys.executable, "-c", CHECK], check=True, timeout=PATIENCE_S)  # habits of a whole process


def test_garbage_is_held_until_the_start_is_over() -> None:
    subprocess.run([sys.executable, "-c", HELD], check=True, timeout=PATIENCE_S)


def _niceness_after(action: Callable[[], None]) -> int:
    """Of a fresh thread that did ``action``."""

    def niceness() -> int:
        action()
        return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())

    with ThreadPoolExecutor(1) as pool:
        return pool.submit(niceness).result()


@pytest.mark.skipif(sys.platform != "linux", reason="threads have a niceness of their own on Linux alone")
def test_a_thread_goes_before_the_others_where_it_may(monkeypatch: pytest.MonkeyPatch) -> None:
    before = os.getpriority(os.PRIO_PROCESS, os.getpid())
    asked: list[int] = []

    def granted(which: int, who: int, niceness: int) -> None:
        assert (which, who) == (os.PRIO_PROCESS, threading.get_native_id())
        asked.append(niceness)

    def refused(which: int, who: int, niceness: int) -> None:
        raise PermissionError(13, "Permission denied")

    for answer in (granted, refused):
        monkeypatch.setattr(os, "setpriority", answer)
        assert _niceness_after(raise_thread_priority) == before
    assert asked == [before + NICENESS_OFFSET]


@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="only root may go first")
def test_the_process_itself_stays_as_it_was() -> None:
    before = os.getpriority(os.PRIO_PROCESS, os.getpid())
    assert _niceness_after(raise_thread_priority) in (
        before + NICENESS_OFFSET,
        before,
    )  # containers may forbid it even to root
    assert _niceness_after(lambda: None) == before
