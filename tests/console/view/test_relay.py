"""viser behind our own door: really served, really relayed."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import logging
import math
from collections.abc import AsyncIterator, Iterable
from pathlib import Path
from typing import Any

import httpx
import msgspec
import numpy as np
import psutil
import pytest
import viser
import websockets
import zstandard
from fastapi import FastAPI
from viser import _messages

from app.base.geometry import Pose2, Pose3
from app.base.kinematic_model import load_model
from app.console.view.relay import allowed
from app.console.view.view import View
from app.messages import (
    ExternalForce,
    ExternalForces,
    JointState,
    Landmark,
    Landmarks,
    LaserScan,
    LoudNoise,
    Odometry,
    PointCloud,
)
from app.program.system import System
from tests.console.percepts import faces, sound_source, sound_sources
from tests.console.program import Body
from tests.patience import PATIENCE_S

PROTOCOL = f"viser-v{viser.__version__}"
CAMERA = _messages.ViewerCameraMessage(
    wxyz=(1.0, 0.0, 0.0, 0.0),
    position=(0.0, 0.0, 1.0),
    fov=1.0,
    near=0.01,
    far=100.0,
    image_height=400,
    image_width=640,
    look_at=(0.0, 0.0, 0.0),
    up_direction=(0.0, 0.0, 1.0),
)
# viser's own threads take locks and files as they like; only our event loop must not wait.
pytestmark = pytest.mark.filterwarnings("default::DeprecationWarning")


def pack(message: _messages.Message) -> bytes:
    """A message as viser's page sends it."""
    return msgspec.msgpack.encode(message.as_serializable_dict())


def unpack(frame: bytes) -> list[dict[str, Any]]:
    """The messages of one frame as viser's page reads them."""
    size = int.from_bytes(frame[8:16], "little")
    window = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(frame[16 : 16 + size]))
    return list(window["messages"])


class Viewer:
    """viser's page without a browser."""

    def __init__(self, connection: websockets.ClientConnection) -> None:
        self.connection = connection
        self.seen: list[dict[str, Any]] = []

    async def until(self, *wanted: tuple[str, str | None]) -> None:
        """Read until each wanted (message type, node name) has come."""
        left = set(wanted)
        async with asyncio.timeout(PATIENCE_S):
            while left:
                for message in unpack(await self.connection.recv(decode=False)):
                    self.seen.append(message)
                    left -= {(message["type"], message.get("name")), (message["type"], None)}


@contextlib.asynccontextmanager
async def looking(url: str, name: str = "abc", **options: Any) -> AsyncIterator[Viewer]:
    """A page that looks, known to viser as soon as it has sent its camera."""
    async with websockets.connect(
        f"{url.replace('http', 'ws')}/viser?viewer={name}",
        subprotocols=[websockets.Subprotocol(PROTOCOL)],
        max_queue=None,
        max_size=None,
        proxy=None,
        close_timeout=1,
        **options,
    ) as connection:
        await connection.send(pack(CAMERA))
        yield Viewer(connection)


@pytest.fixture
def view(app: FastAPI) -> View:
    found: View = app.state.view
    return found


async def test_the_page_is_visers_with_our_addition_before_its_code(url: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=url) as client:
        response = await client.get("/viser/")
    assert response.status_code == 200
    assert response.headers["content-type"].startswith("text/html")
    assert "frame-ancestors 'self'" in response.headers["content-security-policy"]
    page = response.text
    assert page.index("document.hasFocus = () => true") < page.index("data-p=")
    assert "<title>Viser</title>" in page


async def test_a_viewer_is_shown_the_robot_and_what_it_perceives(url: str, system: System, body: Body) -> None:
    async with looking(url) as viewer:
        await viewer.until(("GridMessage", "/odom/floor"), ("MeshMessage", None), ("PointCloudMessage", "/odom/cloud"))
        feeding = asyncio.create_task(feed(system, body))
        await viewer.until(
            ("SetPositionMessage", "/odom"),
            ("SceneNodeUpdateMessage", "/odom/scan"),
            ("SceneNodeUpdateMessage", "/odom/cloud"),
            ("BoxMessage", "/odom/map/landmark_0"),
            ("LabelMessage", "/odom/map/landmark_0/text"),
        )
        feeding.cancel()
    moved = [m["position"] for m in viewer.seen if m["type"] == "SetPositionMessage" and m["name"] == "/odom"]
    # The world hangs below the robot's inverse pose: 1 m ahead and turned left by 90° is 1 m to the right, behind.
    inverse = Pose2(1.0, 0.0, math.pi / 2).inverse()
    np.testing.assert_allclose(moved[-1], (inverse.x, inverse.y, 0.0), atol=1e-6)
    clouds = [m["position"] for m in viewer.seen if m["type"] == "SetPositionMessage" and m["name"] == "/odom/cloud"]
    # In the pose of its own instant, not in the newest.
    np.testing.assert_allclose(clouds[-1], (0.25, 0.5, 0.0), atol=1e-6)


