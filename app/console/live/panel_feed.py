"""Messages of the channels that panels of packages want, as frames of the live stream."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection
from contextlib import ExitStack
from functools import partial
from typing import Any

import msgspec
import numpy as np

from app.console.panels import CHANNEL
from app.console.taps import Tap
from app.runtime.channel import Channel
from app.runtime.clock import Clock

#: Ten frames a second of each channel at most.
PERIOD_S = 0.1
#: A frame of more bytes is left out: pictures and clouds have streams of their own.
LARGEST_FRAME = 64 * 1024

log = logging.getLogger("hbba.console")


class PanelFeed:
    """While a page is connected, gives ``broadcast(kind, frame)`` the newest message of each of ``channels``."""

    def __init__(
        self,
        channels: Collection[Channel[Any]],
        clock: Clock,
        broadcast: Callable[[str, str], None],
    ) -> None:
        """``clock`` paces the frames; ``channels`` are those of the graph that some panel wants."""
        self._channels = tuple(channels)
        self._clock = clock
        self._broadcast = broadcast
        self._encoder = msgspec.json.Encoder(enc_hook=_plain)
        self._new: dict[str, Any] = {}
        self._refused: set[str] = set()

    def open(self) -> Callable[[], None]:
        """Begin; returns what ends it."""
        stack = ExitStack()
        if self._channels:
            for channel in self._channels:
                stack.callback(Tap(channel, f"console.panels.{channel.name}", partial(self._take, channel.name)).close)
            stack.callback(asyncio.create_task(self._run(), name="console panels").cancel)
        return stack.close

    def frames(self) -> dict[str, str]:
        """The newest frame of each channel by kind, for a page that has just connected."""
        latest = {channel.name: channel.latest for channel in self._channels}
        made = {name: self._frame(name, message) for name, message in latest.items() if message is not None}
        return {CHANNEL + name: frame for name, frame in made.items() if frame is not None}

    def clear(self) -> None:
        """Leave out what came before a recording jumped."""
        self._new.clear()

    def _take(self, name: str, message: Any) -> None:
        self._new[name] = message

    async def _run(self) -> None:
        while True:
            await self._clock.sleep(PERIOD_S)
            new, self._new = self._new, {}
            for name, message in new.items():
                if (frame := self._frame(name, message)) is not None:
                    self._broadcast(CHANNEL + name, frame)

    def _frame(self, name: str, message: Any) -> str | None:
        """The frame of ``message``; None for one that JSON cannot say, or that is too large, which is logged once."""
        try:
            encoded = self._encoder.encode({"type": "channel", "channel": name, "message": message})
            if len(encoded) <= LARGEST_FRAME:
                return encoded.decode()
            problem = f"{len(encoded)} bytes are more than {LARGEST_FRAME}"
        except TypeError as failure:
            problem = str(failure)
        if name not in self._refused:
            self._refused.add(name)
            log.warning("messages of %s are not sent to panels: %s", name, problem)
        return None


def _plain(value: Any) -> Any:
    """Arrays as lists. Raises TypeError for what JSON has nothing like."""
    if isinstance(value, np.ndarray):
        if value.nbytes > LARGEST_FRAME:
            raise TypeError(f"an array of {value.nbytes} bytes is too large")
        return value.tolist()
    raise TypeError(f"a {type(value).__name__} cannot be said in JSON")
