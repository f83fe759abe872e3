"""``hbba run``: starting, being asked to stop, and what a person reads when it cannot."""

from __future__ import annotations

import asyncio
import contextlib
import os
import queue
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import cast

import psutil
import pytest

from app import cli
from app.commands import run
from app.commands.run import Stopping, kept_waiting_s, login_url, serve_once_started
from app.link import LinkFailed
from app.program.system import System
from app.robots.simulated.gl import check_gl
from tests.patience import PATIENCE_S

HBBA = Path(sys.executable).with_name("hbba")

needs_gl = pytest.mark.skipif(check_gl() is not None, reason=check_gl() or "")


def test_the_token_goes_behind_the_hash_where_no_server_sees_it() -> None:
    assert login_url("http://127.0.0.1:8080", None) == "http://127.0.0.1:8080"
    assert login_url("http://192.0.2.1:8080", "abcdefgh") == "http://192.0.2.1:8080/#token=abcdefgh"
    assert login_url("http://192.0.2.1:8080", "a b&#é%") == "http://192.0.2.1:8080/#token=a%20b%26%23%C3%A9%25"


def test_the_first_signal_asks_and_the_second_forces() -> None:
    asked: list[str] = []
    forced: list[int] = []
    stopping = Stopping(forced.append, within_s=60)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    try:
        stopping.install(lambda: asked.append("stop"))
        signal.raise_signal(signal.SIGTERM)
        assert (asked, forced) == (["stop"], [])
        signal.raise_signal(signal.SIGINT)
        assert (asked, forced) == (["stop"], [128 + signal.SIGINT])
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)


def test_what_does_not_stop_in_time_is_forced() -> None:
    forced: queue.Queue[int] = queue.Queue()
    Stopping(forced.put, within_s=0.01).begin()
    assert forced.get(timeout=PATIENCE_S) == 1


def test_time_that_the_computer_is_too_busy_for_it_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    waits = [0.0, 1.0, 2.0, 3.0, 3.5]  # seconds that it was kept waiting so far, as said each time
    said: list[float] = []

    def kept_waiting() -> float:
        said.append(waits[min(len(said), 4)])
        return said[-1]

    monkeypatch.setattr(run, "kept_waiting_s", kept_waiting)
    forced: queue.Queue[int] = queue.Queue()
    Stopping(forced.put, within_s=0.01).begin()
    assert forced.get(timeout=PATIENCE_S) == 1
    assert said == [*waits, 3.5]


def test_how_long_it_was_kept_waiting_grows() -> None:
    assert 0.0 <= kept_waiting_s() <= kept_waiting_s()


