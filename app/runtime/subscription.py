"""One consumer's end of a channel: a rate filter and a bounded inbox; see ``channel.py``."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Generic, TypeVar

from app.messages import Message
from app.runtime.errors import ChannelClosed, InboxOverflow, WouldBlock
from app.runtime.filter import CLOSED, RateFilter

M = TypeVar("M", bound=Message)


@dataclass(frozen=True, slots=True)
class SubscriptionStatistics:
    """Counters since the subscription was made.

    ``received`` offered by the channel, or left out by its source on behalf of the filters; ``passed`` the filter;
    ``decimated`` stopped by the filter, or left out (wanted);
    ``dropped`` pushed out of a full inbox (overflow); ``discarded`` thrown away when the filter closed; ``taken`` by
    the consumer; ``depth`` waiting now, at most ``capacity``; ``age_s`` of the last message when it was taken, None
    before the first; ``divisor`` is φ.
    """

    received: int
    passed: int
    decimated: int
    dropped: int
    discarded: int
    taken: int
    depth: int
    capacity: int
    age_s: float | None
    divisor: float


class Subscription(Generic[M]):
    """One consumer's end of a channel. Take messages with ``receive`` or ``async for``; one task at a time."""

    __slots__ = (
        "_age_s", "_attended", "_capacity", "_closed", "_discarded", "_dropped", "_inbox", "_now",
        "_on_close", "_on_filter", "_overflowed", "_passed", "_received", "_resting", "_senders", "_waiter",
        "demands", "filter", "lossless", "name", "taken",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        now: Callable[[], float],
        capacity: int,
        lossless: bool,
        divisor: float,
        on_filter: Callable[[], None],
        on_close: Callable[[Subscription[M]], None],
        *,
        demands: bool = True,
    ) -> None:
        if capacity < 1:
            raise ValueError(f"the inbox of {name} needs room for at least 1 message, not {capacity}")
        self.name = name
        self.filter = RateFilter(divisor, self._filter_changed)
        self._now = now
        self._capacity = capacity
        self.lossless = lossless
        #: Whether the channel is wanted while the filter is open; see :meth:`demand`.
        self.demands = demands
        self._on_filter = on_filter
        self._on_close = on_close
        self._inbox: deque[M] = deque()
        self._waiter: asyncio.Future[None] | None = None
        #: The publishers that wait for room, in the order in which they came.
        self._senders: dict[asyncio.Future[bool], None] = {}
        self._closed = False
        self._attended = True
        self._resting = False
        self._overflowed = 0
        self._received = self._passed = self._dropped = self._discarded = 0
        #: How many messages the consumer has taken.
        self.taken = 0
        self._age_s: float | None = None

    def offer(self, message: M, periods: int = 1) -> None:
        """Filter, store and wake: called by the channel for each message published, with the periods that it ends."""
        self._received += periods
        rate_filter = self.filter
        if periods > 1:
            if not rate_filter.offer(periods):
                return
        # RateFilter.offer for one period, written out: this is the program's hottest line.
        elif rate_filter.skip:
            rate_filter.skip -= 1
            return
        else:
            rate_filter.skip = rate_filter.reload
        self._passed += 1
        inbox = self._inbox
        if len(inbox) >= self._capacity:
            if self._resting:
                self._discarded += 1
            else:
                self._dropped += 1
            if self.lossless:
                self._overflowed += 1
                return
            inbox.popleft()
        inbox.append(message)
        waiter = self._waiter
        if waiter is not None and not self._resting:
            self._waiter = None
            if not waiter.done():
                waiter.set_result(None)

    async def receive(self) -> M:
        """Wait for a message and take it; a wait that is cancelled loses none.

        Raises ChannelClosed at the end, InboxOverflow after a loss, RuntimeError if another task already waits here.
        """
        if self._inbox and not self._overflowed and not self._resting:
            return self._take()
        while (self._resting or not self._inbox) and not self._overflowed:
            if self._closed:
                raise ChannelClosed(f"{self.name}: the channel is closed")
            if self._waiter is not None and not self._waiter.done():
                raise RuntimeError(f"{self.name}: two tasks wait for the same inbox")
            waiter = asyncio.get_running_loop().create_future()
            self._waiter = waiter
            await waiter
        return self.receive_nowait()

    def receive_nowait(self) -> M:
        """Take a message now. Raises WouldBlock if there is none, InboxOverflow after a loss."""
        if self._overflowed:
            lost, self._overflowed = self._overflowed, 0
            raise InboxOverflow(f"{self.name}: {lost} messages lost, the inbox holds {self._capacity}")
        if not self._inbox:
            raise WouldBlock(f"{self.name}: no message waits")
        return self._take()

    def _take(self) -> M:
        message = self._inbox.popleft()
        self.taken += 1
        self._age_s = self._now() - message.stamp
        if self._senders:
            self._wake_senders()
        return message

    def _wake_senders(self) -> None:
        for sender in self._senders:
            _resolve(sender, True)
        self._senders.clear()

    @property
    def waiting(self) -> bool:
        """Whether there is a message to take, and the consumer does not rest."""
        return bool(self._inbox) and not self._resting

    @property
    def inbox(self) -> Collection[M]:
        """What waits, live: the same object for as long as the subscription is."""
        return self._inbox

    def __aiter__(self) -> Subscription[M]:
        return self

    async def __anext__(self) -> M:
        if self._inbox and not self._overflowed and not self._resting:
            return self._take()
        try:
            return await self.receive()
        except ChannelClosed:
            raise StopAsyncIteration from None

    def has_room(self) -> bool:
        """Whether a message that passes the filter now would be stored without loss (``send`` waits for this)."""
        return not self.lossless or len(self._inbox) < self._capacity or self._closed or not self._attended

    async def wait_for_room(self, give_up_at: float) -> bool:
        """Wait until a message is taken, or the consumer leaves; False if the loop's time ``give_up_at`` came first.

        A cancelled wait leaves no state behind.
        """
        loop = asyncio.get_running_loop()
        sender: asyncio.Future[bool] = loop.create_future()
        self._senders[sender] = None
        # A plain timer instead of asyncio.timeout: a producer faster than its consumers comes by here often.
        timer = loop.call_at(give_up_at, _resolve, sender, False)
        try:
            return await sender
        finally:
            timer.cancel()
            self._senders.pop(sender, None)

    def demand(self, demands: bool) -> None:
        """Whether the channel is ``wanted`` for this consumer; it is given what is published either way."""
        if demands != self.demands:
            self.demands = demands
            self._on_filter()

    def rest(self, resting: bool) -> None:
        """While ``resting``, the newest messages wait in the inbox and do not wake the consumer; then they are taken.

        Raises ValueError for a lossless inbox: its producers would wait.
        """
        if self.lossless:
            raise ValueError(f"{self.name} is lossless and may not rest")
        self._resting = resting
        if not resting and self._inbox and self._waiter is not None:
            waiter, self._waiter = self._waiter, None
            if not waiter.done():
                waiter.set_result(None)

    def close(self) -> None:
        """Leave the channel; what waits can still be received, then ChannelClosed is raised. May be called twice."""
        if not self._closed:
            self.end()
            self._on_close(self)

    def end(self) -> None:
        """Called by the channel: nothing more will come."""
        self._closed, self._resting = True, False
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)
        self._wake_senders()

    def leave(self) -> None:
        """Mark the consumer as down.

        The inbox goes on as before, but a lossless inbox that is full blocks no sender, and its losses are only
        counted: a consumer that failed must not fail its producer.
        """
        self._attended = False
        self._wake_senders()

    def adopt(self) -> int:
        """Take over from a consumer that ended, with the messages that wait; returns how many messages a lossless inbox
        lost.

        A ``receive`` of the former consumer that still waits is cancelled; the loss is not raised again.
        """
        self._attended = True
        if self._waiter is not None:
            self._waiter.cancel()
            self._waiter = None
        lost, self._overflowed = self._overflowed, 0
        return lost

    def discard(self) -> None:
        """Discard the messages that wait, and a loss that was not raised yet."""
        self._discarded += len(self._inbox)
        self._inbox.clear()
        self._overflowed = 0
        self._wake_senders()

    def _filter_changed(self, _before: float, after: float) -> None:
        if after == CLOSED:
            if self._inbox:
                self._discarded += len(self._inbox)
                self._inbox.clear()
            if self._senders:
                self._wake_senders()
        self._on_filter()

    def statistics(self) -> SubscriptionStatistics:
        return SubscriptionStatistics(
            received=self._received,
            passed=self._passed,
            decimated=self._received - self._passed,
            dropped=self._dropped,
            discarded=self._discarded,
            taken=self.taken,
            depth=len(self._inbox),
            capacity=self._capacity,
            age_s=self._age_s,
            divisor=self.filter.divisor,
        )


def _resolve(future: asyncio.Future[bool], result: bool) -> None:
    if not future.done():
        future.set_result(result)
