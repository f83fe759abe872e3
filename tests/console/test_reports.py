"""How fresh each channel is, told with a clock that the test moves."""

from __future__ import annotations

from typing import Any

from app.console.reports import SourceWatch
from app.geometry import Pose2
from app.messages import Odometry
from app.runtime.channel_table import ChannelSpec
from app.runtime.graph import Graph


class Clock:
    """A clock that stands."""

    def __init__(self) -> None:
        self.time = 100.0

    def now(self) -> float:
        return self.time

    async def sleep(self, seconds: float) -> None: ...

    async def sleep_until(self, stamp: float) -> None: ...


def test_a_source_waits_lives_goes_stale_and_closes() -> None:
    clock = Clock()
    spec = ChannelSpec.model_validate({"type": "Odometry", "rate_hz": 20, "external": True})
    graph = Graph(clock=clock, channels={"odometry": spec}, modules={}, services={})
    channel, watch = graph.channel("odometry"), SourceWatch(graph)

    def source() -> dict[str, Any]:
        return watch.sample(clock.time)[0]

    assert source()["state"] == "closed"
    subscription = channel.subscribe("test")
    assert source()["state"] == "waiting"
    for _ in range(40):
        clock.time += 0.05
        channel.publish(Odometry(clock.time, Pose2(), 0.0, 0.0))
        told = source()
    assert told["state"] == "live"
    assert (told["age_ms"], told["rate_hz"], told["expected_hz"]) == (0.0, 20.0, 20.0)
    clock.time += 0.5
    assert source()["state"] == "stale"
    channel.unsubscribe(subscription)
    clock.time += 60.0
    assert source()["state"] == "closed"
    # Old news of a source that was just asked for is no alarm yet.
    channel.subscribe("test")
    assert source()["state"] == "waiting"
    clock.time += 2.0
    assert source()["state"] == "stale"