async def test_a_force_on_a_hand_is_drawn_on_the_robot_and_gone_with_what_estimates_it(
    url: str, system: System, body: Body
) -> None:
    pushed = (ExternalForce("left_hand_link", (0.3, 0.2, 0.6), (-10.0, 0.0, 0.0)),)

    async def push() -> None:
        while True:
            system.graph.channel("external_forces").publish(ExternalForces(system.clock.now(), pushed))
            await asyncio.sleep(0.05)

    async with looking(url) as viewer:
        await viewer.until(("GridMessage", "/odom/floor"))
        pushing = asyncio.create_task(push())
        arrow = ("MeshMessage", "/base_link/force_0")
        await viewer.until(arrow, ("LabelMessage", "/base_link/force_0_text"), ("SetPositionMessage", arrow[1]))
        pushing.cancel()
        places = [m["position"] for m in viewer.seen if m["type"] == "SetPositionMessage" and m["name"] == arrow[1]]
        np.testing.assert_allclose(places[-1], (0.3, 0.2, 0.6))
        shown = True
        while shown:
            await viewer.until(("SetSceneNodeVisibilityMessage", arrow[1]))
            changes = [m for m in viewer.seen if m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == arrow[1]]
            shown = changes[-1]["visible"]


async def feed(system: System, body: Body) -> None:
    """A robot that has moved on since its cloud was seen."""
    ranges = np.full(720, 2.0, np.float32)
    points = np.zeros((100, 3), np.float32)
    colors = np.zeros((100, 3), np.uint8)
    while True:
        now = system.clock.now()
        body.emit("odometry", Odometry(now, Pose2(1.0, 0.0, math.pi / 2), 0.0, 0.0))
        scan = LaserScan(now, "l", ranges, ranges, -1.57, 0.0044, 0.1, 30.0, 0.0125, Pose3.identity())
        body.emit("hokuyo", scan)
        system.graph.channel("point_cloud").publish(PointCloud(now - 0.1, points, colors, Pose2(0.25, 0.5, 0.0)))
        system.graph.channel("landmarks").publish(
            Landmarks(now, (Landmark("A", (1, 2, 1.4), 0.1, 1, now, now),), "map")
        )
        await asyncio.sleep(0.05)


async def test_a_turning_head_is_drawn_as_it_was_at_the_instant_of_the_base(
    url: str, system: System, body: Body
) -> None:
    model = await asyncio.to_thread(load_model, system.link.description.model_path)
    head = model.joints["pan_joint"]
    seen: list[np.ndarray] = []

    async with looking(url) as viewer:

        async def until_turned(angle: float) -> None:
            wanted = head.pose(angle).quaternion_wxyz()
            async with asyncio.timeout(PATIENCE_S):
                while not (seen and np.allclose(seen[-1], wanted, atol=1e-6)):
                    messages = unpack(await viewer.connection.recv(decode=False))
                    turns = [m for m in messages if m["type"] == "SetOrientationMessage"]
                    seen.extend(np.array(m["wxyz"]) for m in turns if m["name"].endswith(f"/{head.child}"))

        now = system.clock.now()
        body.emit("odometry", Odometry(now, Pose2(0.0, 0.0, 0.0), 0.0, 0.0))
        body.emit("joints", JointState(now, ("pan_joint",), (0.2,)))
        await until_turned(0.2)
        body.emit("joints", JointState(now + 0.1, ("pan_joint",), (0.8,)))
        body.emit("odometry", Odometry(now + 0.05, Pose2(0.0, 0.0, 0.0), 0.0, 0.0))
        await until_turned(0.5)
    newest = head.pose(0.8).quaternion_wxyz()
    assert not any(np.allclose(drawn, newest, atol=1e-6) for drawn in seen)


