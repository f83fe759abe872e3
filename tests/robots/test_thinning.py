"""Thinning at the source: whole periods left out, and counted."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.messages import Twist
from app.robots.thinning import Thinning
from app.runtime.channel import Channel
from app.runtime.filter import CLOSED
from app.runtime.subscription import Subscription

RATE_HZ = 15.0


def messages(thinning: Thinning, periods: int) -> list[int]:
    """What is given in so many periods: how many each message ends."""
    return [ended for _ in range(periods) if (ended := thinning.period())]


@pytest.mark.parametrize(
    ("demanded", "divisor"), [(math.inf, 1), (RATE_HZ, 1), (RATE_HZ / 4, 4), (RATE_HZ / 7, 7), (4.0, 4), (0.1, 150)]
)
def test_a_stream_is_given_at_most_at_the_rate_demanded(demanded: float, divisor: int) -> None:
    thinning = Thinning(RATE_HZ)
    thinning.demand(demanded)
    assert messages(thinning, 3 * divisor) == [1, divisor, divisor]


def test_after_a_rest_the_first_period_gives_a_message_that_ends_it_alone() -> None:
    thinning = Thinning(RATE_HZ)
    thinning.demand(RATE_HZ / 4)
    assert messages(thinning, 7) == [1, 4]
    thinning.demand(0.0)
    thinning.demand(RATE_HZ / 4)
    assert thinning.gives
    assert thinning.period() == 1


def test_a_higher_demand_is_met_with_the_next_period() -> None:
    thinning = Thinning(RATE_HZ)
    thinning.demand(RATE_HZ / 8)
    assert messages(thinning, 6) == [1]
    thinning.demand(RATE_HZ / 2)
    assert thinning.gives
    assert messages(thinning, 5) == [6, 2, 2]


@given(st.lists(st.tuples(st.sampled_from([1, 2, 3, 4, 8]), st.integers(1, 20)), max_size=20))
def test_no_period_is_lost_or_counted_twice(demands: list[tuple[int, int]]) -> None:
    thinning = Thinning(RATE_HZ)
    passed = counted = 0
    for divisor, periods in demands:
        thinning.demand(RATE_HZ / divisor)
        for _ in range(periods):
            passed += 1
            gives = thinning.gives
            ended = thinning.period()
            assert gives == (ended > 0)
            counted += ended
            assert counted <= passed
            if ended:
                assert counted == passed
            assert passed - counted < divisor


class ThinnedSource:
    """A source of a channel that leaves out what no filter lets through; its messages are numbered by period."""

    def __init__(self) -> None:
        self.channel = Channel("numbers", Twist, lambda: 0.0)
        self.thinning = Thinning(RATE_HZ)
        self.channel.on_divisor(lambda divisor: self.thinning.demand(0.0 if divisor == CLOSED else RATE_HZ / divisor))
        self.now = 0

    def run(self, periods: int) -> None:
        for _ in range(periods):
            if self.channel.wanted and (ended := self.thinning.period()):
                self.channel.publish(Twist(float(self.now), 0.0, 0.0), ended)
            self.now += 1


def taken(inbox: Subscription[Twist]) -> list[int]:
    return [round(inbox.receive_nowait().stamp) for _ in range(inbox.statistics().depth)]


@given(divisors=st.lists(st.integers(1, 12), min_size=1, max_size=4), periods=st.integers(1, 100))
def test_every_filter_gets_each_message_that_it_would_get_of_the_whole_stream(
    divisors: list[int], periods: int
) -> None:
    source = ThinnedSource()
    inboxes = [source.channel.subscribe(str(i), capacity=200, divisor=phi) for i, phi in enumerate(divisors)]
    source.run(periods)
    for phi, inbox in zip(divisors, inboxes, strict=True):
        assert taken(inbox) == list(range(0, periods, phi))
        assert inbox.statistics().received <= periods
    assert source.channel.published <= -(-periods // math.gcd(*divisors))


@given(
    phi=st.integers(1, 8),
    changes=st.lists(st.tuples(st.sampled_from([1, 2, 3, 4, 6, 8, CLOSED]), st.integers(1, 30)), min_size=1),
)
def test_a_filter_keeps_its_rate_while_others_change(phi: int, changes: list[tuple[float, int]]) -> None:
    source = ThinnedSource()
    inbox = source.channel.subscribe("steady", capacity=2000, divisor=phi)
    other = source.channel.subscribe("other", divisor=CLOSED)
    for divisor, periods in changes:
        other.filter.divisor = divisor
        source.run(periods)
    numbers = taken(inbox)
    assert all(after - before < 2 * phi for before, after in pairwise(numbers))
    # Late by less than a gap each time, never early: nothing adds up
    assert all(i * phi <= number < (i + 1) * phi for i, number in enumerate(numbers))
    assert len(numbers) >= source.now // phi
