"""What servers for viewers share: all recordable channels are inputs, and each is worked for only while it is shown."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterator, Mapping
from typing import Any

from app.logs.manifest import Manifest
from app.logs.ros.encoder import Encoder
from app.logs.ros.record import RecordTopic
from app.logs.ros.robot_description import robot_description
from app.messages import Message
from app.modules.viewers.topics import LARGE, ShownTopics, recorded
from app.runtime.channel_table import ChannelSpec, ChannelTable
from app.runtime.errors import InboxOverflow
from app.runtime.module import Module, ModuleContext
from app.runtime.ports import Input

#: Messages of a channel that wait for the encoder; the oldest is dropped when there are more.
INBOX = 64


class ChannelServer(Module, ABC):
    """A module that encodes the program's channels as a recording does, for those who show their topics."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._inputs = context.inputs
        for port in context.inputs.values():
            self.on(port, self._taker(port))

    @classmethod
    def default_inputs(cls, channels: Mapping[str, ChannelSpec]) -> Mapping[str, str]:
        """All recordable channels, on ports of their names."""
        return {name: name for name, spec in channels.items() if spec.log != "never"}

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take any channel that ROS has types for; of large messages only the newest waits, for viewers that cannot
        keep up."""
        port = self.input(name, message_type, capacity=1 if message_type in LARGE else INBOX, wants="never")
        self.on(port, self._taker(port))

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Go on: viewers show the newest."""

    def prepare(self, jpeg_quality: int, drawn: Callable[[str, type[Any]], tuple[RecordTopic, ...]] = recorded) -> None:
        """Look up the channels that are connected, and their topics as ``drawn`` names them."""
        self._jpeg_quality = jpeg_quality
        self._table = self.service(ChannelTable)
        self._ports = {port.channel.name: port for port in self._inputs.values() if port.channel is not None}
        self._topics = ShownTopics({name: self._table[name].message_type for name in self._ports}, drawn)
        self._encoder = self.new_encoder()
        self._description = robot_description(self.service(Manifest), 0)

    def new_encoder(self) -> Encoder:
        """One that has written nothing yet."""
        return Encoder(self._table, self._jpeg_quality)

    def standing(self, topic: str) -> Iterator[tuple[str, Any]]:
        """By channel, the message that who shows ``topic`` now is to get though none follows: the last of a latched
        one. It wants an encoder of its own: what was written before does not matter to who has just come."""
        for name in self._topics.channels_of(topic):
            channel = self._ports[name].channel
            if self._table[name].latched and channel is not None and channel.latest is not None:
                yield name, channel.latest

    def rest(self) -> None:
        """Want nothing any more."""
        for port in self._inputs.values():
            if port.connected:
                port.subscription.demand(False)

    def note(self, message: Any) -> None:
        """A message came, shown or not."""

    @abstractmethod
    async def show(self, name: str, message: Any) -> None:
        """Give ``message`` of the channel ``name`` to those who show it."""

    def _taker(self, port: Input[Any]) -> Callable[[Any], Awaitable[None]]:
        async def take(message: Any) -> None:
            self.note(message)
            name = port.name if port.channel is None else port.channel.name
            if self._topics.encoded(name):
                await self.show(name, message)

        return take
