"""Channels beside what else passes messages in one process: ``python -m benchmarks.channels [--quick] [--json]``.

Ours (filter, bounded inbox and counters included), a bare ``asyncio.Queue`` (one per consumer), anyio's memory object
streams (one per consumer) and ezmsg (its own threads and graph server; zero-copy receive). One producer, 1 or 10
consumers; a small message and a 640x480x3 image, passed by reference. Every consumer gets every message.

*Throughput* runs as fast as back-pressure allows: inboxes of 10, the producer yields when they are full. CPU is the
process's, all threads. *Latency* is measured at a fixed pace (200 Hz small, 60 Hz image), from the send to the moment
the consumer holds the message, over all consumers. Contenders take turns within each round, in an order that changes;
each figure is the median over the rounds.
"""

from __future__ import annotations

import asyncio
import gc
import random
import sys
import time
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from dataclasses import dataclass
from statistics import quantiles
from typing import Any

import anyio
import numpy as np

from app.base.geometry import CameraModel, Pose3
from app.messages import Image, Message, Twist, read_only
from app.runtime.channel import Channel
from app.runtime.clock import RealClock
from benchmarks.ezmsg_peer import ezmsg_ends, ezmsg_server
from benchmarks.report import Row, benchmark_main, row

CAPACITY = 10


@dataclass(frozen=True)
class Figures:
    """One run: messages published per second, CPU (µs of all threads) per message published, latencies (µs)."""

    rate_hz: float
    cpu_us: float
    latencies_us: Sequence[float]


#: Sends ``count`` messages to ``consumers`` consumers, ``pace_hz`` of them a second (None: as fast as it goes).
Contender = Callable[[Callable[[], Message], int, int, float | None], Awaitable[Figures]]


def small() -> Message:
    """A velocity command."""
    return Twist(time.monotonic(), 0.1, 0.2)


_COLOR = read_only(np.zeros((480, 640, 3), np.uint8))
_CAMERA = CameraModel.from_vertical_fov(640, 480, 0.75)
_POSE = Pose3.identity()


def image() -> Message:
    """A camera's image."""
    return Image(time.monotonic(), "camera", _COLOR, None, _CAMERA, _POSE)


async def ours(make: Callable[[], Message], count: int, consumers: int, pace_hz: float | None) -> Figures:
    """Our channel: lossless when everything must arrive as fast as it can, newest-wins when paced."""
    channel: Channel[Message] = Channel("benchmark", Message, RealClock().now)  # type: ignore[type-abstract]
    latencies: list[float] = []

    async def consume(number: int) -> None:
        inbox = channel.subscribe(f"consumer-{number}", capacity=CAPACITY, lossless=pace_hz is None)
        for _ in range(count):
            message = await inbox.receive()
            if pace_hz is not None:
                latencies.append(time.monotonic() - message.stamp)

    async def send() -> None:
        if pace_hz is None:
            await channel.send(make(), deadline_s=10.0)
        else:
            channel.publish(make())

    return await _run(consume, consumers, send, count, pace_hz, latencies)


async def queues(make: Callable[[], Message], count: int, consumers: int, pace_hz: float | None) -> Figures:
    """A bare bounded queue for each consumer."""
    all_queues: list[asyncio.Queue[Message]] = [asyncio.Queue(CAPACITY) for _ in range(consumers)]
    latencies: list[float] = []

    async def consume(number: int) -> None:
        queue = all_queues[number]
        for _ in range(count):
            message = await queue.get()
            if pace_hz is not None:
                latencies.append(time.monotonic() - message.stamp)

    async def send() -> None:
        message = make()
        for queue in all_queues:
            await queue.put(message)

    return await _run(consume, consumers, send, count, pace_hz, latencies)


async def anyio_streams(make: Callable[[], Message], count: int, consumers: int, pace_hz: float | None) -> Figures:
    """A memory object stream for each consumer."""
    pairs = [anyio.create_memory_object_stream[Message](CAPACITY) for _ in range(consumers)]
    latencies: list[float] = []

    async def consume(number: int) -> None:
        receive = pairs[number][1]
        for _ in range(count):
            message = await receive.receive()
            if pace_hz is not None:
                latencies.append(time.monotonic() - message.stamp)

    async def send() -> None:
        message = make()
        for sender, _ in pairs:
            await sender.send(message)

    figures = await _run(consume, consumers, send, count, pace_hz, latencies)
    for sender, receiver in pairs:
        sender.close()
        receiver.close()
    return figures


