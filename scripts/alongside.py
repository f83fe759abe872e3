"""A command that runs beside others: its output is kept, then shown as it grows. Standard library only."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TextIO

#: Without output for this time (s) a command hangs: a test that hangs ends its process after 1800 s (pyproject.toml).
SILENT_AFTER_S = 2100.0
#: A Python program has this time (s) to print where its threads are.
ABORTING_S = 15.0


class Alongside:
    """A started command, the leader of a process group of its own."""

    def __init__(self, process: subprocess.Popen[str], output: TextIO) -> None:
        self._process = process
        self._output = output
        self._began = time.monotonic()
        self._took_s: float | None = None
        threading.Thread(target=self._await_end, daemon=True).start()

    def took_s(self) -> float:
        """How long (s) the command ran, or has run until now."""
        return time.monotonic() - self._began if self._took_s is None else self._took_s

    def _await_end(self) -> None:
        self._process.wait()
        self._took_s = time.monotonic() - self._began

    def running(self) -> bool:
        """Whether the command has not ended yet."""
        return self._process.poll() is None

    def show(self, *, to: TextIO | None = None, silent_after: float = SILENT_AFTER_S, period: float = 0.5) -> int:
        """Print what the command has printed and prints until it ends; return its status.

        A command that prints nothing for ``silent_after`` seconds is aborted: the Python programs of its group print
        the stacks of their threads (faulthandler, which pytest enables), and the status is not 0.
        """
        to = to or sys.stdout
        while True:
            ended = not self.running()
            self._copy(to)
            if ended:
                return self._process.returncode
            if time.time() - os.fstat(self._output.fileno()).st_mtime > silent_after:
                to.write(f"hbba: no output for {silent_after:.0f} s, so that it hangs; what its threads do:\n")
                to.flush()
                self.abort()
                self._copy(to)
                return self._process.returncode or 1
            time.sleep(period)

    def abort(self) -> None:
        """End the whole group with SIGABRT, on which Python programs print the stacks of their threads.

        The youngest first, one after another, so that the stacks do not mingle and children end before their parents.
        """
        for number in sorted(self._group(), reverse=True):
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGABRT)
            given_up = time.monotonic() + ABORTING_S
            while number in self._group() and time.monotonic() < given_up:
                time.sleep(0.05)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def _group(self) -> set[int]:
        """The processes of the group that have not ended, by Linux's /proc; elsewhere none."""
        members = set()
        for stat in Path("/proc").glob("[0-9]*/stat"):
            with contextlib.suppress(OSError):  # it has just ended
                state, _, group = stat.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()[:3]
                if int(group) == self._process.pid and state != "Z":
                    members.add(int(stat.parent.name))
        return members

    def _copy(self, to: TextIO) -> None:
        to.write(self._output.read())
        to.flush()


@contextmanager
def alongside(command: Sequence[object]) -> Iterator[Alongside]:
    """Start ``command``; what of its group still runs at the end is killed."""
    with NamedTemporaryFile("w+", encoding="utf-8", errors="replace") as kept:
        process = subprocess.Popen(
            [str(word) for word in command],
            stdin=subprocess.DEVNULL,
            stdout=kept,
            stderr=subprocess.STDOUT,
            process_group=0,  # not a session: the scheduler would give it a share of its own, whatever its niceness
            text=True,
        )
        # A description of its own: the command's writes must not move where we read.
        with open(kept.name, encoding="utf-8", errors="replace") as output:
            started = Alongside(process, output)
            try:
                yield started
            finally:
                if started.running():
                    started.abort()
