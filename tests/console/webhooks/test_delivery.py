"""Deliveries to one receiver, in virtual time: order, attempts, and what is given up."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from app.attention.timeline import Timeline
from app.console.webhooks.delivery import MOST_WAITING, OLDEST_S, WAITS_S, Answer, Delivery
from app.console.webhooks.kept import Webhook
from app.console.webhooks.signing import new_secret
from app.messages import EventKind
from app.runtime.clock import VirtualClock, in_virtual_time


class Receiver:
    """Answers each request with ``answer``, and keeps what came and when."""

    def __init__(self, answer: Callable[[int], int | None] = lambda _: 200, takes_s: float = 0.0) -> None:
        self.clock = VirtualClock()
        self.timeline = Timeline(5000, self.clock.now)
        self.answer = answer
        self.takes_s = takes_s
        self.at: list[float] = []
        self.ids: list[str] = []
        self.numbers: list[int] = []

    async def __call__(self, url: str, body: bytes, headers: dict[str, str]) -> Answer:
        self.at.append(self.clock.now() - self.clock.origin)
        self.ids.append(headers["webhook-id"])
        self.numbers.append(json.loads(body)["data"]["id"])
        await self.clock.sleep(self.takes_s)
        status = self.answer(len(self.at))
        return Answer(status, "" if status == 200 else f"answered {status}")

    @asynccontextmanager
    async def served(self, *, kinds: tuple[EventKind, ...] = ("tour",), subject: str = "") -> AsyncIterator[Delivery]:
        hook = Webhook("one", "http://there/", kinds, subject, new_secret())
        delivery = Delivery(hook, self, self.clock, "run")
        leave = self.timeline.observe(delivery.add)
        task = asyncio.create_task(delivery.run())
        yield delivery
        leave()
        task.cancel()
        await asyncio.wait({task})


@in_virtual_time
async def test_events_come_in_order_one_at_a_time() -> None:
    receiver = Receiver(takes_s=2.0)
    async with receiver.served() as delivery:
        for _ in range(3):
            receiver.timeline.add("tour", "lab", "it goes on")
        await receiver.clock.sleep(5.0)
        assert (delivery.report().state, delivery.report().waiting) == ("delivering", 1)
        await receiver.clock.sleep(5.0)
        assert receiver.at == [0.0, 2.0, 4.0]
        assert receiver.ids == ["run-1", "run-2", "run-3"]
        report = delivery.report()
        assert (report.state, report.waiting, report.delivered, report.dropped) == ("idle", 0, 3, 0)
        assert report.succeeded == receiver.clock.origin + 6


@in_virtual_time
async def test_other_kinds_and_subjects_are_not_posted() -> None:
    receiver = Receiver()
    async with receiver.served(kinds=("goal", "tour"), subject="lab") as delivery:
        receiver.timeline.add("restart", "lab", "no such kind")
        receiver.timeline.add("tour", "office", "no such subject")
        receiver.timeline.add("goal", "lab", "wanted")
        await receiver.clock.sleep(1.0)
        assert receiver.numbers == [3]
        assert delivery.report().delivered == 1


@in_virtual_time
async def test_an_event_is_posted_again_until_it_is_taken_then_the_next() -> None:
    receiver = Receiver(lambda number: 200 if number > 3 else None)
    async with receiver.served() as delivery:
        receiver.timeline.add("tour", "lab", "first")
        receiver.timeline.add("tour", "lab", "second")
        await receiver.clock.sleep(0.5)
        assert (delivery.report().state, delivery.report().problem) == ("delivering", "answered None")
        await receiver.clock.sleep(60.0)
        assert receiver.at == [0.0, 1.0, 6.0, 36.0, 36.0]
        assert receiver.ids == ["run-1"] * 4 + ["run-2"]
        assert (delivery.report().problem, delivery.report().state) == ("", "idle")


@in_virtual_time
async def test_what_is_a_day_old_is_given_up() -> None:
    receiver = Receiver(lambda _: 500)
    async with receiver.served() as delivery:
        receiver.timeline.add("tour", "lab", "nobody takes it")
        await receiver.clock.sleep(OLDEST_S + 2 * WAITS_S[-1])
        report = delivery.report()
        assert (report.state, report.dropped, report.waiting) == ("idle", 1, 0)
        receiver.answer = lambda _: 200
        receiver.timeline.add("tour", "lab", "now somebody does")
        await receiver.clock.sleep(1.0)
        assert delivery.report().delivered == 1


@in_virtual_time
async def test_a_receiver_that_is_gone_gets_nothing_more() -> None:
    receiver = Receiver(lambda _: 410)
    async with receiver.served() as delivery:
        receiver.timeline.add("tour", "lab", "first")
        receiver.timeline.add("tour", "lab", "second")
        await receiver.clock.sleep(1000.0)
        receiver.timeline.add("tour", "lab", "third")
        await receiver.clock.sleep(1000.0)
        report = delivery.report()
        assert (len(receiver.at), report.state, report.dropped, report.waiting) == (1, "gone", 2, 0)


@in_virtual_time
async def test_of_too_many_that_wait_the_oldest_but_the_one_under_way_are_given_up() -> None:
    receiver = Receiver(takes_s=1.0)
    async with receiver.served() as delivery:
        receiver.timeline.add("tour", "lab", "under way")
        await receiver.clock.sleep(0.5)
        for _ in range(MOST_WAITING + 4):
            receiver.timeline.add("tour", "lab", "it goes on")
        assert (delivery.report().waiting, delivery.report().dropped) == (MOST_WAITING, 5)
        await receiver.clock.sleep(MOST_WAITING + 10.0)
        assert receiver.numbers == [1, *range(7, MOST_WAITING + 6)]
        assert delivery.report().delivered == MOST_WAITING
