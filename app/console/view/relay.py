"""``/viser/``: viser's page and its WebSocket behind our own door, and the pulse that measures each viewer's lag.

From the page only camera messages go on to viser: the rest of its protocol (uploads, its public tunnel) is not for
viewers.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import logging
import math
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, TypeAlias

import msgspec
import websockets
from fastapi import APIRouter, Request, WebSocket
from fastapi.responses import HTMLResponse, Response
from starlette.types import Scope
from starlette.websockets import WebSocketDisconnect
from websockets.asyncio.client import ClientConnection

from app.console.view.budget import SILENT_AFTER_S
from app.console.view.view import View
from app.console.view.viewer_session import ViewerSession
from app.console.view.viewpoints import Viewpoint

PULSE_PERIOD_S = 0.25
CAMERA_PERIOD_S = 0.2
#: Messages that a viewer may send to viser.
FORWARDED = frozenset({"ViewerCameraMessage"})
_PROTOCOL = "viser-v"

log = logging.getLogger("hbba.view")

#: In its place the origin of the page around the view is written, which is made of a host's name and a port alone.
_PAGE_ORIGIN = "{page origin}"
_INJECTED = (Path(__file__).parent / "inject.html").read_text(encoding="utf-8")


class Layers(msgspec.Struct, tag_field="type", tag="layers"):
    """Layers that a viewer wants besides those of all; None: what the pages show."""

    costmap: bool | None = None


class Look(msgspec.Struct, tag_field="type", tag="viewpoint"):
    """The viewer shall look from ``viewpoint``; the ``number`` is another for each choice. Its glide goes as far as the
    share ``hold`` of its time, for pictures of it; the same number with another goes on."""

    viewpoint: Viewpoint
    number: int
    hold: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 1.0


class SoftLimit(msgspec.Struct, tag_field="type", tag="soft_limit"):
    """The head follows the view as far as ``angle`` (rad) aside; None: it does not."""

    angle: Annotated[float, msgspec.Meta(gt=0.0, le=math.pi)] | None = None


class Grab(msgspec.Struct, tag_field="type", tag="grab"):
    """The viewer's user takes the camera in hand."""


Wish: TypeAlias = Layers | Look | SoftLimit | Grab
_wish: msgspec.json.Decoder[Wish] = msgspec.json.Decoder(Wish)


def wish_of(frame: str | bytes) -> Wish | None:
    """What a frame of the pulse asks for; None if it asks for nothing."""
    try:
        return _wish.decode(frame)
    except msgspec.DecodeError:
        return None


class _Typed(msgspec.Struct):
    type: str


_typed = msgspec.msgpack.Decoder(_Typed)


def allowed(frame: bytes) -> bool:
    """Whether a frame of the page goes on to viser."""
    try:
        return _typed.decode(frame).type in FORWARDED
    except msgspec.DecodeError:
        return False


