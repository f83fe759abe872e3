"""A module's access to the body it runs in: the robot link, and streams of it relayed onto channels."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

from app.link import RobotLink
from app.messages import Message
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Output

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
    """Base of the sensor modules: relays streams of the body onto outputs while the module runs."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._releases: list[Callable[[], None]] = []

    def relay(self, stream: str, output: Output[Any], *, lazy: bool = False) -> None:
        """Publish each message of ``stream`` on ``output`` until the module stops; call it in ``start``.

        A ``lazy`` stream is produced only while the output has an open subscription, and no faster than the filters
        need it. Raises ModuleFailed for a body without such a stream.
        """
        if not lazy:
            self._releases.append(attach(self, stream, output.message_type, output.publish))
            return
        link = robot_link(self)

        def receive(message: Any) -> None:
            output.publish(message, link.periods(stream))

        def demand(divisor: float) -> None:
            description = link.description.streams[stream]
            wanted = divisor != math.inf
            output.thinned = divisor if description.thins and wanted else 1
            link.demand(stream, description.rate_hz / divisor if wanted else 0.0)

        self._releases.append(attach(self, stream, output.message_type, receive))
        self._releases.append(lambda: link.demand(stream, 0.0))
        self._releases.append(output.on_divisor(demand))

    async def stop(self) -> None:
        """Detach from the streams; the body need not produce them any more."""
        while self._releases:
            self._releases.pop()()
