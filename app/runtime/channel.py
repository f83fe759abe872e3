"""Bounded channels: one producer, any number of subscriptions, each with its own rate filter and inbox.

``publish`` is synchronous and never waits: a message is offered to each subscription's filter, put in its inbox by
reference, and its consumer is woken once. An inbox is *latest* (bounded, the oldest is dropped and counted) or
*lossless* (bounded too: ``send`` waits for room; a ``publish`` that finds none makes the consumer's next ``receive``
raise InboxOverflow, so that no loss is silent). Nothing queues without bound.

For each subscription, at any time::

    received = passed + decimated          passed = taken + dropped + discarded + depth

A source may leave out what no filter would let through (:attr:`Channel.divisor`): what it leaves out counts as received
and decimated, as if the filter had stopped it.
"""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from app.base.observers import Observers
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


@dataclass(frozen=True, slots=True)
class ChannelStatistics:
    """``published`` messages in all, the ``last_stamp`` (None before the first), and each subscription's counters."""

    published: int
    last_stamp: float | None
    subscriptions: dict[str, SubscriptionStatistics]


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

    def _filter_changed(self, _before: float, _after: float) -> None:
        if not self.filter.is_open:
            self._discarded += len(self._inbox)
            self._inbox.clear()
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


class Channel(Generic[M]):
    """A named, typed stream of messages."""

    def __init__(self, name: str, message_type: type[M], now: Callable[[], float]) -> None:
        self.name = name
        self.message_type = message_type
        #: The newest message published, None before the first.
        self.latest: M | None = None
        self._now = now
        self._subscriptions: tuple[Subscription[M], ...] = ()
        self._lossless: tuple[Subscription[M], ...] = ()
        #: How many messages were published so far.
        self.published = 0
        #: How many periods of the source they ended: with those that it left out.
        self.periods = 0
        self._closed = False
        self._divisor: float = CLOSED
        self._divisor_observers: Observers[[float]] = Observers(f"demand for channel {name}")
        self._wanted_observers: Observers[[bool]] = Observers(f"demand for channel {name}")
        self._observers: Observers[[M]] = Observers(f"channel {name}")

    def publish(self, message: M, periods: int = 1) -> None:
        """Give ``message`` to every subscription; never waits. Raises ChannelClosed after :meth:`close`.

        It ends ``periods`` of the source: more than one after some that the source left out, see :attr:`divisor`.
        """
        if self._closed:
            raise ChannelClosed(f"{self.name}: published on a closed channel")
        self.published += 1
        self.periods += periods
        self.latest = message
        for subscription in self._subscriptions:
            subscription.offer(message, periods)
        if self._observers:
            self._observers.notify(message)

    async def send(self, message: M, deadline_s: float) -> None:
        """Publish once every lossless inbox has room.

        Raises InboxOverflow after ``deadline_s``; no subscription received the message then.
        """
        for subscription in self._lossless:
            if not subscription.has_room():
                await self._wait_room(deadline_s)
                break
        self.publish(message)

    async def _wait_room(self, deadline_s: float) -> None:
        give_up_at = asyncio.get_running_loop().time() + deadline_s
        # All inboxes are checked again after each wait: one that had room may have been filled in the meantime.
        while full_one := next((s for s in self._lossless if not s.has_room()), None):
            in_time = await full_one.wait_for_room(give_up_at)
            if not in_time and (full := ", ".join(s.name for s in self._lossless if not s.has_room())):
                raise InboxOverflow(f"{self.name}: no room within {deadline_s} s at {full}")

    def subscribe(
        self, name: str, *, capacity: int = 1, lossless: bool = False, divisor: float = 1, demands: bool = True
    ) -> Subscription[M]:
        """Add a consumer called ``name`` with an inbox of ``capacity`` messages behind a filter of ``divisor``.

        Without ``demands`` the channel is not :attr:`wanted` for it (see :meth:`Subscription.demand`). Raises
        ChannelClosed after :meth:`close`: nothing would ever come.
        """
        if self._closed:
            raise ChannelClosed(f"{self.name}: {name} subscribed to a closed channel")
        subscription: Subscription[M] = Subscription(
            name,
            self._now,
            capacity=capacity,
            lossless=lossless,
            divisor=divisor,
            on_filter=self._update_wanted,
            on_close=self.unsubscribe,
            demands=demands,
        )
        self._set_subscriptions((*self._subscriptions, subscription))
        return subscription

    def unsubscribe(self, subscription: Subscription[M]) -> None:
        """Remove and close a consumer; unknown ones are ignored, so that it may be called twice."""
        subscription.end()
        self._set_subscriptions(tuple(s for s in self._subscriptions if s is not subscription))

    @property
    def closed(self) -> bool:
        """Whether the stream has ended."""
        return self._closed

    def close(self) -> None:
        """End the stream: consumers drain what waits, then see ChannelClosed."""
        self._closed = True
        # Not unsubscribed: the counters of a stream that has ended can still be read.
        for subscription in self._subscriptions:
            subscription.end()

    def clear(self) -> None:
        """Forget :attr:`latest` and what waits in every inbox; the counters go on."""
        self.latest = None
        for subscription in self._subscriptions:
            subscription.discard()

    def observe(self, callback: Callable[[M], None]) -> Callable[[], None]:
        """Call ``callback`` with every message published, within its ``publish``; returns a function that ends this.

        An observer is no subscription: the channel is not :attr:`wanted` for it. An observer that raises is removed.
        """
        return self._observers.add(callback)

    @property
    def wanted(self) -> bool:
        """Whether the filter of any subscription that demands it is open: a source may rest otherwise."""
        return self._divisor != CLOSED

    @property
    def divisor(self) -> float:
        """The greatest common divisor of the open filters' φ, ``CLOSED`` without any that demands the channel.

        A source that gives one message in so many periods, and says so in :meth:`publish`, gives every subscription all
        that its filter would let through: each of those keeps its own phase.
        """
        return self._divisor

    def on_divisor(self, callback: Callable[[float], None]) -> Callable[[], None]:
        """Call ``callback(divisor)`` now and whenever :attr:`divisor` changes; else as :meth:`on_wanted`."""
        remove = self._divisor_observers.add(callback)
        callback(self._divisor)
        return remove

    def on_wanted(self, callback: Callable[[bool], None]) -> Callable[[], None]:
        """Call ``callback(wanted)`` now and whenever :attr:`wanted` changes.

        Returns a function that ends this, which may be called twice. A callback that raises later is removed.
        """
        remove = self._wanted_observers.add(callback)
        callback(self.wanted)
        return remove

    def _set_subscriptions(self, subscriptions: tuple[Subscription[M], ...]) -> None:
        self._subscriptions = subscriptions
        self._lossless = tuple(s for s in subscriptions if s.lossless)
        self._update_wanted()

    def _update_wanted(self) -> None:
        divisors = [int(s.filter.divisor) for s in self._subscriptions if s.demands and s.filter.is_open]
        divisor = float(math.gcd(*divisors)) if divisors else CLOSED
        before, self._divisor = self._divisor, divisor
        if divisor != before:
            self._divisor_observers.notify(divisor)
        if (divisor == CLOSED) != (before == CLOSED):
            self._wanted_observers.notify(divisor != CLOSED)

    def statistics(self) -> ChannelStatistics:
        return ChannelStatistics(
            published=self.published,
            last_stamp=None if self.latest is None else self.latest.stamp,
            subscriptions={s.name: s.statistics() for s in self._subscriptions},
        )


def _resolve(future: asyncio.Future[bool], result: bool) -> None:
    if not future.done():
        future.set_result(result)
