"""The server for viewers, asked by a client of its protocol that knows nothing but what the server advertises."""

from __future__ import annotations

import asyncio
import json
import struct
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import pytest
import websockets
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from app.logs.manifest import Manifest
from app.modules.viewers.foxglove_server import FoxgloveServer
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.clock import RealClock
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.supervisor import Supervisor
from tests.logs.mcap.disks import BEGIN, MANIFEST, image, landmarks, odometry
from tests.patience import PATIENCE_S

pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")

_ROWS: dict[str, dict[str, Any]] = {
    "kinect": {"type": "Image", "rate_hz": 15},
    "odometry": {"type": "Odometry", "rate_hz": 100},
    "landmarks": {"type": "Landmarks", "latched": True},
    "recorder": {"type": "RecorderStatus", "log": "never"},
}
TABLE = ChannelTable({name: ChannelSpec.model_validate({"external": True, **row}) for name, row in _ROWS.items()})


class Robot:
    """A program of one module, the server, on a free port; other channels come from outside."""

    def __init__(self) -> None:
        spec = ModuleSpec.model_validate(
            {"class": "app.modules.viewers.foxglove_server:FoxgloveServer", "settings": {"port": 0}}
        )
        self.graph = Graph(
            clock=RealClock(),
            channels=TABLE,
            modules={"FoxgloveServer": spec},
            services={Manifest: MANIFEST, ChannelTable: TABLE},
        )
        # A source that could rest, as a body's camera.
        for port in self.graph.modules["FoxgloveServer"].context.inputs.values():
            port.subscription.demand(False)
        self.supervisor = Supervisor(self.graph.modules, RealClock())

    @property
    def server(self) -> FoxgloveServer:
        module = self.graph.modules["FoxgloveServer"].module
        assert isinstance(module, FoxgloveServer)
        return module

    def feed(self, channel: str, message: Any) -> None:
        self.graph.channel(channel).publish(message)

    async def wanted(self, channel: str, wanted: bool = True) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while self.graph.channel(channel).wanted != wanted:  # noqa: ASYNC110  # the loop's next turn is the event
                await asyncio.sleep(0)


@asynccontextmanager
async def running() -> AsyncIterator[Robot]:
    robot = Robot()
    async with robot.supervisor:
        await asyncio.wait_for(robot.supervisor.started(), PATIENCE_S)
        yield robot


class Viewer:
    """A client: what was advertised by topic, and messages as they come."""

    def __init__(self, socket: websockets.ClientConnection) -> None:
        self._socket = socket
        self._number = 0
        self._topics: dict[int, str] = {}
        self.advertised: dict[str, dict[str, Any]] = {}
        self.info: dict[str, Any] = {}

    async def learn(self, *topics: str) -> None:
        """Read until all of ``topics`` are advertised."""
        self.info = json.loads(await self._receive())
        while not set(topics) <= set(self.advertised):
            for channel in json.loads(await self._receive())["channels"]:
                self.advertised[channel["topic"]] = channel

    async def show(self, topic: str) -> None:
        self._number += 1
        self._topics[self._number] = topic
        wish = {"id": self._number, "channelId": self.advertised[topic]["id"]}
        await self.say({"op": "subscribe", "subscriptions": [wish]})

    async def hide(self, topic: str) -> None:
        numbers = [number for number, each in self._topics.items() if each == topic]
        await self.say({"op": "unsubscribe", "subscriptionIds": numbers})

    async def say(self, message: dict[str, Any]) -> None:
        await self._socket.send(json.dumps(message))

    async def next(self) -> tuple[str, int, Any]:
        """Topic, time (ns) and content of the next message."""
        data = await self._receive()
        assert isinstance(data, bytes)
        kind, number, at_ns = struct.unpack_from("<BIQ", data)
        assert kind == 1
        topic = self._topics[number]
        return topic, at_ns, self._decoded(topic, data[13:])

    async def status(self) -> dict[str, Any]:
        """The next status that the server sends."""
        status: dict[str, Any] = json.loads(await self._receive())
        assert status["op"] == "status"
        return status

    def _decoded(self, topic: str, data: bytes) -> Any:
        channel = self.advertised[topic]
        assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(channel["schema"], channel["schemaName"]))
        return store.deserialize_cdr(data, channel["schemaName"])

    async def _receive(self) -> Any:
        return await asyncio.wait_for(self._socket.recv(), PATIENCE_S)


@asynccontextmanager
async def viewing(robot: Robot) -> AsyncIterator[Viewer]:
    protocol = websockets.Subprotocol("foxglove.sdk.v1")
    async with websockets.connect(robot.server.url, subprotocols=[protocol]) as socket:
        viewer = Viewer(socket)
        await viewer.learn("/odometry", "/landmarks", "/tf", "/kinect/color/compressed")
        yield viewer


async def test_a_viewer_reads_what_is_published_by_what_is_advertised() -> None:
    async with running() as robot, viewing(robot) as viewer:
        assert viewer.info["name"] == "a test body"
        await viewer.show("/odometry")
        await robot.wanted("odometry")
        robot.feed("odometry", odometry(BEGIN + 2))
        topic, at_ns, content = await viewer.next()
        assert (topic, at_ns) == ("/odometry", round((BEGIN + 2) * 1e9))
        assert content.pose.pose.position.x == pytest.approx(2.0)
        assert content.header.frame_id == "odom"


async def test_nothing_is_wanted_without_a_viewer() -> None:
    async with running() as robot:
        assert not robot.graph.channel("kinect").wanted
        async with viewing(robot) as viewer:
            assert not robot.graph.channel("kinect").wanted
            await viewer.show("/kinect/color/compressed")
            await robot.wanted("kinect")
            robot.feed("kinect", image(BEGIN))
            _, _, content = await viewer.next()
            assert content.format == "jpeg"
            await viewer.hide("/kinect/color/compressed")
            await robot.wanted("kinect", False)
            await viewer.show("/kinect/depth")
            await robot.wanted("kinect")
        await robot.wanted("kinect", False)  # it has gone without a word


async def test_a_state_is_sent_to_a_viewer_that_comes_later() -> None:
    async with running() as robot:
        robot.feed("landmarks", landmarks(BEGIN, "HBBA:STOP/LAB1"))
        async with viewing(robot) as viewer:
            await viewer.show("/landmarks")
            _, _, content = await viewer.next()
            assert content.landmarks[0].text == "HBBA:STOP/LAB1"


async def test_viewers_can_only_read() -> None:
    async with running() as robot, viewing(robot) as viewer:
        assert viewer.info["capabilities"] == []
        channel = {"id": 1, "topic": "/teleop_command", "encoding": "json", "schemaName": ""}
        await viewer.say({"op": "advertise", "channels": [channel]})
        assert (await viewer.status())["level"] > 0


async def test_the_end_of_the_program_ends_its_connections() -> None:
    async with AsyncExitStack() as viewers:
        async with running() as robot:
            server = robot.server
            assert server.url.startswith("ws://127.0.0.1:")
            viewer = await viewers.enter_async_context(viewing(robot))
        assert server.url == ""
        with pytest.raises(websockets.ConnectionClosed):
            await viewer.status()
