"""Rehearsals of tours started from the page: in a process of its own, one at a time."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import msgspec

from app.base.child_processes import python
from app.console.records.tours import RehearsalReport
from app.console.rehearsal_process import RehearsalOrder, RehearsalWord

#: A longer result is no rehearsal's (bytes).
_LARGEST_WORD = 64 * 1024**2
_TAIL_BYTES = 8192
NOTHING = RehearsalReport("none", "", "", began=None, seconds=0.0, stop="", problem="", can_be_led=None, result=None)

log = logging.getLogger(__name__)


class RehearsalUnderWay(Exception):
    """Another rehearsal runs; the message is one sentence."""


class Rehearsals:
    """At most one at a time; :meth:`close` ends it with the console. ``command`` is what to run, with the order on its
    standard input."""

    def __init__(self, *, command: Sequence[str] = ()) -> None:
        self.command = command or python("-m", "app.console.rehearsal_process", str(os.getpid()))
        self._report = NOTHING
        self._task: asyncio.Task[None] | None = None
        self._ending = asyncio.Event()

    @property
    def report(self) -> RehearsalReport:
        """The one that runs, or the last."""
        return self._report

    def start(self, tour: str, order: RehearsalOrder) -> None:
        """Rehearse the tour with the id ``tour`` as ``order`` says. Raises RehearsalUnderWay."""
        if self._report.state == "running":
            raise RehearsalUnderWay(f"{self._report.tour} is being rehearsed already: cancel that first")
        self._report = replace(NOTHING, state="running", tour=tour, language=order.language, began=time.time())
        self._ending = asyncio.Event()
        self._task = asyncio.create_task(self._run(order), name=f"rehearsal of {tour}")

    async def wait(self) -> RehearsalReport:
        """Wait until none runs; returns what became of the last."""
        if self._task is not None:
            await asyncio.wait({self._task})
        return self._report

    async def cancel(self) -> None:
        """End the one that runs, and forget it, or the result of the last."""
        task, self._task = self._task, None
        if task is not None:
            # A process that is just being started cannot be left by cancelling its start.
            self._ending.set()
            await asyncio.wait({task})
        self._report = NOTHING

    async def close(self) -> None:
        await self.cancel()

    async def _run(self, order: RehearsalOrder) -> None:
        folder = None
        try:
            folder = await asyncio.to_thread(tempfile.mkdtemp, prefix="hbba-rehearsals-")
            await self._follow(order, folder)
        except OSError as failure:
            self._end("failed", f"its process cannot be started: {failure.strerror or failure}")
        finally:
            if folder is not None:
                await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)

    async def _follow(self, order: RehearsalOrder, folder: str) -> None:
        process = await asyncio.create_subprocess_exec(
            *self.command, env={**os.environ, "TMPDIR": folder}, stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE, start_new_session=True,
            limit=_LARGEST_WORD,
        )  # fmt: skip
        assert process.stderr is not None
        noting = asyncio.create_task(_tail(process.stderr), name="rehearsal's errors")
        hearing = asyncio.create_task(self._talk(process, order), name="rehearsal's words")
        ending = asyncio.create_task(self._ending.wait(), name="rehearsal's end")
        await asyncio.wait({hearing, ending}, return_when=asyncio.FIRST_COMPLETED)
        ending.cancel()
        if self._ending.is_set():
            # Also what it has started itself.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
        await hearing
        said, status = await noting, await process.wait()
        if self._report.state == "running":
            self._end("failed", _last_words(said) or f"it ended with status {status} and said nothing")

    async def _talk(self, process: asyncio.subprocess.Process, order: RehearsalOrder) -> None:
        """Give ``process`` its order, and hear it to its end."""
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(ConnectionError):
            process.stdin.write(msgspec.json.encode(order))
            await process.stdin.drain()
        process.stdin.close()
        async for line in process.stdout:
            self._hear(line)

    def _hear(self, line: bytes) -> None:
        try:
            # Off the loop it would be no faster: of some hundred kilobytes it takes milliseconds.
            word = msgspec.json.decode(line, type=RehearsalWord)
        except msgspec.DecodeError:
            log.warning("a rehearsal said what is no word of a rehearsal: %s", line[:200])
            return
        if word.result is not None:
            result = word.result
            self._end("done", "")
            self._report = replace(
                self._report, seconds=result.duration_s, stop="", can_be_led=result.can_be_led, result=result
            )
        elif word.problem is not None:
            self._end("failed", word.problem)
        elif word.seconds is not None:
            self._report = replace(self._report, seconds=word.seconds, stop=word.stop)

    def _end(self, state: Literal["done", "failed"], problem: str) -> None:
        words = f"{problem[:1].upper()}{problem[1:].rstrip('.')}." if problem else ""
        self._report = replace(self._report, state=state, problem=words)


async def _tail(stream: asyncio.StreamReader) -> bytes:
    """The last that ``stream`` gives; read to its end, or its writer would stand still."""
    tail = b""
    while said := await stream.read(_TAIL_BYTES):
        tail = (tail + said)[-_TAIL_BYTES:]
    return tail


def _last_words(said: bytes) -> str:
    lines = [line.strip() for line in said.decode(errors="replace").splitlines() if line.strip(" ^~\t")]
    return lines[-1] if lines else ""
