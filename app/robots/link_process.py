"""The process of a body, as the program sees it: started, sent frames, read, and its end noticed at once."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import socket
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from app.base.child_processes import python
from app.link import LinkFailed
from app.robots.link_protocol import FrameReader, Sample, encode

STOP_TIMEOUT_S = 0.6
#: Bytes that a process may leave unread before commands to it are dropped: they would arrive too late.
UNSENT_BYTES = 4096
#: The exit status of a process whose last line says to people why it ended.
REFUSED = 3
_LAST_LINES = 12

log = logging.getLogger(__name__)


class LinkProcess(asyncio.Protocol):
    """One run of a body's process: its socket and error output. ``title`` names the body in messages."""

    def __init__(self, title: str, receive: Callable[[Any], None]) -> None:
        self._title = title
        self._receive = receive
        self._reader = FrameReader()
        self._running = asyncio.Event()
        self._transport: asyncio.Transport | None = None
        self._ended = asyncio.get_running_loop().create_future()
        self._expected = False
        self._last_lines: deque[str] = deque(maxlen=_LAST_LINES)
        #: Result of the start: an error before the process runs is raised in the waiting start().
        self._held_lines: list[str] = []
        self.process: asyncio.subprocess.Process
        self._watch: asyncio.Task[None]

    @staticmethod
    async def open(
        title: str,
        module: str,
        receive: Callable[[Any], None],
        *,
        descriptors: Sequence[int] = (),
        environment: Mapping[str, str] | None = None,
    ) -> LinkProcess:
        """Run ``python -m module SOCKET *descriptors`` with a socket of its own; it inherits the ``descriptors``.

        ``environment`` is added to this process's own. Raises LinkFailed.
        """
        ours, theirs = socket.socketpair()
        try:
            session = LinkProcess(title, receive)
            passed = (theirs.fileno(), *descriptors)
            session.process = await asyncio.create_subprocess_exec(
                *python("-m", module, *map(str, passed)), pass_fds=passed, stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE,
                env=os.environ | dict(environment or {}), start_new_session=True,
            )  # fmt: skip
        except OSError as failure:
            ours.close()
            raise LinkFailed(f"The {title}'s process cannot be started: {failure.strerror}.") from None
        finally:
            theirs.close()
        session._watch = asyncio.create_task(session._watch_process(), name=f"link of the {title}")
        await asyncio.get_running_loop().create_connection(lambda: session, sock=ours)
        return session

    @property
    def ended(self) -> bool:
        return self._ended.done()

    @property
    def unsent_bytes(self) -> int:
        """Bytes the process has not read yet, beyond what the socket holds."""
        return self._transport.get_write_buffer_size() if self._transport is not None else 0

    def send(self, frame: Any) -> None:
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(encode(frame))

    def expect_end(self) -> None:
        self._expected = True

    async def wait_running(self) -> None:
        """Wait for the first sample; raises LinkFailed if the process ends before."""
        running = asyncio.ensure_future(self._running.wait())
        try:
            await asyncio.wait({running, self._ended}, return_when=asyncio.FIRST_COMPLETED)
            if self._ended.done():
                raise self._ended.result()
        finally:
            running.cancel()

    async def wait_failed(self) -> LinkFailed:
        failure: LinkFailed = await asyncio.shield(self._ended)
        return failure

    async def close(self) -> None:
        """Let the process end by itself for a moment, then kill it; release the socket."""
        self._expected = True
        try:
            async with asyncio.timeout(STOP_TIMEOUT_S):
                await asyncio.shield(self._watch)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                self.process.kill()
            await self._watch
        finally:
            if self._transport is not None:
                self._transport.abort()

    # asyncio.Protocol

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        for frame in self._reader.feed(data):
            if isinstance(frame, Sample) and not self._running.is_set():
                self._running.set()
                self._notify_held()
            self._receive(frame)

    async def _watch_process(self) -> None:
        """Follow the process's standard error and wait for its end."""
        assert self.process.stderr is not None
        async for raw in self.process.stderr:
            line = raw.decode(errors="replace").rstrip()
            self._last_lines.append(line)
            self._held_lines.append(line)
            if self._running.is_set():
                self._notify_held()
        status = await self.process.wait()
        sentence = self._sentence(status)
        if sentence is None:
            self._notify_held()
        failure = LinkFailed(sentence or self._exit_reason(status))
        if not self._expected and self._running.is_set():
            log.error("%s", failure)
        self._ended.set_result(failure)

    def _notify_held(self) -> None:
        for line in self._held_lines:
            log.warning("%s: %s", self._title, line)
        self._held_lines.clear()

    def _words(self) -> list[str]:
        return [line.strip() for line in self._last_lines if line.strip(" ^~")]

    def _sentence(self, status: int) -> str | None:
        """The process's error message for people, if it ended with one."""
        words = self._words()
        if status == REFUSED and words:
            return words[-1]
        return words[0] if status == 1 and len(words) == 1 else None

    def _exit_reason(self, status: int) -> str:
        how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
        words = self._words()
        said = "; its last words: " + " | ".join(words[-3:]) if words else ""
        return f"The {self._title}'s process {how}{said}."
