"""The WebSocket ``/api/v1/live``: one task reads what the page says, one sends what waits for it."""

from __future__ import annotations

import asyncio

import msgspec
from fastapi import WebSocket
from starlette.websockets import WebSocketDisconnect

from app.console.access.identity import identity_of
from app.console.access.operators import operator_name
from app.console.drive import drive_lease
from app.console.live import protocol
from app.console.live.hub import Hub
from app.console.live.may import permits
from app.console.live.messages import Pong
from app.console.live.outbox import Outbox
from app.console.live.viewer import Viewer
from app.console.wire import frame
from app.runtime.clock import Clock

#: How a binary frame of an operator's voice begins.
VOICE = bytes([protocol.VOICE])


async def live(websocket: WebSocket, hub: Hub, clock: Clock) -> None:
    """Serve one page until its connection ends, however it ends."""
    await websocket.accept()
    identity = identity_of(websocket.scope)
    assert identity is not None
    viewer = hub.join(operator_name(websocket.query_params.get("operator")), identity)
    sending = asyncio.create_task(send_from(viewer.outbox, websocket), name=f"live {viewer.session}")
    try:
        while True:
            message = await websocket.receive()
            if message["type"] == "websocket.disconnect":
                return
            binary = message.get("bytes")
            if binary is not None and binary[:1] == VOICE:
                if not permits(viewer, "voice", hub.notify):
                    continue
                hub.speech.hear(viewer.session, viewer.operator, binary)
            else:
                _take(message.get("text") or binary or b"", viewer, hub, clock)
    finally:
        # Before anything that could wait: a driver is stopped.
        hub.leave(viewer)
        sending.cancel()
        await asyncio.wait({sending})


async def send_from(outbox: Outbox, websocket: WebSocket) -> None:
    """Send what waits in ``outbox``, as it comes, until the connection ends."""
    try:
        while True:
            taken = await outbox.take()
            if isinstance(taken, str):
                await websocket.send_text(taken)
            else:
                await websocket.send_bytes(taken)
    except WebSocketDisconnect:
        # The reader sees the end too, and says so.
        return


def _limited(axis: float, share: float) -> float:
    """An axis of the stick, slowed to ``share``; one out of range stays so, and is refused."""
    return share * axis if -1.0 <= axis <= 1.0 else axis


def _take(text: str | bytes, viewer: Viewer, hub: Hub, clock: Clock) -> None:
    """Act on one message of the page."""
    driving, session, now = hub.driving, viewer.session, clock.now()
    try:
        message = protocol.decode(text)
    except msgspec.DecodeError:
        driving.handle(drive_lease.Garbled(session))
        return
    lasting = isinstance(message, protocol.DriveMessage) and (message.held or message.head_held)
    if not permits(viewer, str(message.__struct_config__.tag), hub.notify, lasting=lasting):
        return
    match message:
        case protocol.DriveMessage():
            judged = viewer.age.judge(now, protocol.times(message))
            driving.handle(
                drive_lease.Drive(
                    session,
                    message.seq,
                    held=message.held,
                    linear=_limited(message.linear, judged.share),
                    angular=_limited(message.angular, judged.share),
                    override=message.override,
                    lateral=_limited(message.lateral, judged.share),
                    head_held=message.head_held,
                    pan=message.pan,
                    tilt=message.tilt,
                    cause=judged.cause,
                    lasting=judged.lasting,
                )
            )
        case protocol.LookMessage():
            judged = viewer.age.judge(now, protocol.times(message))
            driving.look(session, judged, stamp=message.stamp, u=message.u, v=message.v)
        case protocol.PingMessage():
            viewer.rtt_ms = message.rtt_ms
            viewer.round_trip(asyncio.get_running_loop().time())
            viewer.age.judge(now, protocol.times(message))
            driving.handle(drive_lease.KeepAlive(session))
            viewer.outbox.put("pong", frame("pong", Pong(message.t, now)))
        case protocol.AckMessage():
            viewer.drawn(message.kind, asyncio.get_running_loop().time())
        case protocol.ViewMessage():
            if message.camera_px is not None:
                viewer.widths[protocol.CAMERA] = message.camera_px
            if message.vp9 is not None:
                viewer.vp9 = message.vp9
            hub.show(viewer, protocol.CAMERA, message.camera)
            hub.show(viewer, protocol.PANORAMA, message.panorama)
            hub.show(viewer, protocol.MAP, message.map)
            hub.show(viewer, protocol.COSTMAP, message.costmap)
        case protocol.ListenMessage():
            hub.listen(viewer, message.on)
        case protocol.EStopMessage():
            driving.e_stop(viewer.operator, session, by=viewer.identity)
        case protocol.ClearEStopMessage():
            judged = viewer.age.judge(now, protocol.times(message))
            driving.release_e_stop(session, judged, message.heard, by=viewer.identity)
        case protocol.TakeControlMessage():
            driving.take_control(session, viewer.age.judge(now, protocol.times(message)))
        case protocol.AskControlMessage():
            driving.ask_control(session, viewer.age.judge(now, protocol.times(message)))
        case protocol.AnswerControlMessage():
            driving.handle(drive_lease.AnswerControl(session, message.give))
        case protocol.ReleaseControlMessage():
            driving.handle(drive_lease.ReleaseControl(session))
