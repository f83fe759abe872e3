"""The process in the graph, as the program sees it: started, sent frames, read, and its end noticed."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from app.base.child_processes import python
from app.modules.viewers.ros2.protocol import Frames, Open, Ready, Stop, ToProcess, ToProgram, encode

START_TIMEOUT_S = 25.0
_STOP_TIMEOUT_S = 1.0
#: Bytes that the process may leave unread before messages are left out.
_UNSENT_BYTES = 16 << 20


class GraphProcessFailed(Exception):
    """The process ended, or did not start; the message is for people."""


class GraphProcess(asyncio.Protocol):
    """One run of the process."""

    def __init__(self) -> None:
        loop = asyncio.get_running_loop()
        self._receive: Callable[[ToProgram], None] | None = None
        self._early: list[ToProgram] = []
        self._frames = Frames(ToProgram)  # type: ignore[arg-type]  # a union of types
        self._ready: asyncio.Future[Ready] = loop.create_future()
        self.ended: asyncio.Future[str] = loop.create_future()
        """Done with the reason, in words, when it has ended."""
        self._transport: asyncio.Transport | None = None
        self._last_lines: deque[str] = deque(maxlen=4)
        self._process: asyncio.subprocess.Process
        self._watch: asyncio.Task[None]

    @staticmethod
    async def start(open: Open, environment: Mapping[str, str]) -> tuple[GraphProcess, Ready]:
        """Run it until all is offered; what it says then waits for :meth:`listen`.

        Raises GraphProcessFailed, having released everything.
        """
        ours, theirs = socket.socketpair()
        run = GraphProcess()
        try:
            run._process = await asyncio.create_subprocess_exec(
                *python("-m", "app.modules.viewers.ros2.process", str(theirs.fileno())), pass_fds=(theirs.fileno(),),
                stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE,
                env=os.environ | dict(environment), start_new_session=True,
            )  # fmt: skip
        except OSError as failure:
            ours.close()
            raise GraphProcessFailed(f"its process cannot be started: {failure.strerror}") from None
        finally:
            theirs.close()
        run._watch = asyncio.create_task(run._follow(), name="process in the graph of ROS 2")
        await asyncio.get_running_loop().create_connection(lambda: run, sock=ours)
        run.send(open)
        try:
            async with asyncio.timeout(START_TIMEOUT_S):
                either: set[asyncio.Future[Any]] = {run._ready, run.ended}
                await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
        except TimeoutError:
            await run.close()
            raise GraphProcessFailed(f"its process did not start in {START_TIMEOUT_S:.0f} s") from None
        except asyncio.CancelledError:
            await run.close()
            raise
        if run.ended.done():
            await run.close()
            raise GraphProcessFailed(run.ended.result())
        return run, run._ready.result()

    def listen(self, receive: Callable[[ToProgram], None]) -> None:
        """Have ``receive`` called with what it has said since it was ready, and says from now on."""
        self._receive = receive
        early, self._early = self._early, []
        for message in early:
            receive(message)

    @property
    def is_behind(self) -> bool:
        """Whether it leaves so much unread that what is published is to be left out."""
        return self._transport is not None and self._transport.get_write_buffer_size() > _UNSENT_BYTES

    @property
    def process_id(self) -> int:
        """Its id."""
        return self._process.pid

    def send(self, message: ToProcess) -> None:
        """Send it a frame; nothing once it has ended."""
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(encode(message))

    async def close(self) -> None:
        """Let it leave the graph for a moment, then kill it."""
        self.send(Stop())
        try:
            async with asyncio.timeout(_STOP_TIMEOUT_S):
                await asyncio.shield(self._watch)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            await self._watch
        finally:
            if self._transport is not None:
                self._transport.abort()

    # asyncio.Protocol

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        for message in self._frames.feed(data):
            if isinstance(message, Ready):
                self._ready.set_result(message)
            elif self._receive is None:
                self._early.append(message)  # type: ignore[arg-type]  # of the process's side
            else:
                self._receive(message)  # type: ignore[arg-type]

    async def _follow(self) -> None:
        assert self._process.stderr is not None
        async for line in self._process.stderr:
            self._last_lines.append(line.decode(errors="replace").rstrip())
        status = await self._process.wait()
        last = self._last_lines[-1] if self._last_lines else ""
        by = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
        self.ended.set_result(last if status == 1 and last else f"its process {by}{f': {last}' if last else ''}")
