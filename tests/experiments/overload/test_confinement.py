from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator

import psutil
import pytest

from app.base.errors import ConfigError
from app.experiments.overload.confinement import NICE_STEP, confined, neighbours_niceness
from tests.patience import PATIENCE_S

needs_two_cores = pytest.mark.skipif(
    not hasattr(os, "sched_setaffinity") or len(os.sched_getaffinity(0)) < 2, reason="needs Linux and two cores"
)


@pytest.fixture
def body() -> Iterator[subprocess.Popen[bytes]]:
    """A process with a child."""
    nested = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'input()'])"
    process = subprocess.Popen([sys.executable, "-c", nested], stdin=subprocess.PIPE)
    yield process
    process.kill()
    process.communicate()


@needs_two_cores
def test_the_program_is_kept_on_one_core_and_the_world_on_the_others(body: subprocess.Popen[bytes]) -> None:
    before = os.sched_getaffinity(0)
    release = threading.Event()
    thread = threading.Thread(target=release.wait)
    thread.start()
    try:
        with confined(body.pid, 100):
            first = min(before)
            assert all(os.sched_getaffinity(t.id) == {first} for t in psutil.Process().threads())
            family = [psutil.Process(body.pid), *psutil.Process(body.pid).children(recursive=True)]
            assert all(os.sched_getaffinity(p.pid) == before - {first} for p in family)
        assert all(os.sched_getaffinity(t.id) == before for t in psutil.Process().threads())
    finally:
        release.set()
        thread.join()


@needs_two_cores
def test_a_busy_neighbour_takes_the_rest_and_leaves(body: subprocess.Popen[bytes]) -> None:
    before = {child.pid for child in psutil.Process().children()}  # other tests may have left helpers
    assert body.pid in before
    with confined(body.pid, 30):
        spinning = [p for p in psutil.Process().children() if p.pid not in before]
        assert len(spinning) == 3
        assert {frozenset(p.cpu_affinity()) for p in spinning} == {frozenset(os.sched_getaffinity(0))}
    assert {child.pid for child in psutil.Process().children()} <= before


@needs_two_cores
def test_no_neighbour_outlives_a_program_that_is_killed(body: subprocess.Popen[bytes]) -> None:
    program = (
        "import psutil, sys, time; from app.experiments.overload.confinement import confined\n"
        f"with confined({body.pid}, 60):\n"
        "    print(*(child.pid for child in psutil.Process().children()), flush=True)\n"
        "    time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as confining:
        assert confining.stdout is not None
        neighbours = [psutil.Process(int(pid)) for pid in confining.stdout.readline().split()]
        confining.kill()
    assert neighbours
    _, alive = psutil.wait_procs(neighbours, timeout=PATIENCE_S)
    for neighbour in alive:
        neighbour.kill()
    assert not alive


def test_one_core_is_too_few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {3}, raising=False)
    monkeypatch.setattr(os, "sched_setaffinity", lambda *_: None, raising=False)
    with pytest.raises(ConfigError, match="two at least"), confined(os.getpid(), 100):
        pass


@pytest.mark.parametrize("budget", [10, 25, 50, 60, 80, 95])
def test_neighbours_weigh_as_much_as_the_budget_leaves(budget: float) -> None:
    ours = 1.0
    others = sum(ours / NICE_STEP**niceness for niceness in neighbours_niceness(budget))
    assert 100 * ours / (ours + others) == pytest.approx(budget, abs=3.5)
