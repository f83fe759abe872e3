from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.messages import Twist
from app.runtime.channel import Channel
from app.runtime.clock import VirtualClock, in_virtual_time, run_virtual
from app.runtime.errors import ChannelClosed, InboxOverflow, WouldBlock
from app.runtime.filter import CLOSED

Make = Callable[..., Twist]


def channel() -> Channel[Twist]:
    return Channel("numbers", Twist, VirtualClock().now)


@in_virtual_time
async def test_a_message_reaches_every_subscription_by_reference(make: Make) -> None:
    numbers = channel()
    first, second = numbers.subscribe("first"), numbers.subscribe("second")
    message = make(1)
    numbers.publish(message)
    assert await first.receive() is message
    assert second.receive_nowait() is message
    assert numbers.latest is message


@in_virtual_time
async def test_send_waits_for_room_and_loses_nothing(make: Make) -> None:
    clock = VirtualClock()
    numbers = channel()
    inbox = numbers.subscribe("log", capacity=2, lossless=True)

    async def produce() -> None:
        for value in range(20):
            await numbers.send(make(value), deadline_s=1.0)

    producing = asyncio.create_task(produce())
    taken = []
    for _ in range(20):
        await clock.sleep(0.5)
        taken.append((await inbox.receive()).linear_mps)
    await producing
    assert taken == list(range(20))
    assert inbox.statistics().dropped == 0


@in_virtual_time
async def test_send_gives_up_at_its_deadline_without_a_delivery(make: Make) -> None:
    clock = VirtualClock()
    numbers = channel()
    numbers.subscribe("log", capacity=1, lossless=True)
    free = numbers.subscribe("free", capacity=5)
    numbers.publish(make(1))
    began = clock.now()
    with pytest.raises(InboxOverflow, match=r"no room within 0.3 s at log"):
        await numbers.send(make(2), deadline_s=0.3)
    assert clock.now() - began == pytest.approx(0.3)
    assert free.statistics().received == 1


@in_virtual_time
async def test_two_senders_to_two_lossless_inboxes_never_overflow(make: Make) -> None:
    # A sender that found room at the first and waited for the second must look at the first again.
    numbers = channel()
    first = numbers.subscribe("first", capacity=1, lossless=True)
    second = numbers.subscribe("second", capacity=1, lossless=True)
    numbers.publish(make(0))
    first.receive_nowait()
    senders = [asyncio.create_task(numbers.send(make(value), deadline_s=10)) for value in (1, 2)]
    await asyncio.sleep(0)
    second.receive_nowait()
    numbers.publish(make(3))
    second.receive_nowait()
    await asyncio.sleep(1)
    assert first.statistics().dropped == 0
    first.receive_nowait()
    for _ in range(2):
        await asyncio.sleep(1)
        first.receive_nowait()
        second.receive_nowait()
    await asyncio.gather(*senders)
    assert first.statistics().dropped == second.statistics().dropped == 0


SENDS = st.lists(st.tuples(st.sampled_from(["late", "cancelled", "served"]), st.integers(1, 3)), max_size=12)


@given(SENDS)
def test_nothing_is_left_of_a_send_that_ended_however_it_ended(sends: list[tuple[str, int]]) -> None:
    async def send_all() -> None:
        clock = VirtualClock()
        numbers = channel()
        inbox = numbers.subscribe("log", capacity=1, lossless=True)
        numbers.publish(Twist(0.0, 0.0, 0.0))
        for end, together in sends:
            deadline_s = 0.1 if end == "late" else 1e6
            tasks = [asyncio.create_task(numbers.send(Twist(0.0, 0.0, 0.0), deadline_s)) for _ in range(together)]
            await clock.sleep(0.05)
            assert len(inbox._senders) == together
            for task in tasks:
                if end == "cancelled":
                    task.cancel()
                elif end == "served":
                    inbox.receive_nowait()
                    await clock.sleep(0.05)
            ends = await asyncio.gather(*tasks, return_exceptions=True)
            expected = {"late": InboxOverflow, "cancelled": asyncio.CancelledError, "served": type(None)}[end]
            assert {type(each) for each in ends} == {expected}
            assert not inbox._senders

    run_virtual(send_all())


