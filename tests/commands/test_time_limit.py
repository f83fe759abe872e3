from __future__ import annotations

import signal
import threading
import time

import pytest

from app.commands.time_limit import TimeIsUp, until


def go_on_for_ever() -> None:
    while True:
        pass


def test_what_goes_on_is_ended_at_the_deadline() -> None:
    with pytest.raises(TimeIsUp), until(time.perf_counter() + 0.01):
        go_on_for_ever()


def test_what_ends_before_is_left_alone_and_so_is_the_alarm_of_others() -> None:
    others = signal.getsignal(signal.SIGALRM)
    timer = signal.setitimer(signal.ITIMER_REAL, 1000)
    try:
        with until(time.perf_counter() + 500):
            pass
        assert signal.getsignal(signal.SIGALRM) is others
        assert 0 < signal.getitimer(signal.ITIMER_REAL)[0] <= 1000
    finally:
        signal.setitimer(signal.ITIMER_REAL, *timer)


def test_outside_of_the_main_thread_the_work_is_done_all_the_same() -> None:
    done: list[bool] = []

    def work() -> None:
        with until(time.perf_counter() + 500):
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [True]
