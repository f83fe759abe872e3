"""The phones of a tour's visitors: the key of each run, what all of them are given, and their WebSocket.

A stream of its own: who watches is no viewer of the live stream and is given nothing else; a ping alone is answered.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

import msgspec
from fastapi import WebSocket

from app.console import reports
from app.console.access.auth import Door
from app.console.access.rate_limit import RateLimit
from app.console.live import protocol
from app.console.live.endpoint import send_from
from app.console.live.messages import Pong, VisitorView
from app.console.live.outbox import Outbox
from app.console.live.visitor_view import NOTHING, is_another_run, is_open, visitor_view
from app.console.taps import Tap
from app.console.wire import frame
from app.messages import Speech, TourProgress
from app.tours.model import Tour

if TYPE_CHECKING:
    from app.program.system import System

PROGRESS, SPEECH = "tour_progress", "speech"
#: Streams of visitors at once: operators' connections have room beside them.
MOST_STREAMS = 150
#: Of one phone, in as many windows.
MOST_OF_ONE = 3
#: A phone pings once a second.
MESSAGES_AT_ONCE, MESSAGES_PER_S = 20, 5.0


class TourVisitors:
    """Opens and closes the way in with each run (``door.visitors``), and gives every phone the newest view."""

    def __init__(self, system: System, door: Door) -> None:
        self._system = system
        self._door = door
        self._outboxes: set[Outbox] = set()
        self._progress: TourProgress | None = None
        self._said = ""
        self._view = NOTHING
        self._taps: ExitStack | None = None

    def open(self) -> Callable[[], None]:
        """Follow the tour from now on; returns what ends it."""
        stack = ExitStack()
        if PROGRESS in self._system.graph.channels:
            channel = self._system.graph.channel(PROGRESS)
            if channel.latest is not None:
                self._goes(channel.latest)
            stack.callback(channel.observe(self._goes))
        stack.callback(self._door.visitors.revoke)
        return stack.close

    @property
    def view(self) -> VisitorView:
        """What visitors see now."""
        return self._view

    @property
    def tour(self) -> Tour | None:
        """The tour that visitors are on; None: there is none."""
        run = self._system.tour_run
        return run.server.tour if run.available and is_open(self._progress) else None

    async def serve(self, websocket: WebSocket) -> None:
        """Serve one phone until its connection ends, however it ends."""
        session = self._door.visitor(websocket.scope)
        if len(self._outboxes) >= MOST_STREAMS or (session is not None and session.connections > MOST_OF_ONE):
            await websocket.close(1013, "too many visitors are connected")
            return
        await websocket.accept()
        outbox = Outbox()
        outbox.put("visitor", frame("visitor", self._view))
        limit = RateLimit(asyncio.get_running_loop().time, burst=MESSAGES_AT_ONCE, per_s=MESSAGES_PER_S)
        self._join(outbox)
        sending = asyncio.create_task(send_from(outbox, websocket), name="visitor")
        try:
            while (received := await websocket.receive())["type"] != "websocket.disconnect":
                if limit.wait_s(None) > 0:
                    await websocket.close(1008, "too many messages")
                    return
                self._answer(received.get("text") or "", outbox)
        finally:
            self._leave(outbox)
            sending.cancel()
            await asyncio.wait({sending})

    def _answer(self, text: str, outbox: Outbox) -> None:
        try:
            message = protocol.decode(text)
        except msgspec.DecodeError:
            return
        if isinstance(message, protocol.PingMessage):
            outbox.put("pong", frame("pong", Pong(message.t, self._system.clock.now())))

    # --- what comes in ---------------------------------------------------------------------------------------------

    def _join(self, outbox: Outbox) -> None:
        self._outboxes.add(outbox)
        if self._taps is None and SPEECH in self._system.graph.channels:
            self._taps = ExitStack()
            if (latest := reports.latest(self._system.graph, SPEECH)) is not None:
                self._speaks(latest)
            self._taps.callback(Tap(self._system.graph.channel(SPEECH), "console.visitors", self._speaks).close)

    def _leave(self, outbox: Outbox) -> None:
        self._outboxes.discard(outbox)
        if not self._outboxes and self._taps is not None:
            self._taps.close()
            self._taps, self._said = None, ""

    def _speaks(self, speech: Speech) -> None:
        self._said = speech.text if speech.state == "speaking" else ""
        self._show()

    def _goes(self, progress: TourProgress) -> None:
        before, self._progress = self._progress, progress
        if not is_open(progress):
            self._door.visitors.revoke()
        elif is_another_run(before, progress):
            self._door.visitors.renew()
        self._show()

    def _show(self) -> None:
        view = visitor_view(self._progress, self._said, self.tour)
        if view == self._view:
            return
        self._view = view
        text = frame("visitor", view)
        for outbox in self._outboxes:
            outbox.put("visitor", text)
