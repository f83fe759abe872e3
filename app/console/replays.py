"""Replays started from the page: ``hbba replay`` in a process of its own, one at a time, with a console of its own."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import re
import shutil
import signal
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from app.base.child_processes import python
from app.console.access.token import VARIABLE

#: A long recording is indexed before its console is up.
START_WITHIN_S = 60.0
#: A replay has nothing to lose: it is not waited for long.
STOP_WITHIN_S = 0.6
#: It ends by itself so long after its last viewer left.
UNWATCHED_S = 180.0
_TAIL_BYTES = 8192
_URL = re.compile(rb"(https?://\S+)\s")

log = logging.getLogger(__name__)


class ReplayFailed(Exception):
    """The replay did not start; the message is its last word, or why there is none."""


class ReplayReplaced(ReplayFailed):
    """Another replay was asked for before this one was up."""


class Replays:
    """At most one replay at a time; :meth:`close` ends it with the console.

    ``host`` is where its console listens; ``token`` what it asks for, as this one does, and ``names`` the host names it
    answers to besides. ``command`` is what to run, followed by the options, ``options`` among them, and the recording's
    path.
    """

    def __init__(
        self,
        host: str,
        token: str | None,
        names: Sequence[str] = (),
        *,
        command: Sequence[str] = (),
        options: Sequence[str] = (),
    ) -> None:
        self._host = host
        self._token = token
        self._names = names
        self._options = options
        self.command = command or python("-m", "app.console.replay_process", str(os.getpid()))
        self._child: _Child | None = None
        self._turn = asyncio.Lock()

    @property
    def current(self) -> tuple[str, str] | None:
        """Name and URL of the replay that runs, if one does."""
        child = self._child
        return None if child is None or child.ended or child.url is None else (child.name, child.url)

    def replays(self, name: str) -> bool:
        """Whether a replay of the recording ``name`` runs, or is about to."""
        return self._child is not None and not self._child.ended and self._child.name == name

    async def start(self, name: str, path: Path) -> str:
        """Replay the recording ``name`` at ``path`` instead of any other; returns its URL once it is up.

        Raises ReplayFailed.
        """
        async with self._turn:
            await self._end_current(replaced=True)
            options = ["--port", "0", "--scene-port", "0", "--host", self._host]
            options += ["--exit-when-unwatched", f"{UNWATCHED_S:g}"]
            options += [option for name in self._names for option in ("--host-name", name)]
            options += self._options
            environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
            if self._token is not None:
                # No other user can read the environment of a process; every user can read its arguments.
                environment[VARIABLE] = self._token
            child = self._child = await _Child.spawn(name, [*self.command, *options, "--", str(path)], environment)
        try:
            async with asyncio.timeout(START_WITHIN_S):
                return await child.wait_url()
        except TimeoutError:
            await child.end()
            raise ReplayFailed(f"it was not up within {START_WITHIN_S:.0f} s") from None
        except asyncio.CancelledError:
            await child.end()
            raise

    async def end(self, name: str) -> bool:
        """End the replay of ``name``; False if there is none."""
        async with self._turn:
            if self._child is None or self._child.ended or self._child.name != name:
                return False
            await self._end_current()
            return True

    async def close(self) -> None:
        async with self._turn:
            await self._end_current()

    async def _end_current(self, *, replaced: bool = False) -> None:
        child, self._child = self._child, None
        if child is not None:
            await child.end(replaced=replaced)


class _Child:
    """One replay's process: what it says, and its end."""

    def __init__(self, name: str, process: asyncio.subprocess.Process, folder: str) -> None:
        self.name = name
        self._folder = folder
        self.url: str | None = None
        self._process = process
        self._up: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._replaced = False
        self._said = b""
        self._following = asyncio.create_task(self._follow(), name=f"replay of {name}")

    @staticmethod
    async def spawn(name: str, command: Sequence[str], environment: dict[str, str]) -> _Child:
        """Start it, with a folder for its temporary files. Raises ReplayFailed."""
        try:
            folder = await asyncio.to_thread(tempfile.mkdtemp, prefix="hbba-replays-")
        except OSError as failure:
            raise ReplayFailed(f"there is no room for what it needs: {failure.strerror}") from None
        try:
            process = await asyncio.create_subprocess_exec(
                *command, env={**environment, "TMPDIR": folder}, stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE, start_new_session=True,
            )  # fmt: skip
        except OSError as failure:
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)
            raise ReplayFailed(f"its process cannot be started: {failure.strerror}") from None
        return _Child(name, process, folder)

    @property
    def ended(self) -> bool:
        return self._following.done()

    async def wait_url(self) -> str:
        """Wait until its console is up. Raises ReplayFailed if it ends before."""
        both: set[asyncio.Future[Any]] = {self._up, self._following}
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        if self._up.done():
            return self._up.result()
        if self._replaced:
            raise ReplayReplaced("another replay was asked for before this one was up")
        raise ReplayFailed(self._last_words())

    async def end(self, *, replaced: bool = False) -> None:
        """Ask it to end, and see to it that it does."""
        self._replaced = replaced
        if self.ended:
            return
        with contextlib.suppress(ProcessLookupError):
            self._process.terminate()
        await asyncio.wait({self._following}, timeout=STOP_WITHIN_S)
        if not self.ended:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            await self._following

    async def _follow(self) -> None:
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        # Both are read to the end, or it would stand still once a pipe is full.
        await asyncio.gather(self._hear(self._process.stdout), self._note(self._process.stderr))
        status = await self._process.wait()
        # One that had to be killed leaves behind what it had there.
        await asyncio.to_thread(shutil.rmtree, self._folder, ignore_errors=True)
        log.info("the replay of %s ended with status %d", self.name, status)

    async def _hear(self, stdout: asyncio.StreamReader) -> None:
        heard = b""
        while said := await stdout.read(_TAIL_BYTES):
            if self.url is not None:
                continue
            heard = (heard + said)[-_TAIL_BYTES:]
            if (found := _URL.search(heard)) is not None:
                self.url = found[1].decode(errors="replace")
                self._up.set_result(self.url)

    async def _note(self, stderr: asyncio.StreamReader) -> None:
        while said := await stderr.read(_TAIL_BYTES):
            self._said = (self._said + said)[-_TAIL_BYTES:]

    def _last_words(self) -> str:
        lines = [line.strip() for line in self._said.decode(errors="replace").splitlines() if line.strip(" ^~\t")]
        if lines:
            return lines[-1].removeprefix("hbba replay: ")
        return f"it ended with status {self._process.returncode} and said nothing"


def reached_by(url: str, scheme: str, host: str | None) -> str:
    """``url`` of a console on this computer, for a client that reached this one under ``host``."""
    parts = urlsplit(url)
    name = host or parts.hostname or "127.0.0.1"
    name = f"[{name}]" if ":" in name else name
    return parts._replace(scheme=scheme, netloc=f"{name}:{parts.port}").geturl()