def viewer_page() -> tuple[str, str]:
    """viser's page, before and after our addition at its head. Reads a file; for a worker thread."""
    found = importlib.util.find_spec("viser")
    assert found is not None
    assert found.origin is not None
    page = (Path(found.origin).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    head, tag, rest = page.partition("<head>")
    return head + tag, rest


def view_router(view: View, page_origin: Callable[[Scope], str | None] = lambda _: None) -> APIRouter:
    """Routes of ``/viser``. ``page_origin`` gives the origin of the page that may speak with the view that a request
    asks for; None: its own."""
    router = APIRouter(include_in_schema=False)
    pages: list[tuple[str, str]] = []

    @router.get("/viser")
    @router.get("/viser/")
    async def page(request: Request) -> Response:
        if not pages:
            pages.append(await asyncio.to_thread(viewer_page))
        head, rest = pages[0]
        return HTMLResponse(head + _INJECTED.replace(_PAGE_ORIGIN, page_origin(request.scope) or "") + rest)

    @router.websocket("/viser")
    async def scene(websocket: WebSocket) -> None:
        protocol = next((p for p in websocket.scope["subprotocols"] if p.startswith(_PROTOCOL)), None)
        if protocol is None:
            await websocket.close(1002)
            return
        await websocket.accept(subprotocol=protocol)
        session = view.enter(_viewer(websocket))
        try:
            await _relay(websocket, view, session, protocol)
        finally:
            view.leave(session)

    @router.websocket("/viser/pulse")
    async def pulse(websocket: WebSocket) -> None:
        await websocket.accept()
        session = view.enter(_viewer(websocket))

        def wished(wish: Wish) -> None:
            match wish:
                case Layers(costmap):
                    view.set_layers(session, costmap)
                case Look(viewpoint, number, hold):
                    view.choose(session, viewpoint, number, hold)
                case SoftLimit(angle):
                    view.limit(session, angle)
                case Grab():
                    view.grab(session)

        cameras = asyncio.create_task(_report_camera(websocket, session), name="console view camera")
        try:
            await _pulse(
                websocket,
                session,
                lambda round_trip_s, frames_s: view.answered(session, round_trip_s, frames_s),
                wished,
            )
        except WebSocketDisconnect:
            return
        finally:
            cameras.cancel()
            await asyncio.wait({cameras})
            view.leave(session)

    return router


def _viewer(websocket: WebSocket) -> str:
    """The viewer's own name for itself, which joins its two connections."""
    given = websocket.query_params.get("viewer", "")
    return given[:32] if given.isalnum() else "unnamed"


async def _relay(websocket: WebSocket, view: View, session: ViewerSession, protocol: str) -> None:
    """Carry frames both ways until either end closes."""
    viser_port = await view.port()
    if viser_port is None:
        await websocket.close(1011, "the 3D view failed")
        return
    sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    sock.setblocking(False)
    # Bound before it connects: the view admits connections by their local port.
    sock.bind(("127.0.0.1", 0))
    port = sock.getsockname()[1]
    view.admit(port, session.viewer)
    try:
        await asyncio.get_running_loop().sock_connect(sock, ("127.0.0.1", viser_port))
        async with websockets.connect(
            f"ws://127.0.0.1:{viser_port}",
            sock=sock,
            subprotocols=[websockets.Subprotocol(protocol)],
            compression=None,
            max_size=None,
            # Nothing is hoarded here: viser itself keeps the newest until there is room.
            max_queue=1,
            ping_interval=None,
            close_timeout=0.2,
            proxy=None,
        ) as viser:
            tasks = [asyncio.create_task(_down(viser, websocket, session)), asyncio.create_task(_up(websocket, viser))]
            try:
                await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for task in tasks:
                    task.cancel()
                await asyncio.wait(tasks)
            for task in tasks:
                if not task.cancelled():
                    task.result()
    finally:
        view.dismiss(port)
        sock.close()


async def _down(viser: ClientConnection, websocket: WebSocket, session: ViewerSession) -> None:
    try:
        async for frame in viser:
            began = time.monotonic()
            if isinstance(frame, bytes):
                await websocket.send_bytes(frame)
                session.sent_bytes += len(frame)
            # How long it waited for room: what is sent now will arrive that much late.
            session.drain_s = max(time.monotonic() - began, 0.8 * session.drain_s)
        await websocket.close(1012)
    except websockets.ConnectionClosedError as closed:
        said = closed.rcvd or websockets.frames.Close(1012, "")
        log.warning("viser ended the 3D view of %s: %s", session.viewer, closed)
        with contextlib.suppress(WebSocketDisconnect):
            await websocket.close(said.code, said.reason)
    except WebSocketDisconnect:
        return


async def _up(websocket: WebSocket, viser: ClientConnection) -> None:
    try:
        while (frame := await _received(websocket)) is not None:
            if isinstance(frame, bytes) and allowed(frame):
                await viser.send(frame)
    except websockets.ConnectionClosed:
        return


async def _received(websocket: WebSocket) -> str | bytes | None:
    """The page's next message; None when it has closed."""
    message = await websocket.receive()
    if message["type"] == "websocket.disconnect":
        return None
    frame: str | bytes = message.get("bytes") or message.get("text") or ""
    return frame


async def _report_camera(websocket: WebSocket, session: ViewerSession) -> None:
    """Say from where the viewer looks, whenever that changes and again and again: what follows it counts on that.

    Ends with the connection, or when it is cancelled.
    """
    while True:
        if session.camera is not None:
            try:
                await websocket.send_text(msgspec.json.encode(session.camera).decode())
            except (WebSocketDisconnect, RuntimeError):
                return  # closed in the meantime
        session.changed.clear()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(CAMERA_PERIOD_S):
                await session.changed.wait()


async def _pulse(
    websocket: WebSocket,
    session: ViewerSession,
    answered: Callable[[float | None, float], None],
    wished: Callable[[Wish], None],
) -> None:
    """Ask the page again and again for an answer two frames on, and time it; ends with the connection.

    With it goes of when the robot is that the page has by then. In between the page may say what it wants to see, and
    from where.
    """
    number = 0
    while True:
        number += 1
        began = time.monotonic()
        # What was drawn for it meanwhile is on its way as long as the frame before it waited for room.
        shown = "" if session.stamp is None else f" {session.stamp - session.drain_s:.3f}"
        await websocket.send_text(f"{number}{shown}")
        try:
            async with asyncio.timeout(SILENT_AFTER_S):
                while (frames_s := _answer(frame := await _received(websocket), number)) is None:
                    if frame is None:
                        return
                    if (wish := wish_of(frame)) is not None:
                        wished(wish)
        except TimeoutError:
            answered(None, 0.0)
            continue
        answered(time.monotonic() - began, frames_s)
        if not await _listen(websocket, wished, PULSE_PERIOD_S - (time.monotonic() - began)):
            return


async def _listen(websocket: WebSocket, wished: Callable[[Wish], None], lasting_s: float) -> bool:
    """Take what the page wishes for ``lasting_s``; returns whether it is still there."""
    try:
        async with asyncio.timeout(lasting_s):
            while (frame := await _received(websocket)) is not None:
                if (wish := wish_of(frame)) is not None:
                    wished(wish)
            return False
    except TimeoutError:
        return True


def _answer(frame: str | bytes | None, number: int) -> float | None:
    """The time (s) two frames took, from an answer ``number milliseconds``; None if it is not the answer awaited."""
    first, _, second = frame.partition(" ") if isinstance(frame, str) else ("", "", "")
    if first != str(number):
        return None
    return min(float(second) / 1e3, SILENT_AFTER_S) if second.replace(".", "", 1).isdecimal() else 0.0
