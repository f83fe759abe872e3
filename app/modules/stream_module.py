"""A module's access to the body it runs in: the robot link, and streams of it relayed onto channels."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, ClassVar, TypeVar

from app.link import RobotLink
from app.messages import Message
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext
from app.runtime.ports import Output

M = TypeVar("M", bound=Message)


def robot_link(module: Module) -> RobotLink:
    """The body ``module`` runs in. Raises ModuleFailed if the program has none."""
    return module.service(RobotLink)  # type: ignore[type-abstract]  # the protocol is the key of the service


def attach(module: Module, stream: str, message_type: type[M], receive: Callable[[M], None]) -> Callable[[], None]:
    """Have ``receive`` called with each message of the body's ``stream``; returns a function that ends it.

    Raises ModuleFailed, in words for people, if the body has no such stream or it carries another type.
    """
    link = robot_link(module)
    description = link.description
    try:
        carried = description.streams[stream].message_type
        detach = link.attach(stream, receive)
    except KeyError:
        streams = ", ".join(sorted(description.streams)) or "none"
        raise ModuleFailed(
            f"{module.name} needs the stream {stream!r}, which {description.name} does not have (it has: {streams}); "
            f"take {module.name} out of the configuration or choose another robot"
        ) from None
    if carried is not message_type:
        detach()
        raise ModuleFailed(
            f"{module.name} needs {message_type.__name__} messages, but stream {stream!r} of {description.name} "
            f"carries {carried.__name__}"
        )
    return detach


class StreamModule(Module):
    """Base of the sensor modules: each publishes streams of the body, unchanged, on outputs while it runs.

    A stream is produced only while its output has an open subscription, unless the body always produces it, and no
    faster than the filters need it. Raises ModuleFailed at the start for a body without such a stream,
    unless it is one of ``optional_streams``.
    """

    #: By output: the body's stream, and its message type.
    relays: ClassVar[Mapping[str, tuple[str, type[Message]]]]

    def __init_subclass__(cls) -> None:
        cls.streams = {output: stream for output, (stream, _) in cls.relays.items()}

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._releases: list[Callable[[], None]] = []
        for name, (_, message_type) in self.relays.items():
            self.output(name, message_type)

    async def start(self) -> None:
        link = robot_link(self)
        for name, stream in self.streams.items():
            if stream in self.optional_streams and stream not in link.description.streams:
                continue
            output = self._context.outputs[name]
            self._releases.append(attach(self, stream, output.message_type, partial(_publish, link, stream, output)))
            self._releases.append(partial(link.demand, stream, 0.0))
            self._releases.append(output.on_divisor(partial(_demand, link, stream, output)))

    async def stop(self) -> None:
        while self._releases:
            self._releases.pop()()


def _publish(link: RobotLink, stream: str, output: Output[Any], message: Any) -> None:
    output.publish(message, link.periods(stream))


def _demand(link: RobotLink, stream: str, output: Output[Any], divisor: float) -> None:
    description = link.description.streams[stream]
    wanted = divisor != math.inf
    output.thinned = divisor if description.thins and wanted else 1
    link.demand(stream, description.rate_hz / divisor if wanted else 0.0)