def ezmsg_at(address: tuple[str, int]) -> Contender:
    """ezmsg through the graph server at ``address``."""

    async def ezmsg(make: Callable[[], Message], count: int, consumers: int, pace_hz: float | None) -> Figures:
        latencies: list[float] = []
        async with ezmsg_ends(address, consumers, CAPACITY) as (publisher, subscribers):

            async def consume(number: int) -> None:
                subscriber = subscribers[number]
                for _ in range(count):
                    async with subscriber.recv_zero_copy() as message:
                        if pace_hz is not None:
                            latencies.append(time.monotonic() - message.stamp)

            async def send() -> None:
                await publisher.broadcast(make())

            return await _run(consume, consumers, send, count, pace_hz, latencies)

    return ezmsg


async def _run(
    consume: Callable[[int], Coroutine[Any, Any, None]],
    consumers: int,
    send: Callable[[], Awaitable[None]],
    count: int,
    pace_hz: float | None,
    latencies: list[float],
) -> Figures:
    """Start the consumers, send ``count`` messages, wait until all are taken: the same for every contender."""
    gc.collect()
    async with asyncio.TaskGroup() as group:
        for number in range(consumers):
            group.create_task(consume(number))
        await asyncio.sleep(0)
        wall, cpu = time.monotonic(), time.process_time()
        due = wall
        for _ in range(count):
            if pace_hz is not None:
                due += 1 / pace_hz
                await asyncio.sleep(due - time.monotonic())
            await send()
    wall, cpu = time.monotonic() - wall, time.process_time() - cpu
    return Figures(count / wall, 1e6 * cpu / count, [1e6 * seconds for seconds in latencies])


@dataclass(frozen=True)
class Case:
    """What is sent to how many, how often, and how many messages make a run long enough."""

    name: str
    make: Callable[[], Message]
    consumers: int
    messages: int
    paced_messages: int
    pace_hz: float


CASES = (
    Case("small 1->1", small, 1, 20_000, 200, 200.0),
    Case("small 1->10", small, 10, 3_000, 200, 200.0),
    Case("image 1->1", image, 1, 20_000, 60, 60.0),
    Case("image 1->10", image, 10, 3_000, 60, 60.0),
)

#: Much slower ones get fewer messages, or the run would be theirs alone.
SHARE = {"anyio": {1: 0.3, 10: 0.03}, "ezmsg": {1: 0.1, 10: 0.05}}


async def run_case(case: Case, contenders: dict[str, Contender], rounds: int, scale: float) -> list[Row]:
    """Measure every contender on one case, in turns; the rows compare ours with each of the others."""
    fast: dict[str, list[Figures]] = {name: [] for name in contenders}
    paced: dict[str, list[Figures]] = {name: [] for name in contenders}
    order = list(contenders)
    dice = random.Random(case.name)
    for _ in range(rounds):
        dice.shuffle(order)
        for name in order:
            count = max(20, int(case.messages * scale * SHARE.get(name, {}).get(case.consumers, 1.0)))
            fast[name].append(await contenders[name](case.make, count, case.consumers, None))
        for name in order:
            count = max(6, int(case.paced_messages * scale))
            paced[name].append(await contenders[name](case.make, count, case.consumers, case.pace_hz))
    rows: list[Row] = []
    for peer in (name for name in contenders if name != "ours"):
        figures: list[tuple[str, str, dict[str, list[Figures]], Callable[[Figures], float]]] = [
            ("CPU per message", "µs", fast, lambda f: f.cpu_us),
            ("throughput", "1/s", fast, lambda f: f.rate_hz),
            ("latency p50", "µs", paced, lambda f: percentile(f.latencies_us, 50)),
            ("latency p99", "µs", paced, lambda f: percentile(f.latencies_us, 99)),
        ]
        for metric, unit, runs, of in figures:
            rows.append(
                row("channels", case.name, metric, unit, [*map(of, runs["ours"])], [*map(of, runs[peer])], peer)
            )
    return rows


def percentile(values: Sequence[float], percent: int) -> float:
    """The ``percent``-th percentile of at least two values."""
    return quantiles(values, n=100, method="inclusive")[percent - 1]


async def run(quick: bool = False) -> list[Row]:
    """All cases; under a minute, or under ten seconds if ``quick``."""
    rounds, scale = (2, 0.1) if quick else (5, 0.5)
    async with ezmsg_server() as address:
        contenders: dict[str, Contender] = {
            "ours": ours,
            "asyncio.Queue": queues,
            "anyio": anyio_streams,
            "ezmsg": ezmsg_at(address),
        }
        for contender in contenders.values():
            await contender(small, 20, 1, None)  # imports, first allocations
        rows: list[Row] = []
        for case in CASES:
            rows += await run_case(case, contenders, rounds, scale)
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, lambda quick: asyncio.run(run(quick))))