async def test_a_cloud_is_thinned_to_what_its_viewer_bears(url: str, system: System, body: Body, view: View) -> None:
    async with looking(url) as viewer:
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        session = view.sessions[0]
        for _ in range(20):
            view.answered(session, None)
        points = np.zeros((50_000, 3), np.float32)
        cloud = PointCloud(system.clock.now(), points, points.astype(np.uint8), Pose2(3.0, 0.0, 0.0))
        before = session.sent_bytes
        system.graph.channel("point_cloud").publish(cloud)
        await viewer.until(("SetPositionMessage", "/odom/cloud"))
        assert session.sent_bytes - before < 9 * view.pace()["abc"].points + 4_000


async def test_the_laser_is_listened_to_only_while_a_viewer_looks(url: str, system: System, view: View) -> None:
    channel = system.graph.channel("scan")
    assert not channel.wanted
    async with looking(url) as viewer:
        await viewer.until(("MeshMessage", None))
        assert channel.wanted
        assert [session.viewer for session in view.sessions] == ["abc"]
        rested = asyncio.Event()
        channel.on_wanted(lambda wanted: None if wanted else rested.set())
    async with asyncio.timeout(PATIENCE_S):
        await rested.wait()
    assert view.sessions == ()


async def test_the_pulse_measures_the_lag(url: str, view: View) -> None:
    address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with websockets.connect(address, proxy=None, close_timeout=1) as pulse:
        for _ in range(3):
            await pulse.send(f"{await pulse.recv(decode=True)} 33.4")
        await pulse.recv()
        (session,) = view.sessions
        assert session.budget.lag_s is not None
        assert 0 < session.budget.lag_s < 0.2
        async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=url) as client:
            views = (await client.get("/api/v1/viewers")).json()["views"]
        assert views[0]["lag_ms"] == pytest.approx(1e3 * session.budget.lag_s, abs=0.1)


def test_only_camera_messages_go_on_to_viser() -> None:
    assert allowed(pack(CAMERA))
    refused: Iterable[_messages.Message] = (_messages.ShareUrlRequest(), _messages.ShareUrlDisconnect())
    assert not any(allowed(pack(message)) for message in refused)
    assert not allowed(b"")
    assert not allowed(b"\xc1")
    assert not allowed(msgspec.msgpack.encode({"type": 3}))
    assert not allowed(msgspec.msgpack.encode([1]))


async def test_no_viewer_can_open_a_tunnel(url: str, view: View) -> None:
    """Neither through the relay, nor past it: viser itself has no ear for it any more."""
    async with looking(url) as viewer:
        await viewer.until(("MeshMessage", None))
        assert view._painter is not None
        handlers = view._painter.host.server._websock_server._incoming_handlers
        assert _messages.ViewerCameraMessage in handlers or handlers
        assert _messages.ShareUrlRequest not in handlers
        assert _messages.ShareUrlDisconnect not in handlers
        await viewer.connection.send(pack(_messages.ShareUrlRequest()))
        await viewer.connection.send(pack(CAMERA))
        assert view._painter.host.server._share_tunnel is None


async def test_viser_takes_no_client_but_our_relay(url: str, view: View) -> None:
    """A page elsewhere can reach any port of this computer's loopback; without our relay it is shown out."""
    port = await view.port()
    async with websockets.connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[websockets.Subprotocol(PROTOCOL)],
        origin=websockets.Origin("http://evil.example"),
        proxy=None,
        close_timeout=1,
    ) as stranger:
        with pytest.raises(websockets.ConnectionClosed):
            await stranger.recv()


async def test_what_a_stranger_sends_with_its_handshake_is_not_handled(url: str, view: View) -> None:
    """A close would wait for the stranger, and what came along would be handled meanwhile."""
    port = await view.port()
    assert view._painter is not None
    assert view._painter.host is not None
    sockets = view._painter.host.server._websock_server
    handled, loop = asyncio.Queue[float](), asyncio.get_running_loop()

    def note(_: object, message: _messages.ViewerCameraMessage) -> None:
        loop.call_soon_threadsafe(handled.put_nowait, message.fov)

    sockets.register_handler(_messages.ViewerCameraMessage, note)
    client = websockets.ClientProtocol(
        websockets.uri.parse_uri(f"ws://127.0.0.1:{port}"), subprotocols=[websockets.Subprotocol(PROTOCOL)]
    )
    client.send_request(client.connect())
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.writelines(client.data_to_send())
    client.state = websockets.State.OPEN
    client.send_binary(pack(dataclasses.replace(CAMERA, fov=0.7)))
    writer.writelines(client.data_to_send())
    with contextlib.suppress(ConnectionError):
        assert b"101 Switching Protocols" in await reader.read()
    writer.close()
    async with looking(url) as viewer:  # once its camera arrives, viser has handled all that was sent before
        await viewer.until(("GridMessage", "/odom/floor"))
        await viewer.connection.send(pack(dataclasses.replace(CAMERA, fov=0.5)))
        assert [await handled.get(), await handled.get()] == [1.0, 0.5]
    assert len(sockets._client_state_from_id) == len(sockets._live_connections)


