"""RemoteModule: represents at home a module on another computer, with the same ports and filters.

    images, odometry … ─▶ φ ─▶ RemoteModule ─▶ link ─▶ the module itself ─▶ link ─▶ RemoteModule ─▶ faces …

Of an input whose inbox holds one message, two are on their way at most: what comes meanwhile replaces what waits, so
that the newest is looked at. All others are sent as they come. Results are published with the source's own stamp.
"""

from __future__ import annotations

import functools
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from pydantic import Field

from app.messages import Message
from app.remote.codec import BadPayload, Codec
from app.remote.contract import describe
from app.remote.hub import NodeHub
from app.remote.link import NodeLink, kept_of
from app.remote.wire import Orders, Result
from app.runtime.errors import InboxOverflow
from app.runtime.filter import CLOSED
from app.runtime.graph import ModuleSpec
from app.runtime.module import Input, Module, ModuleContext, Settings


class RemoteModuleSettings(Settings):
    node: str = Field(description="the computer that runs it")
    module: str = Field(description="the name of the module there, and here")
    spec: dict[str, Any] = Field(description="the module as configured")
    quality: int | None = Field(85, ge=1, le=100, description="of JPEG; null: raw colours")


class RemoteModule(Module):
    Settings = RemoteModuleSettings
    settings: RemoteModuleSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._parameters: dict[str, Any] = {}
        self._leave: list[Callable[[], None]] = []
        described = describe(self.settings.module, ModuleSpec.model_validate(self.settings.spec))
        quality = self.settings.quality
        self._codecs = {name: Codec(port.message_type, quality) for name, port in described.outputs.items()}
        self._outputs = {name: self.output(name, port.message_type) for name, port in described.outputs.items()}
        for name, port in described.inputs.items():
            here = self.input(
                name,
                port.message_type,
                capacity=port.capacity,
                lossless=port.lossless,
                always_open=port.always_open,
                wants=port.wants,
                rests=port.rests,
            )
            self.on(here, self._sender(here, Codec(port.message_type, quality)))

    async def start(self) -> None:
        """Begin to stand for the module."""
        link = self._link
        self._leave.append(link.attach(self.settings.module, self))
        for output in self._outputs.values():
            self._leave.append(output.on_divisor(lambda _: link.send_orders(self.orders())))

    async def stop(self) -> None:
        """Cease to."""
        for leave in self._leave:
            leave()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._parameters = dict(parameters)
        self._link.send_orders(self.orders())

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """The module there sees the gap for itself."""
        self.log.warning("%s", loss)

    def orders(self) -> Orders:
        """P' and demand, for the module there."""
        wanted = {name: output.divisor != CLOSED for name, output in self._outputs.items()}
        return Orders(self.settings.module, self._parameters, wanted)

    def take(self, result: Result) -> None:
        """Publish a result; one that is damaged, or of a port that there is not, is logged and dropped."""
        output, codec = self._outputs.get(result.port), self._codecs.get(result.port)
        if output is None or codec is None:
            self.log.warning("%s sends a result of port %r, which there is not", self.settings.node, result.port)
            return
        try:
            message = codec.decode(result.payload)
        except BadPayload as failure:
            self.log.warning("%s sends a damaged result: %s", self.settings.node, failure)
            return
        for key, value in result.kept.items():
            self.persistent[key] = max(value, self.persistent.get(key, value))
        output.publish(message)

    @functools.cached_property
    def _link(self) -> NodeLink:
        return self.service(NodeHub).link(self.settings.node)

    def _sender(self, port: Input[Any], codec: Codec) -> Callable[[Message], Awaitable[None]]:
        awaits = port.capacity == 1 and not port.always_open and not port.lossless

        async def send(message: Message) -> None:
            link = self._link
            if not link.usable:
                return
            # An image takes milliseconds, and that is this module's, in its own thread.
            payload = await self.compute(codec.encode, message) if codec.heavy else codec.encode(message)
            kept = kept_of(self.persistent)
            await link.send(self.settings.module, port.name, payload, kept=kept, awaits=awaits)

        return send
