"""A consumer of a channel outside the graph: the console's own subscriptions."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Generic, TypeVar

from app.messages import Message
from app.runtime.channel import Channel

M = TypeVar("M", bound=Message)


class Tap(Generic[M]):
    """Calls ``handler`` on the loop with each message of ``channel`` that a filter of ``divisor`` passes, until closed.

    Newest wins: the inbox holds ``capacity`` messages, one unless more are asked for.
    """

    def __init__(
        self,
        channel: Channel[M],
        name: str,
        handler: Callable[[M], None],
        *,
        divisor: float = 1,
        capacity: int = 1,
    ) -> None:
        self._channel = channel
        self._handler = handler
        self._subscription = channel.subscribe(name, divisor=divisor, capacity=capacity)
        self._task = asyncio.create_task(self._run(), name=name)

    def close(self) -> None:
        """Take nothing more; the channel's source may rest if it has no other subscriber."""
        self._channel.unsubscribe(self._subscription)
        self._task.cancel()

    async def _run(self) -> None:
        async for message in self._subscription:
            self._handler(message)