async def test_a_page_of_another_viser_is_closed_with_one_line_in_the_log(
    url: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with websockets.connect(
        f"{url.replace('http', 'ws')}/viser", subprotocols=[websockets.Subprotocol("viser-v0.0.1")], proxy=None
    ) as connection:
        await connection.wait_closed()
        assert connection.close_code == 1002
        assert "Version mismatch" in (connection.close_reason or "")
    said = [record for record in caplog.records if record.levelno >= logging.WARNING and "viser" in record.getMessage()]
    assert len(said) == 1
    assert not [record for record in caplog.records if record.exc_info]


async def test_a_view_that_fails_is_reported_closed_and_tried_again(
    url: str, body: Body, caplog: pytest.LogCaptureFixture
) -> None:
    whole = body.description
    body.description = dataclasses.replace(whole, model_path=Path("/no/such/body.urdf"))
    async with looking(url) as viewer:
        with pytest.raises(websockets.ConnectionClosed) as closed:
            await viewer.until(("MeshMessage", None))
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1011
    assert "the 3D view failed" in caplog.text
    body.description = whole
    async with looking(url) as viewer:
        await viewer.until(("MeshMessage", None))


async def test_pages_of_others_see_nothing(url: str) -> None:
    with pytest.raises(websockets.InvalidStatus) as refusal:
        async with looking(url, origin=websockets.Origin("http://evil.example")):
            pass
    assert refusal.value.response.status_code == 403


async def test_no_port_is_open_to_the_world(url: str, view: View) -> None:
    await view.port()
    listening = [
        connection.laddr.ip
        for connection in psutil.Process().net_connections(kind="inet")
        if connection.status == psutil.CONN_LISTEN
    ]
    assert len(listening) >= 2
    assert set(listening) == {"127.0.0.1"}


async def test_people_are_drawn_where_they_are_and_hidden_when_they_are_gone(
    url: str, system: System, body: Body
) -> None:
    """One face and one voice come and go, and a clap: fixed nodes, shown and hidden, none removed."""
    async with looking(url) as viewer:
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        now = system.clock.now()
        for late_s in (-0.1, 0.1):
            body.emit("odometry", Odometry(now + late_s, Pose2(1.0, 0.0, 0.0), 0.0, 0.0))
        system.graph.channel("faces").publish(faces(now, (2.0, 0.5, 1.6)))
        system.graph.channel("sound_sources").publish(sound_sources(now, sound_source(azimuth=math.pi / 2)))
        system.graph.channel("loud_noises").publish(LoudNoise(now, 40.0, -9.0))
        await viewer.until(
            ("MeshMessage", "/odom/face_0"),
            ("SetPositionMessage", "/odom/face_0_text"),
            ("MeshMessage", "/odom/sound_0"),
            ("MeshMessage", "/noise"),
        )
        await shown(viewer, "/odom/face_0", False)
        await shown(viewer, "/odom/sound_0", False)
        await shown(viewer, "/noise", False)
    last = {(m["type"], m.get("name")): m for m in viewer.seen}
    assert last["SetPositionMessage", "/odom/face_0"]["position"] == pytest.approx((3.0, 0.5, 1.6))
    assert last["SetPositionMessage", "/odom/sound_0"]["position"] == pytest.approx((1.0, 0.0, 0.5))
    w, *_, z = last["SetOrientationMessage", "/odom/sound_0"]["wxyz"]
    assert (w, z) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)), abs=1e-3)
    assert "Person 1 · 2.0 m" in str([m for m in viewer.seen if m.get("name") == "/odom/face_0_text"])
    assert not [m for m in viewer.seen if "Remove" in m["type"]]


async def shown(viewer: Viewer, node: str, visible: bool) -> None:
    """Read until ``node`` is shown, or hidden."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            said = [
                m["visible"] for m in viewer.seen if m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == node
            ]
            if said and said[-1] is visible:
                return
            viewer.seen.extend(unpack(await viewer.connection.recv(decode=False)))
