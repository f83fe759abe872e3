from __future__ import annotations

import subprocess
import sys
import threading

import pytest

from app.runtime.worker import ModuleWorker
from tests.patience import PATIENCE_S


def test_jobs_run_in_order_in_one_thread() -> None:
    worker = ModuleWorker("M")
    futures = [worker.submit(lambda n=n: (n, threading.get_ident())) for n in range(10)]
    results = [future.result(5) for future in futures]
    assert [n for n, _ in results] == list(range(10))
    assert len({thread for _, thread in results}) == 1
    worker.shutdown(wait=True)


def test_an_error_goes_to_who_asked_and_the_next_job_runs() -> None:
    worker = ModuleWorker("M")
    assert isinstance(worker.submit(divmod, 1, 0).exception(5), ZeroDivisionError)
    assert worker.submit(divmod, 7, 2).result(5) == (3, 1)
    worker.shutdown()


def test_jobs_given_before_the_shutdown_are_still_done_unless_cancelled() -> None:
    for cancel in (False, True):
        worker = ModuleWorker("M")
        started, release = threading.Event(), threading.Event()

        def first(started: threading.Event = started, release: threading.Event = release) -> str:
            started.set()
            release.wait()
            return "first"

        at_work, queued = worker.submit(first), worker.submit(str, "second")
        assert started.wait(PATIENCE_S)
        worker.shutdown(cancel_futures=cancel)
        release.set()
        assert at_work.result(5) == "first"
        worker.shutdown(wait=True)
        assert queued.cancelled() == cancel


def test_a_shut_down_worker_takes_no_more() -> None:
    # It would wait for ever: the thread is gone.
    worker = ModuleWorker("M")
    worker.shutdown(wait=True)
    with pytest.raises(RuntimeError, match="the worker of M was shut down"):
        worker.submit(int)


def test_a_stuck_thread_does_not_hold_up_the_programs_exit() -> None:
    program = """
import threading
from app.runtime.worker import ModuleWorker
worker = ModuleWorker("M")
started = threading.Event()
worker.submit(lambda: (started.set(), threading.Event().wait()))
started.wait()
worker.shutdown()
print("left")
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE_S, check=True
    )
    assert done.stdout == "left\n"
    assert done.stderr == ""
