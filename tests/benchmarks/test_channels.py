from __future__ import annotations

import pytest

pytest.importorskip("ezmsg", reason="the peers of the benchmarks are not installed: pip install -e '.[bench]'")

from benchmarks.channels import Contender, anyio_streams, ours, percentile, queues, small


@pytest.mark.parametrize("contender", [ours, queues, anyio_streams])
@pytest.mark.parametrize("consumers", [1, 3])
async def test_every_consumer_gets_every_message(contender: Contender, consumers: int) -> None:
    figures = await contender(small, 40, consumers, 10_000.0)
    assert len(figures.latencies_us) == 40 * consumers
    assert all(latency > 0 for latency in figures.latencies_us)
    figures = await contender(small, 100, consumers, None)
    assert figures.rate_hz > 0
    assert figures.cpu_us > 0


def test_percentiles() -> None:
    assert percentile(range(101), 50) == 50
    assert percentile(range(101), 99) == 99
