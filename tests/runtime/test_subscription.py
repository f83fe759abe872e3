"""The inbox of a subscription: what it keeps, drops and counts, and who waits at it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress

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
async def test_a_full_latest_inbox_drops_the_oldest_and_counts_it(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=2)
    for value in range(5):
        numbers.publish(make(value))
    counters = inbox.statistics()
    assert (counters.received, counters.passed, counters.dropped, counters.depth) == (5, 5, 3, 2)
    assert [(await inbox.receive()).linear_mps for _ in range(2)] == [3, 4]
    with pytest.raises(WouldBlock, match="inbox"):
        inbox.receive_nowait()


@in_virtual_time
async def test_waiting_consumers_wake_when_a_message_comes(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    waiting = asyncio.create_task(inbox.receive())
    await asyncio.sleep(1)
    assert not waiting.done()
    numbers.publish(make(7))
    assert (await waiting).linear_mps == 7


@in_virtual_time
async def test_a_resting_consumer_is_not_woken_and_has_the_newest_messages_afterwards(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=2)
    waiting = asyncio.create_task(inbox.receive())
    await asyncio.sleep(1)
    inbox.rest(True)
    for value in range(5):
        numbers.publish(make(value))
    await asyncio.sleep(1)
    assert not waiting.done()
    assert not inbox.waiting, "a consumer that rests is not stuck"
    counters = inbox.statistics()
    assert (counters.passed, counters.dropped, counters.discarded, counters.depth) == (5, 0, 3, 2)
    inbox.rest(False)
    assert (await waiting).linear_mps == 3
    assert (await inbox.receive()).linear_mps == 4


@in_virtual_time
async def test_a_consumer_that_begins_to_wait_while_it_rests_takes_nothing(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    inbox.rest(True)
    numbers.publish(make(1))
    waiting = asyncio.create_task(anext(inbox))
    await asyncio.sleep(1)
    assert not waiting.done()
    numbers.close()
    assert (await waiting).linear_mps == 1, "what waits at the end is drained"
    with pytest.raises(StopAsyncIteration):
        await anext(inbox)


def test_a_lossless_inbox_may_not_rest() -> None:
    with pytest.raises(ValueError, match="lossless"):
        channel().subscribe("log", lossless=True).rest(True)


@in_virtual_time
async def test_decimated_messages_neither_wake_nor_fill(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=10, divisor=3)
    for value in range(7):
        numbers.publish(make(value))
    assert [inbox.receive_nowait().linear_mps for _ in range(3)] == [0, 3, 6]
    assert inbox.statistics().decimated == 4


@in_virtual_time
async def test_closing_the_filter_drops_the_inbox_and_counts_it_apart(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=4)
    for value in range(3):
        numbers.publish(make(value))
    inbox.filter.divisor = CLOSED
    counters = inbox.statistics()
    assert (counters.discarded, counters.dropped, counters.depth) == (3, 0, 0)
    assert not inbox.waiting
    numbers.publish(make(9))
    inbox.filter.divisor = 2
    numbers.publish(make(10))
    assert inbox.receive_nowait().linear_mps == 10


@in_virtual_time
async def test_slowing_a_filter_down_keeps_what_already_waits(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=4)
    numbers.publish(make(1))
    inbox.filter.divisor = 5
    assert inbox.receive_nowait().linear_mps == 1


@in_virtual_time
async def test_age_is_measured_when_a_message_is_taken(make: Make) -> None:
    clock = VirtualClock()
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    assert inbox.statistics().age_s is None
    numbers.publish(make(1, clock.now()))
    await clock.sleep(0.25)
    inbox.receive_nowait()
    assert inbox.statistics().age_s == pytest.approx(0.25)


@in_virtual_time
async def test_a_lossless_inbox_that_overflows_says_so_once_and_goes_on(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("log", capacity=2, lossless=True)
    for value in range(5):
        numbers.publish(make(value))
    with pytest.raises(InboxOverflow, match=r"log: 3 messages lost, the inbox holds 2"):
        await inbox.receive()
    assert [(await inbox.receive()).linear_mps for _ in range(2)] == [0, 1]
    assert inbox.statistics().dropped == 3


@in_virtual_time
async def test_a_cancelled_receive_loses_no_message(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox", capacity=5)
    waiting = asyncio.create_task(inbox.receive())
    await asyncio.sleep(0)
    # Woken and cancelled in the same turn of the loop: the message must stay.
    numbers.publish(make(1))
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    assert (await inbox.receive()).linear_mps == 1


@given(st.lists(st.sampled_from(["publish", "cancel", "turn", "adopt"]), max_size=60), st.booleans())
def test_however_receives_are_cancelled_nothing_is_lost_doubled_or_out_of_order(
    actions: list[str], lossless: bool
) -> None:
    async def scenario() -> None:
        numbers = channel()
        inbox = numbers.subscribe("inbox", capacity=100, lossless=lossless)
        taken: list[float] = []
        published = 0

        async def take() -> None:
            while True:
                taken.append((await inbox.receive()).linear_mps)

        task = asyncio.create_task(take())
        for action in actions:
            if action == "publish":
                numbers.publish(Twist(0.0, float(published), 0.0))
                published += 1
            elif action == "turn":
                await asyncio.sleep(0)
            else:
                # The old consumer dies, in whatever state; another takes over at once.
                task.cancel()
                if action == "adopt":
                    inbox.adopt()
                else:
                    await asyncio.wait({task})
                task = asyncio.create_task(take())
        numbers.close()
        with suppress(ChannelClosed):
            await task
        assert taken == list(range(published))
        assert inbox.statistics().taken == published

    run_virtual(scenario())


@in_virtual_time
async def test_a_receive_that_times_out_leaves_the_inbox_usable(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(1):
            await inbox.receive()
    numbers.publish(make(1))
    assert (await inbox.receive()).linear_mps == 1


@in_virtual_time
async def test_a_second_task_may_not_wait_at_the_same_inbox(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    first = asyncio.create_task(inbox.receive())
    await asyncio.sleep(0)
    with pytest.raises(RuntimeError, match="inbox: two tasks wait"):
        await inbox.receive()
    numbers.publish(make(1))
    assert (await first).linear_mps == 1


def test_an_inbox_needs_room() -> None:
    with pytest.raises(ValueError, match=r"inbox of tiny needs room for at least 1 message, not 0"):
        channel().subscribe("tiny", capacity=0)


@in_virtual_time
async def test_a_lossless_inbox_without_consumer_blocks_no_sender_and_reports_its_loss_to_the_next(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("log", capacity=2, lossless=True)
    inbox.leave()
    for value in range(5):
        await numbers.send(make(value), deadline_s=0.1)
    assert inbox.adopt() == 3
    assert [(await inbox.receive()).linear_mps for _ in range(2)] == [0, 1]
    assert inbox.adopt() == 0


@in_virtual_time
async def test_leaving_frees_a_sender_that_already_waits(make: Make) -> None:
    numbers = channel()
    inbox = numbers.subscribe("log", capacity=1, lossless=True)
    numbers.publish(make(1))
    sending = asyncio.create_task(numbers.send(make(2), deadline_s=10))
    await asyncio.sleep(1)
    assert not sending.done()
    inbox.leave()
    await sending
    assert inbox.adopt() == 1, "what was not taken is lost, and counted"


@in_virtual_time
async def test_adopting_an_inbox_ends_the_former_owners_wait(make: Make) -> None:
    clock = VirtualClock()
    numbers = channel()
    inbox = numbers.subscribe("inbox")
    former = asyncio.create_task(inbox.receive())
    await clock.sleep(5)
    inbox.adopt()
    numbers.publish(make(1))
    assert (await inbox.receive()).linear_mps == 1
    with pytest.raises(asyncio.CancelledError):
        await former