@in_virtual_time
async def test_closing_a_filter_frees_a_waiting_sender(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("log", capacity=1, lossless=True)
    numbers.publish(make(1))
    sending = asyncio.create_task(numbers.send(make(2), deadline_s=10))
    await asyncio.sleep(1)
    inbox.filter.divisor = CLOSED
    await sending
    assert numbers.statistics().published == 2


@in_virtual_time
async def test_consumers_drain_a_closed_channel_and_then_see_its_end(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=3)
    numbers.publish(make(1))
    numbers.publish(make(2))
    numbers.close()
    assert [m.linear_mps async for m in inbox] == [1, 2]
    with pytest.raises(ChannelClosed, match="inbox"):
        await inbox.receive()
    with pytest.raises(ChannelClosed, match="published on a closed channel"):
        numbers.publish(make(3))
    with pytest.raises(ChannelClosed, match="late subscribed to a closed channel"):
        numbers.subscribe("late")


@in_virtual_time
async def test_closing_wakes_who_waits() -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    waiting = asyncio.create_task(inbox.receive())
    await asyncio.sleep(0)
    numbers.close()
    with pytest.raises(ChannelClosed):
        await waiting


@in_virtual_time
async def test_a_consumer_that_closes_its_end_leaves_the_channel(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=5)
    numbers.publish(make(1))
    inbox.close()
    inbox.close()
    numbers.publish(make(2))
    assert [m.linear_mps async for m in inbox] == [1]
    assert not numbers.wanted
    assert numbers.statistics().subscriptions == {}
    numbers.unsubscribe(inbox)


def test_the_greatest_common_divisor_of_the_open_filters_is_reported_when_it_changes() -> None:
    numbers = channel()
    reported: list[float] = []
    end = numbers.on_divisor(reported.append)
    first = numbers.subscribe("first", divisor=4)
    second = numbers.subscribe("second", divisor=CLOSED)
    numbers.subscribe("observing", divisor=1, demands=False)
    second.filter.divisor = 6
    first.filter.divisor = 8
    second.filter.divisor = 3
    assert reported == [CLOSED, 4, 2, 1]
    first.close()
    second.filter.divisor = CLOSED
    assert reported == [CLOSED, 4, 2, 1, 3, CLOSED]
    end()
    second.filter.divisor = 5
    assert reported[-1] == CLOSED
    assert numbers.divisor == 5


def test_what_the_source_left_out_counts_as_decimated(make: Make) -> None:
    numbers = channel()
    each, every_other = numbers.subscribe("each", divisor=4), numbers.subscribe("other", divisor=8)
    for value in range(5):
        numbers.publish(make(value), periods=4 if value else 1)
    assert numbers.published == 5
    assert numbers.periods == 17
    for inbox, passed in ((each, 5), (every_other, 3)):
        counters = inbox.statistics()
        assert (counters.received, counters.passed, counters.decimated) == (17, passed, 17 - passed)


def test_wanted_is_reported_only_when_it_changes() -> None:
    numbers = channel()
    demands: list[bool] = []
    end = numbers.on_wanted(demands.append)
    first = numbers.subscribe("first")
    second = numbers.subscribe("second", divisor=CLOSED)
    second.filter.divisor = 4
    first.filter.divisor = CLOSED
    assert demands == [False, True]
    second.filter.divisor = CLOSED
    assert demands == [False, True, False]
    second.filter.divisor = 9
    numbers.unsubscribe(second)
    assert demands == [False, True, False, True, False]
    end()
    end()
    first.filter.divisor = 1
    assert numbers.wanted
    assert len(demands) == 5


def test_a_wanted_callback_that_fails_is_logged_and_removed(caplog: pytest.LogCaptureFixture) -> None:
    numbers = channel()
    demands: list[bool] = []

    def broken(wanted: bool) -> None:
        if wanted:
            raise OSError("the device is gone")

    numbers.on_wanted(broken)
    numbers.on_wanted(demands.append)
    numbers.subscribe("inbox")
    assert demands == [False, True]
    assert "channel numbers" in caplog.text
    assert "the device is gone" in caplog.text


@in_virtual_time
async def test_an_observer_sees_everything_and_wants_nothing(make: Make) -> None:
    numbers = channel()
    seen: list[Twist] = []
    end = numbers.observe(seen.append)
    assert not numbers.wanted
    messages = [make(value) for value in range(3)]
    for message in messages:
        numbers.publish(message)
    end()
    end()
    numbers.publish(make(4))
    assert seen == messages


@in_virtual_time
async def test_an_observer_that_fails_disturbs_neither_the_producer_nor_the_consumers(
    make: Make, caplog: pytest.LogCaptureFixture
) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=2)

    def fails(message: Twist) -> None:
        raise LookupError

    numbers.observe(fails)
    numbers.publish(make(1))
    numbers.publish(make(2))
    assert inbox.statistics().passed == 2
    assert caplog.text.count("failed and goes on") == 2


@in_virtual_time
async def test_a_channel_that_forgets_has_nothing_waiting_and_counts_on(make: Make) -> None:
    numbers = channel()
    inbox, safe = numbers.subscribe("inbox", capacity=2), numbers.subscribe("safe", capacity=1, lossless=True)
    for value in range(3):
        numbers.publish(make(value))
    numbers.clear()
    assert numbers.latest is None
    for subscription in (inbox, safe):
        counters = subscription.statistics()
        assert (counters.depth, counters.received, counters.passed) == (0, 3, 3)
        assert counters.passed == counters.taken + counters.dropped + counters.discarded + counters.depth
        with pytest.raises(WouldBlock):  # and no InboxOverflow: that loss is of another time
            subscription.receive_nowait()
    numbers.publish(make(9))
    assert (await safe.receive()).linear_mps == 9


@in_virtual_time
async def test_forgetting_makes_room_for_who_waits_to_send(make: Make) -> None:
    numbers = channel()
    safe = numbers.subscribe("safe", capacity=1, lossless=True)
    numbers.publish(make(1))
    sending = asyncio.create_task(numbers.send(make(2), deadline_s=5))
    await asyncio.sleep(1)
    assert not sending.done()
    numbers.clear()
    await sending
    assert (await safe.receive()).linear_mps == 2


def test_a_subscription_that_does_not_demand_gets_what_is_published_and_keeps_no_source_awake() -> None:
    channel = Channel("scan", Twist, lambda: 0.0)
    demands: list[bool] = []
    channel.on_wanted(demands.append)
    observing = channel.subscribe("observing", demands=False)
    channel.publish(Twist(1.0, 0.0, 0.0))
    assert observing.receive_nowait().stamp == 1.0
    assert not channel.wanted
    observing.demand(True)
    observing.demand(True)
    observing.demand(False)
    assert demands == [False, True, False]
