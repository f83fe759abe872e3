"""FoxgloveServer: the program's channels for viewers that speak Foxglove's WebSocket protocol (Foxglove, Lichtblick).

┌─────────────────────────────────────────────────────────────────────────────────────────┐
│ FoxgloveServer    in   <channel>  every channel whose `log` is not `never`              │
└─────────────────────────────────────────────────────────────────────────────────────────┘

Topics and types are those of a recording (docs/recording-format.md). A channel is wanted, and its messages are encoded,
only while a viewer shows one of its topics. Viewers can read and nothing else: the server takes no messages, no calls
and no parameters. It listens on this computer alone, because the protocol knows no login; see docs/viewers.md.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic import Field

from app.logs.manifest import Manifest
from app.logs.ros.encoder import Encoder
from app.logs.ros.robot_description import robot_description
from app.messages import EncodedImage, Image, Message, PointCloud
from app.modules.viewers.topics import ShownTopics
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings
from app.runtime.ports import Input

if TYPE_CHECKING:
    from foxglove import Channel
    from foxglove.websocket import ChannelView, Client, WebSocketServer

HOST = "127.0.0.1"
PORT = 8765
#: Messages that wait for one viewer; the oldest is dropped when there are more.
BACKLOG = 512
#: Messages of a channel that wait for the encoder; the oldest is dropped when there are more.
INBOX = 64
#: Only the newest of these waits: viewers that cannot keep up skip pictures.
LARGE = (Image, EncodedImage, PointCloud)
_REMEDY = "viewers need the package foxglove-sdk: pip install 'hbba[foxglove]'"


class FoxgloveServerSettings(Settings):
    port: int = Field(PORT, ge=0, le=65535, description="port on 127.0.0.1; 0 is any free one")
    jpeg_quality: int = Field(80, ge=1, le=100)


class FoxgloveServer(Module):
    title = "Server for viewers"
    Settings = FoxgloveServerSettings
    settings: FoxgloveServerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._inputs = context.inputs
        for port in context.inputs.values():
            self.on(port, self._taker(port))
        self._server: WebSocketServer | None = None

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        """All recordable channels, on ports of their names."""
        return {name: name for name, spec in channels.items() if spec.log != "never"}

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take any channel that ROS has types for."""
        capacity = 1 if message_type in LARGE else INBOX
        port = self.input(name, message_type, capacity=capacity, wants="never")
        self.on(port, self._taker(port))

    async def start(self) -> None:
        """Listen. Raises ModuleFailed where the port is taken or the package is not installed."""
        try:
            foxglove = await self.compute(import_module, "foxglove")
        except ImportError:
            raise ModuleFailed(_REMEDY) from None
        self._loop = asyncio.get_running_loop()
        self._table = self.service(ChannelTable)
        self._ports = {port.channel.name: port for port in self._inputs.values() if port.channel is not None}
        self._topics = ShownTopics({name: self._table[name].message_type for name in self._ports})
        self._encoder = Encoder(self._table, self.settings.jpeg_quality)
        self._description = robot_description(self.service(Manifest), 0)
        types = dict(self._topics.types)
        if self._description is not None:
            types[self._description.topic] = self._description.type
        # Channels end with their context.
        self._sinks = context = foxglove.Context()
        self._channels = {
            topic: _channel(context, topic, type, self._encoder.definition(type)) for topic, type in types.items()
        }
        try:
            self._server = await self.compute(
                partial(
                    foxglove.start_server,
                    name=self.service(Manifest).facts.get("robot", "HBBA"),
                    host=HOST,
                    port=self.settings.port,
                    capabilities=[],
                    server_listener=_Listener(self._loop, self._subscribed, self._unsubscribed),
                    context=context,
                    message_backlog_size=BACKLOG,
                )
            )
        except (OSError, RuntimeError) as failure:
            raise ModuleFailed(f"viewers cannot connect: port {self.settings.port} of {HOST}: {failure}") from None
        self.log.info("viewers connect to %s (only from this computer)", self.url)

    async def stop(self) -> None:
        """Close the connections of all viewers."""
        server, self._server = self._server, None
        if server is not None:
            await asyncio.to_thread(server.stop)
        for port in self._inputs.values():
            if port.connected:
                port.subscription.demand(False)

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Go on: viewers show the newest."""

    @property
    def url(self) -> str:
        """The address that viewers connect to, "" while the server does not listen."""
        return "" if self._server is None else f"ws://{HOST}:{self._server.port}"

    # --- viewers ---

    def _subscribed(self, viewer: int, topic: str) -> None:
        for name in self._topics.subscribe(viewer, topic):
            self._ports[name].subscription.demand(True)
        if self._description is not None and topic == self._description.topic:
            self._send(topic, self._description.data, self.clock.now())
            return
        for name in self._topics.channels_of(topic):
            channel = self._ports[name].channel
            if self._table[name].latched and channel is not None and channel.latest is not None:
                # An encoder of its own: what it has written before does not matter to a viewer that has just come.
                self._publish(Encoder(self._table, self.settings.jpeg_quality), name, channel.latest)

    def _unsubscribed(self, viewer: int, topic: str) -> None:
        for name in self._topics.unsubscribe(viewer, topic):
            self._ports[name].subscription.demand(False)

    # --- messages ---

    def _taker(self, port: Input[Any]) -> Callable[[Any], Awaitable[None]]:
        async def take(message: Any) -> None:
            name = port.name if port.channel is None else port.channel.name
            if self._topics.encoded(name):
                await self.compute(self._publish, self._encoder, name, message)

        return take

    def _publish(self, encoder: Encoder, name: str, message: Any) -> None:
        for record in encoder.encode(name, message):
            if record.topic in self._channels:
                self._send(record.topic, record.data, message.stamp)

    def _send(self, topic: str, data: bytes, stamp: float) -> None:
        self._channels[topic].log(bytes(data), log_time=max(0, round(stamp * 1e9)))


class _Listener:
    """Passes what viewers ask for to the event loop."""

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        subscribed: Callable[[int, str], None],
        unsubscribed: Callable[[int, str], None],
    ) -> None:
        self._loop = loop
        self._calls = (subscribed, unsubscribed)

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        self._call(self._calls[0], client, channel)

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        self._call(self._calls[1], client, channel)

    def _call(self, method: Callable[[int, str], None], client: Client, channel: ChannelView) -> None:
        with suppress(RuntimeError):  # the loop is closed: nothing is published any more
            self._loop.call_soon_threadsafe(method, client.id, channel.topic)


def _channel(context: Any, topic: str, type: str, definition: str) -> Channel:
    from foxglove import Channel, Schema

    schema = Schema(name=type, encoding="ros2msg", data=definition.encode())
    return Channel(topic, message_encoding="cdr", schema=schema, context=context)
