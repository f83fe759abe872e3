"""ezmsg in one process, for ``benchmarks.channels``: its low-level publisher and subscribers, zero-copy receive."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager

from ezmsg.core.graphcontext import GraphContext
from ezmsg.core.graphserver import GraphServer
from ezmsg.core.pubclient import Publisher
from ezmsg.core.subclient import Subscriber

TOPIC = "BENCHMARK"


@asynccontextmanager
async def ezmsg_server() -> AsyncIterator[tuple[str, int]]:
    """A graph server in a thread of this process, on a free port of this computer."""
    logging.getLogger("ezmsg").setLevel(logging.ERROR)  # it warns of the back-pressure that is wanted here
    server = GraphServer(name="ezmsg graph server")
    server.start(("127.0.0.1", 0))
    try:
        yield server.address.host, server.address.port
    finally:
        server.stop()


@asynccontextmanager
async def ezmsg_ends(
    address: tuple[str, int], consumers: int, capacity: int
) -> AsyncIterator[tuple[Publisher, list[Subscriber]]]:
    """One publisher with ``capacity`` buffers, connected with ``consumers`` subscribers."""
    async with AsyncExitStack() as stack:
        context = await stack.enter_async_context(GraphContext(address))
        publisher = await context.publisher(TOPIC, num_buffers=capacity)
        yield publisher, [await context.subscriber(TOPIC) for _ in range(consumers)]
