"""What a program costs that does nothing: the watch over idle modules, and attention's rewriting of all filters.

*Idle* is the processor time of a program of so many modules of four inputs each, none of which gets a message, as a
share of one core. *Filters rewritten* is one step of the loop in which as many filters as there are modules get a
random φ of 1, 2, 4, 8 and ∞.
"""

from __future__ import annotations

import asyncio
import logging
import math
import random
import sys
import time
import types

from app.messages import Twist
from app.runtime.channel import Channel
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import RealClock
from app.runtime.filter_bank import FilterBank
from app.runtime.graph import Graph, ModuleSpec
from app.runtime.module import Module, ModuleContext
from app.runtime.supervisor import Supervisor
from benchmarks.report import Row, benchmark_main, row

BENCHMARK = "supervision"


class Relay(Module):
    """Passes on what comes in at any of four inputs."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.out = self.output("out", Twist)
        for number in range(4):
            self.on(self.input(f"in{number}", Twist), self.pass_on)

    async def pass_on(self, message: Twist) -> None:
        self.out.publish(message)


def idle_graph(count: int) -> Graph:
    """``count`` modules, each with one input on a source that is silent."""
    here = types.ModuleType("hbba_benchmark_relay")
    here.Relay = Relay  # type: ignore[attr-defined]
    sys.modules[here.__name__] = here
    channels = {"source": ChannelSpec(type="Twist", rate_hz=10, external=True)}
    channels |= {f"c{i}": ChannelSpec(type="Twist", rate_hz=10) for i in range(count)}
    modules = {
        f"m{i}": ModuleSpec(**{"class": f"{here.__name__}:Relay"}, inputs={"in0": "source"}, outputs={"out": f"c{i}"})
        for i in range(count)
    }
    return Graph(clock=RealClock(), channels=channels, modules=modules, services={})


async def idle(count: int, rounds: int, seconds: float) -> list[float]:
    """Percent of a core, by round."""
    graph = idle_graph(count)
    shares = []
    async with Supervisor(graph.modules, graph.clock) as supervisor:
        await supervisor.started()
        for _ in range(rounds):
            began, cpu = time.monotonic(), time.process_time()
            await asyncio.sleep(seconds)
            shares.append(100 * (time.process_time() - cpu) / (time.monotonic() - began))
    return shares


def rewritten(count: int, rounds: int) -> list[float]:
    """Milliseconds of CPU a rewrite."""
    clock, bank, chance = RealClock(), FilterBank(), random.Random(1)
    for number in range(count):
        channel = Channel(f"c{number}", Twist, clock.now)
        bank.add(f"m{number}.x", channel.subscribe(f"m{number}.x", capacity=4).filter)
    took = []
    for _ in range(rounds):
        divisors = {name: chance.choice([1.0, 2.0, 4.0, 8.0, math.inf]) for name in bank.names()}
        began = time.thread_time()
        bank.apply(divisors)
        took.append((time.thread_time() - began) * 1e3)
    return took


def measure(quick: bool) -> list[Row]:
    """All rows."""
    # Two thousand modules that end at once take their time, and the log would name each.
    logging.getLogger("hbba").addHandler(logging.NullHandler())
    rows = []
    for count in (100, 500, 2000):
        shares = asyncio.run(idle(count, 3 if quick else 8, 1.0))
        rows.append(row(BENCHMARK, f"{count} modules", "CPU while idle", "% of a core", shares))
        took = rewritten(count, 20 if quick else 100)
        rows.append(row(BENCHMARK, f"{count} modules", "filters rewritten, CPU", "ms", took))
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
