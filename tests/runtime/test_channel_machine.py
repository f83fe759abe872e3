"""Any sequence of publishing, taking, filtering, adopting: the counters add up and nothing is lost or doubled."""

from __future__ import annotations

from collections import deque

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, initialize, invariant, rule

from app.messages import Twist
from app.runtime.channel import Channel
from app.runtime.errors import InboxOverflow, WouldBlock
from app.runtime.filter import CLOSED
from app.runtime.subscription import Subscription

divisors = st.one_of(st.integers(1, 4), st.just(CLOSED))


class Model:
    """One subscription as the documentation describes it, in the plainest words."""

    def __init__(self, capacity: int, lossless: bool, divisor: float) -> None:
        self.capacity, self.lossless, self.divisor = capacity, lossless, divisor
        self.since_change = 0
        self.inbox: deque[float] = deque()
        self.lost_unsaid = 0
        self.received = self.passed = self.dropped = self.discarded = self.taken = 0

    def offer(self, value: float) -> None:
        self.received += 1
        passes = self.divisor != CLOSED and self.since_change % self.divisor == 0
        self.since_change += 1
        if not passes:
            return
        self.passed += 1
        if len(self.inbox) < self.capacity:
            self.inbox.append(value)
            return
        self.dropped += 1
        if self.lossless:
            self.lost_unsaid += 1
        else:
            self.inbox.popleft()
            self.inbox.append(value)

    def write(self, divisor: float) -> None:
        if divisor == self.divisor:
            return
        self.divisor, self.since_change = divisor, 0
        if divisor == CLOSED:
            self.discarded += len(self.inbox)
            self.inbox.clear()


class ChannelMachine(RuleBasedStateMachine):
    subscriptions = Bundle("subscriptions")

    def __init__(self) -> None:
        super().__init__()
        self.now = 0.0
        self.channel: Channel[Twist] = Channel("numbers", Twist, lambda: self.now)
        self.models: dict[Subscription[Twist], Model] = {}
        self.published = 0
        self.reported: bool | None = None

    @initialize()
    def listen(self) -> None:
        self.channel.on_wanted(self.note_demand)

    def note_demand(self, wanted: bool) -> None:
        assert wanted != self.reported, "reported twice"
        self.reported = wanted

    @rule(target=subscriptions, capacity=st.integers(1, 3), lossless=st.booleans(), divisor=divisors)
    def subscribe(self, capacity: int, lossless: bool, divisor: float) -> Subscription[Twist]:
        name = f"s{len(self.models)}"
        subscription = self.channel.subscribe(name, capacity=capacity, lossless=lossless, divisor=divisor)
        self.models[subscription] = Model(capacity, lossless, divisor)
        return subscription

    @rule(count=st.integers(1, 5))
    def publish(self, count: int) -> None:
        for _ in range(count):
            self.now += 1
            self.published += 1
            self.channel.publish(Twist(self.now, float(self.published), 0.0))
            for model in self.models.values():
                model.offer(float(self.published))

    @rule(subscription=subscriptions, divisor=divisors)
    def write_filter(self, subscription: Subscription[Twist], divisor: float) -> None:
        subscription.filter.divisor = divisor
        self.models[subscription].write(divisor)

    @rule(subscription=subscriptions)
    def take(self, subscription: Subscription[Twist]) -> None:
        self.now += 1
        model = self.models[subscription]
        if model.lost_unsaid:
            with pytest.raises(InboxOverflow, match=f"{model.lost_unsaid} messages lost"):
                subscription.receive_nowait()
            model.lost_unsaid = 0
        elif model.inbox:
            assert subscription.receive_nowait().linear_mps == model.inbox.popleft()
            model.taken += 1
        else:
            with pytest.raises(WouldBlock):
                subscription.receive_nowait()

    @rule(subscription=subscriptions)
    def adopt(self, subscription: Subscription[Twist]) -> None:
        subscription.leave()
        assert subscription.adopt() == self.models[subscription].lost_unsaid
        self.models[subscription].lost_unsaid = 0

    @rule(subscription=consumes(subscriptions))
    def unsubscribe(self, subscription: Subscription[Twist]) -> None:
        self.channel.unsubscribe(subscription)
        model = self.models.pop(subscription)
        waiting = list(model.inbox)
        if not model.lost_unsaid:
            assert [subscription.receive_nowait().linear_mps for _ in waiting] == waiting

    @invariant()
    def counters_add_up(self) -> None:
        statistics = self.channel.statistics()
        assert statistics.published == self.published
        for subscription, model in self.models.items():
            s = subscription.statistics()
            assert s.received == s.passed + s.decimated
            assert s.passed == s.taken + s.dropped + s.discarded + s.depth
            assert s.depth <= s.capacity
            assert (s.received, s.passed, s.dropped, s.discarded, s.taken, s.depth) == (
                model.received, model.passed, model.dropped, model.discarded, model.taken, len(model.inbox)
            )  # fmt: skip
            assert subscription.waiting == bool(model.inbox)
            if model.lossless:
                assert subscription.has_room() == (len(model.inbox) < model.capacity)

    @invariant()
    def wanted_is_whether_any_is_open(self) -> None:
        wanted = any(model.divisor != CLOSED for model in self.models.values())
        assert self.channel.wanted == wanted
        assert self.reported in (None, wanted)


TestChannelMachine = ChannelMachine.TestCase
TestChannelMachine.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