def test_a_taken_port_is_one_sentence_and_nothing_starts(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert cli.main(["run", "--port", str(port), "--log-level", "error"]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"hbba run: port {port} of 127.0.0.1 is taken")
    assert f"--port {port + 1}" in error
    assert error.count("\n") == 1


class Program:
    """A program whose modules start, and whose body is lost, when the test says so."""

    def __init__(self) -> None:
        self.supervisor = self
        self.modules = asyncio.Event()
        self.lost = asyncio.get_running_loop().create_future()

    async def started(self) -> None:
        await self.modules.wait()

    async def keep_going(self) -> Exception:
        failure: Exception = await self.lost
        return failure


@pytest.fixture
def without_latency_tuning(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is for the life of a process is not for that of a test."""
    monkeypatch.setattr("app.commands.run.tune_for_latency", lambda: None)


@pytest.mark.usefixtures("without_latency_tuning")
async def test_no_request_is_served_before_the_modules_have_started() -> None:
    program, serving = Program(), asyncio.Event()

    async def serve() -> None:
        serving.set()

    running = asyncio.create_task(serve_once_started(cast(System, program), serve))
    for _ in range(10):
        await asyncio.sleep(0)
    assert not serving.is_set()
    program.modules.set()
    await running
    assert serving.is_set()


@pytest.mark.usefixtures("without_latency_tuning")
@pytest.mark.parametrize("while_starting", [True, False])
async def test_a_body_lost_ends_it_whatever_is_done(while_starting: bool) -> None:
    program, serving = Program(), asyncio.Event()

    async def serve() -> None:
        serving.set()
        await asyncio.Event().wait()

    running = asyncio.create_task(serve_once_started(cast(System, program), serve))
    if not while_starting:
        program.modules.set()
        await serving.wait()
    program.lost.set_result(LinkFailed("the body is gone"))
    with pytest.raises(LinkFailed, match="the body is gone"):
        await running
    assert serving.is_set() != while_starting


class Running:
    """``hbba run`` as a process of its own, and all it writes."""

    def __init__(self, *arguments: str) -> None:
        # No terminal, own session: what a person's Ctrl-C does to the group is done below, to each process by name.
        self.process = subprocess.Popen(
            [HBBA, "run", "--port", "0", *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.output = ""

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._lines.put(line)
        self._lines.put(None)

    def wait_for(self, pattern: str, timeout_s: float = PATIENCE_S) -> re.Match[str]:
        """The first line that matches; fails with all that was written if the process ends before."""
        deadline = time.monotonic() + timeout_s
        while (line := self._lines.get(timeout=max(0.1, deadline - time.monotonic()))) is not None:
            self.output += line
            if found := re.search(pattern, line):
                return found
        pytest.fail(f"no line matches {pattern!r} in:\n{self.output}")

    def family(self) -> list[psutil.Process]:
        """The process's children and theirs, now."""
        return psutil.Process(self.process.pid).children(recursive=True)

    def rest(self) -> str:
        """All it has written, once it has ended."""
        self._reader.join(PATIENCE_S)
        while (line := self._lines.get(timeout=PATIENCE_S)) is not None:
            self.output += line
        return self.output


@contextmanager
def running(*arguments: str) -> Iterator[Running]:
    run = Running(*arguments)
    try:
        yield run
    finally:
        family = run.family() if run.process.poll() is None else []
        for process in family:
            process.kill()
        run.process.kill()
        run.process.wait(PATIENCE_S)
        assert run.process.stdout is not None
        run.process.stdout.close()


def gone(processes: list[psutil.Process]) -> bool:
    _, alive = psutil.wait_procs(processes, timeout=PATIENCE_S)
    return not alive


@needs_gl
@pytest.mark.slow
def test_ctrl_c_stops_everything_in_time_and_leaves_no_child_in_a_folder_with_another_app_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "app").mkdir()
    (tmp_path / "app" / "__init__.py").write_text("raise SystemExit('some other app')\n")
    monkeypatch.chdir(tmp_path)
    with running() as run:
        url = run.wait_for(r"HBBA is up: (http://127\.0\.0\.1:\d+)").group(1)
        with urllib.request.urlopen(f"{url}/api/v1/health", timeout=PATIENCE_S) as answer:
            assert answer.status == 200
        family = run.family()
        assert family, "the body lives in a process of its own"
        # A terminal sends Ctrl-C to the whole group.
        os.killpg(run.process.pid, signal.SIGINT)
        assert run.process.wait(PATIENCE_S) == 0, run.rest()
        assert gone(family)
        assert "Traceback" not in run.rest()
        assert "by force" not in run.output
        assert "some other app" not in run.output, "the body is a process of its own, and finds the program's app too"


@needs_gl
@pytest.mark.slow
def test_a_body_that_dies_again_and_again_ends_the_run_with_one_sentence() -> None:
    with running("--log-level", "error") as run:
        run.wait_for("HBBA is up")
        while run.process.poll() is None:
            for child in run.family():
                with contextlib.suppress(psutil.NoSuchProcess):
                    child.kill()
            with contextlib.suppress(subprocess.TimeoutExpired):
                run.process.wait(0.1)
        assert run.process.returncode == 1
        sentence = "was killed by signal 9; that was the 5th time in a row, so the program ends."
        assert re.search(rf"^hbba run: .+{re.escape(sentence)}$", run.rest(), re.MULTILINE)
        assert "Traceback" not in run.output


@needs_gl
@pytest.mark.slow
def test_being_asked_to_stop_while_starting_leaves_no_child() -> None:
    with running("--log-level", "debug") as run:
        while not (family := run.family()) and run.process.poll() is None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                run.process.wait(0.05)
        run.process.send_signal(signal.SIGTERM)
        run.process.wait(PATIENCE_S)
        assert gone(family)
        assert "Traceback" not in run.rest()


def test_a_link_that_cannot_be_is_refused_before_anything_starts(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["run", "--link", "delay=300"])
    assert "argument --link: delay is a number with its unit (ms or s), not '300'" in capsys.readouterr().err
