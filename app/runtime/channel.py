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
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from app.base.observers import Observers
from app.messages import Message
from app.runtime.errors import ChannelClosed, InboxOverflow
from app.runtime.filter import CLOSED
from app.runtime.subscription import Subscription, SubscriptionStatistics

M = TypeVar("M", bound=Message)


@dataclass(frozen=True, slots=True)
class ChannelStatistics:
    """``published`` messages in all, the ``last_stamp`` (None before the first), and each subscription's counters."""

    published: int
    last_stamp: float | None
    subscriptions: dict[str, SubscriptionStatistics]


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
        subscriptions = self._subscriptions
        if len(subscriptions) == 1:
            # Most channels: attention rewrites thousands of filters in one step of the loop.
            divisor = subscriptions[0].filter.phi if subscriptions[0].demands else CLOSED
        else:
            divisors = [int(s.filter.divisor) for s in subscriptions if s.demands and s.filter.is_open]
            divisor = float(math.gcd(*divisors)) if divisors else CLOSED
        before = self._divisor
        if divisor == before:
            return
        self._divisor = divisor
        if self._divisor_observers:
            self._divisor_observers.notify(divisor)
        if (divisor == CLOSED) != (before == CLOSED) and self._wanted_observers:
            self._wanted_observers.notify(divisor != CLOSED)

    def statistics(self) -> ChannelStatistics:
        return ChannelStatistics(
            published=self.published,
            last_stamp=None if self.latest is None else self.latest.stamp,
            subscriptions={s.name: s.statistics() for s in self._subscriptions},
        )
