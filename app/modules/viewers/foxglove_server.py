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
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pydantic import Field

from app.logs.manifest import Manifest
from app.logs.ros.encoder import Encoder
from app.modules.viewers.channel_server import ChannelServer
from app.runtime.errors import ModuleFailed
from app.runtime.module import ModuleContext, Settings

if TYPE_CHECKING:
    from foxglove import Channel
    from foxglove.websocket import ChannelView, Client, WebSocketServer

HOST = "127.0.0.1"
PORT = 8765
#: Messages that wait for one viewer; the oldest is dropped when there are more.
BACKLOG = 512
_REMEDY = "viewers need the package foxglove-sdk: pip install 'hbba[foxglove]'"


class FoxgloveServerSettings(Settings):
    port: int = Field(PORT, ge=0, le=65535, description="port on 127.0.0.1; 0 is any free one")
    jpeg_quality: int = Field(80, ge=1, le=100)


class FoxgloveServer(ChannelServer):
    title = "Server for viewers"
    Settings = FoxgloveServerSettings
    settings: FoxgloveServerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._server: WebSocketServer | None = None

    async def start(self) -> None:
        """Listen. Raises ModuleFailed where the port is taken or the package is not installed."""
        try:
            foxglove = await self.compute(import_module, "foxglove")
        except ImportError:
            raise ModuleFailed(_REMEDY) from None
        self._loop = asyncio.get_running_loop()
        self.prepare(self.settings.jpeg_quality)
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
        self.rest()

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
        for name, message in self.standing(topic):
            self._publish(self.new_encoder(), name, message)

    def _unsubscribed(self, viewer: int, topic: str) -> None:
        for name in self._topics.unsubscribe(viewer, topic):
            self._ports[name].subscription.demand(False)

    # --- messages ---

    async def show(self, name: str, message: Any) -> None:
        """Encode and send it beside the loop."""
        await self.compute(self._publish, self._encoder, name, message)

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
