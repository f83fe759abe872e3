"""A device's thread: what it says when a device is not as it should be, and what it does with what is stale."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from app.robots.devices.reader_thread import InputReader
from tests.patience import PATIENCE_S


class Clock:
    """A live source of numbers that run on whether they are read or not; ``waiting`` of them unread."""

    live = True

    def __init__(self) -> None:
        self.number = 0
        self.waiting: list[int] = []

    def tick(self) -> None:
        self.number += 1
        self.waiting.append(self.number)

    def read(self) -> int:
        if not self.waiting:
            self.tick()
        return self.waiting.pop(0)

    def skip(self) -> None:
        self.waiting.clear()

    def close(self) -> None: ...


def reader(source: Callable[[], Clock], take: Callable[[int], None]) -> InputReader[int]:
    return InputReader("clock", source, take, pause_s=lambda: 0.0, most_waiting=1)


async def test_an_unforeseen_exception_is_raised_where_it_is_started() -> None:
    def broken() -> Clock:
        raise ZeroDivisionError("a driver's fault")

    with pytest.raises(ZeroDivisionError):
        await asyncio.wait_for(reader(broken, lambda _: None).start(), PATIENCE_S)


async def test_what_piled_up_without_demand_is_not_given_as_new() -> None:
    clock = Clock()
    first: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    def take(number: int) -> None:
        if not first.done():
            first.set_result(number)

    reading = reader(lambda: clock, take)
    assert await reading.start() == ""
    for _ in range(5):
        clock.tick()
    reading.want(True)
    assert await asyncio.wait_for(first, PATIENCE_S) == 6
    await reading.stop()
