"""The WebSocket ``/api/v1/face``: what a page that shows the robot's face needs, and nothing else.

Who looks at it is no viewer of the live stream: a screen on the robot keeps no camera awake.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Final

import msgspec
from fastapi import WebSocket

from app.console import reports
from app.console.live import protocol
from app.console.live.endpoint import send_from
from app.console.live.messages import FaceReport, Pong, VisitorLink
from app.console.live.outbox import Outbox
from app.console.live.visitor_link import NO_LINK
from app.console.taps import Tap
from app.console.wire import frame
from app.messages import JointState, Speech, TourProgress

if TYPE_CHECKING:
    from app.program.system import System

#: States of a tour in which people stand before the face, and may want to see more on their phones.
INVITES: Final = frozenset({"idle", "inviting", "confirming", "turning", "presenting", "listening", "answering"})
#: The actuator group of the face, as the body's file names it.
GROUP: Final = "face"


async def face(websocket: WebSocket, system: System, link: Callable[[str], VisitorLink]) -> None:
    """Serve one page until its connection ends, however it ends.

    ``link`` gives the way in for visitors' phones, to a page that reached the console at an address.
    """
    await websocket.accept()
    outbox = Outbox()
    group = system.link.description.groups.get(GROUP)
    names = frozenset(joint.name for joint in group.joints) if group is not None else frozenset[str]()

    def show(state: JointState) -> None:
        joints = {
            name: round(position, 4)
            for name, position in zip(state.names, state.positions, strict=True)
            if name in names
        }
        if joints:
            outbox.put("face", frame("face", FaceReport(state.stamp, joints)))

    def say(speech: Speech) -> None:
        outbox.put("speech", frame("speech", speech))

    def invite(progress: TourProgress) -> None:
        shown = link(_base(websocket)) if progress.state in INVITES else NO_LINK
        outbox.put("visitor_link", frame("visitor_link", shown))

    def answer(text: str) -> None:
        try:
            message = protocol.decode(text)
        except msgspec.DecodeError:
            return  # such a page can do nothing wrong
        if isinstance(message, protocol.PingMessage):
            outbox.put("pong", frame("pong", Pong(message.t, system.clock.now())))

    handlers: dict[str, Callable[[Any], None]] = {"joints": show, "speech": say, "tour_progress": invite}
    sending = asyncio.create_task(send_from(outbox, websocket), name="face")
    with ExitStack() as taps:
        for channel, handler in handlers.items():
            if channel in system.graph.channels:
                if (latest := reports.latest(system.graph, channel)) is not None:
                    handler(latest)
                taps.callback(Tap(system.graph.channel(channel), f"console.face.{channel}", handler).close)
        try:
            while (received := await websocket.receive())["type"] != "websocket.disconnect":
                answer(received.get("text") or "")
        finally:
            sending.cancel()
            await asyncio.wait({sending})


def _base(websocket: WebSocket) -> str:
    """The address by which a page reached the console, without a path."""
    return f"{'https' if websocket.url.scheme == 'wss' else 'http'}://{websocket.url.netloc}"
