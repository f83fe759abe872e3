"""A running robot, driven by a page without a browser; the guard's own log is the witness."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable

from app.robots.simulated.guard_log import GuardRow
from tests.browser.running import Robot
from tests.console.live_client import Page
from tests.patience import PATIENCE_S

BEAT_S = 0.05
STILL_S = 0.5


def moving(row: GuardRow) -> bool:
    return row.linear_mps != 0 or row.angular_radps != 0


def still(rows: list[GuardRow]) -> bool:
    """Whether they have been given nothing for a while: not by a hitch of a busy computer."""
    return bool(rows) and not any(moving(row) for row in rows if row.monotonic_s >= rows[-1].monotonic_s - STILL_S)


async def until(robot: Robot, holds: Callable[[list[GuardRow]], bool]) -> list[GuardRow]:
    """What the wheels were given, once ``holds`` is true of it."""
    async with asyncio.timeout(PATIENCE_S):
        while not holds(rows := await asyncio.to_thread(robot.wheels)):  # noqa: ASYNC110  # a file gives no notice of changes
            await asyncio.sleep(BEAT_S)
    return rows


async def guard_goes_on(robot: Robot, seconds: float) -> list[GuardRow]:
    """Until the guard has decided for so long."""
    last = (await asyncio.to_thread(robot.wheels))[-1].monotonic_s
    return await until(robot, lambda rows: rows[-1].monotonic_s > last + seconds)


@contextlib.asynccontextmanager
async def held(ann: Page) -> AsyncIterator[None]:
    """Ann turns on the spot, her key held: a command each 50 ms."""

    async def hold() -> None:
        while True:
            await ann.drive(0.0, 1.0)
            await asyncio.sleep(BEAT_S)

    await ann.drive(0.0, held=False)
    holding = asyncio.create_task(hold())
    try:
        yield
    finally:
        holding.cancel()
        await asyncio.wait({holding})


async def drive_off(robot: Robot, ann: Page) -> None:
    """Returns once the wheels turn: what comes too late on a busy computer is pressed again."""
    before = len(await asyncio.to_thread(robot.wheels))
    await until(robot, lambda rows: any(map(moving, rows[before:])))


async def all_arrived(ann: Page) -> None:
    """Until the robot has taken everything that was sent before."""
    sent = ann.clock()
    await ann.send("ping", t=sent)
    await ann.until("pong", lambda pong: pong["t"] == sent, within_s=PATIENCE_S)
