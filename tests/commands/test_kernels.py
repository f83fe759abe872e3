"""Kernels are compiled before a robot starts, and what compiles them ends when it is asked to."""

from __future__ import annotations

import asyncio
import inspect
import logging
import sys
from types import ModuleType

import psutil
import pytest

from app.base import compiled
from app.commands import kernels, replay, run
from app.commands.kernels import kernels_ready

#: A compiler that shares its work with another process, prints the ids of both, and never ends.
ENDLESS = """
import subprocess, sys
other = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
import os
print(os.getpid(), other.pid, flush=True)
other.wait()
"""


async def test_nothing_is_started_where_all_is_compiled(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiled, "is_ready", lambda: True)
    await kernels_ready(["/no/such/compiler"])
    assert capsys.readouterr() == ("", "")


async def test_each_file_is_a_line_of_the_log(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiled, "is_ready", lambda: False)
    caplog.set_level(logging.INFO, "hbba.kernels")
    program = "print('hbba: compiled app.a (1 of 2)'); print('hbba: compiled app.b (2 of 2)'); raise SystemExit(3)"
    await kernels_ready([sys.executable, "-c", program])
    assert "once on this computer" in capsys.readouterr().out
    lines = [record.getMessage() for record in caplog.records]
    assert lines[1:3] == ["compiled app.a (1 of 2)", "compiled app.b (2 of 2)"]
    assert "status 3" in lines[3]


async def test_all_that_compiles_ends_when_it_is_cancelled(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(compiled, "is_ready", lambda: False)
    caplog.set_level(logging.INFO, "hbba.kernels")
    said = asyncio.Event()

    class Heard(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if record.getMessage()[0].isdigit():
                said.set()

    handler = Heard()
    kernels.log.addHandler(handler)
    try:
        compiling = asyncio.create_task(kernels_ready([sys.executable, "-c", ENDLESS]))
        await said.wait()
        numbers = [int(word) for word in caplog.records[-1].getMessage().split()]
        compilers = [psutil.Process(number) for number in numbers]
        compiling.cancel()
        with pytest.raises(asyncio.CancelledError):
            await compiling
    finally:
        kernels.log.removeHandler(handler)
    _, alive = await asyncio.to_thread(psutil.wait_procs, compilers, 60)
    assert not [process for process in alive if process.status() != psutil.STATUS_ZOMBIE]


@pytest.mark.blocking("libraries are loaded in the loop, while nothing runs yet")
@pytest.mark.parametrize("command", [run, replay])
async def test_nothing_of_a_robot_begins_before(command: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    class Compiled(Exception):
        pass

    async def ready() -> None:
        raise Compiled

    monkeypatch.setattr(command, "kernels_ready", ready)
    arguments = dict.fromkeys(inspect.signature(command._live).parameters)
    with pytest.raises(Compiled):  # and not what it raises where it looks at any of its arguments before
        await command._live(**arguments)
