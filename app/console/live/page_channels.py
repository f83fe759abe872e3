"""Channels to the pages, as the column `page` of the channel table says: as which type, how often, newest or all."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from typing import Any, Protocol

from app.console.page_forms import NOTHING, form
from app.console.taps import Tap
from app.console.wire import encode_text, frame
from app.runtime.channel import Channel
from app.runtime.channel_table import PageColumn
from app.runtime.clock import Clock
from app.runtime.graph import Graph

#: Room for what comes in one go on a channel of which a page is given every message.
BURST = 1000


class Audience(Protocol):
    """Where frames go."""

    @property
    def moving(self) -> bool:
        """Whether the time of a recording is just being moved: a message published meanwhile is of no time."""
        ...

    def broadcast(self, kind: str, frame: str) -> None:
        """Give every page the newest frame of type ``kind``."""
        ...

    def broadcast_each(self, kind: str, item: str) -> None:
        """Give every page ``item`` in a list of type ``kind``, after those before it."""
        ...


class PageChannels:
    """Forwards the channels of ``graph`` whose row says so; ``pace`` measures their rates."""

    def __init__(self, graph: Graph, pace: Clock, audience: Audience) -> None:
        self._feeds: list[PageFeed] = []
        self._states: list[PageFeed] = []
        for name, spec in graph.specs.items():
            if spec.page is not None:
                feed = PageFeed(graph.channel(name), spec.page.frame_type or name, spec.page, pace, audience)
                self._feeds.append(feed)
                if spec.latched:
                    self._states.append(feed)

    def open(self) -> Callable[[], None]:
        """Want these channels from now on; returns what ends it."""
        stack = ExitStack()
        for feed in self._feeds:
            stack.callback(feed.open())
        return stack.close

    def clear(self) -> None:
        """Time has jumped: what waits to be sent is of another time."""
        for feed in self._feeds:
            feed.clear()

    def standing(self) -> dict[str, str]:
        """By type, the frames of the newest messages, for a page that comes."""
        return _frames(self._feeds)

    def states(self) -> dict[str, str]:
        """The same of latched channels alone, where time has jumped: other messages are events of their moment."""
        return _frames(self._states)


class PageFeed:
    """One channel to the pages as frames of type ``kind``."""

    def __init__(self, channel: Channel[Any], kind: str, column: PageColumn, pace: Clock, audience: Audience) -> None:
        self.kind = kind
        self._channel = channel
        self._all = column.keep == "all"
        self._period_s = 0.0 if column.every_hz is None else 1.0 / column.every_hz
        self._pace = pace
        self._audience = audience
        self._due = float("-inf")
        self._newest: Any = None
        self._waiting: asyncio.Task[None] | None = None

    def open(self) -> Callable[[], None]:
        """Take messages; returns what ends it."""
        tap = Tap(self._channel, f"console.{self._channel.name}", self._take, capacity=BURST if self._all else 1)

        def end() -> None:
            tap.close()
            self.clear()

        return end

    def clear(self) -> None:
        """Send nothing that waits."""
        self._due = float("-inf")
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def standing(self) -> str | None:
        """The frame of the newest message; None where there is none, or all of them count."""
        if self._all:
            return None
        latest = self._channel.latest
        if latest is not None:
            return self._frame(latest)
        nothing = NOTHING.get(self._channel.message_type)
        return None if nothing is None else frame(self.kind, nothing)

    def _take(self, message: Any) -> None:
        if self._audience.moving:
            return
        if self._all:
            self._audience.broadcast_each(self.kind, encode_text(form(message)))
            return
        self._newest = message
        if self._waiting is not None:
            return
        if self._pace.now() >= self._due:
            self._send()
        else:
            self._waiting = asyncio.create_task(self._send_when_due(), name=f"page {self.kind}")

    async def _send_when_due(self) -> None:
        await self._pace.sleep_until(self._due)
        self._waiting = None
        if not self._audience.moving:
            self._send()

    def _send(self) -> None:
        self._due = self._pace.now() + self._period_s
        self._audience.broadcast(self.kind, self._frame(self._newest))

    def _frame(self, message: Any) -> str:
        return frame(self.kind, form(message))


def _frames(feeds: Iterable[PageFeed]) -> dict[str, str]:
    frames = ((feed.kind, feed.standing()) for feed in feeds)
    return {kind: text for kind, text in frames if text is not None}
