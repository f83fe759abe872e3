from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.messages import Twist
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock, in_virtual_time
from app.runtime.filter import CLOSED
from app.runtime.freshness import GRACE_S, Freshness, FreshnessWatch, RateMeter, commanded_divisors, judge, sources
from app.runtime.graph import Graph
from app.runtime.module import Module, ModuleContext
from app.runtime.supervisor import ModuleState, Status, Supervisor

Build = Callable[..., Graph]


def spec(rate_hz: float | None = 10.0, **more: Any) -> ChannelSpec:
    return ChannelSpec.model_validate({"type": "Twist", "rate_hz": rate_hz, **more})


def state(status: Status, restarts: int = 0) -> ModuleState:
    return ModuleState("Source", status, 0.0, restarts)


@pytest.mark.parametrize(
    ("divisor", "age", "open_for", "expected"),
    [
        (1, 0.05, 100, "live"),
        (1, 0.30, 100, "live"),
        (1, 0.31, 100, "stale"),  # three periods of 10 Hz
        (4, 0.31, 100, "live"),  # 2.5 Hz were asked for: 1.2 s are allowed
        (4, 1.21, 100, "stale"),
        (CLOSED, 1e6, 100, "closed"),
        (CLOSED, None, 100, "closed"),
        (1, None, 0.2, "waiting"),
        (1, None, 0.4, "stale"),
        (1, 50.0, 0.2, "waiting"),  # just opened: the last message is old without a fault
        (1, 50.0, 0.4, "stale"),
        (10, 50.0, 2.9, "waiting"),
    ],
)
def test_staleness_is_judged_against_the_commanded_rate(
    divisor: float, age: float | None, open_for: float, expected: str
) -> None:
    now = 1000.0
    last = None if age is None else now - age
    freshness = judge(spec(), divisor, last, state("running"), now, now - open_for)
    assert freshness.state == expected
    assert freshness.age_s == (None if age is None else pytest.approx(age))


@pytest.mark.parametrize(
    ("producer", "expected"),
    [
        (state("running"), "live"),
        (state("failed"), "stale"),
        (state("hung"), "stale"),
        (state("stopped"), "stale"),
        (state("starting"), "live"),
        (state("starting", restarts=1), "stale"),
        (None, "live"),
    ],
)
def test_what_a_module_that_is_down_published_last_is_stale_at_once(
    producer: ModuleState | None, expected: str
) -> None:
    assert judge(spec(), 1, 1000.0, producer, 1000.1).state == expected
    assert judge(spec(), CLOSED, 1000.0, producer, 1000.1).state == "closed"


@pytest.mark.parametrize(
    ("age", "opened_ago", "expected"),
    [
        (None, GRACE_S - 0.1, "waiting"),
        (None, GRACE_S + 0.1, "stale"),
        (50.0, GRACE_S - 0.1, "waiting"),  # of an earlier opening
        (50.0, GRACE_S + 0.1, "stale"),
        (0.29, 1.0, "live"),
        (0.31, 1.0, "stale"),  # the first has come: from then on all are due
    ],
)
def test_only_the_first_message_after_opening_has_time_to_come(
    age: float | None, opened_ago: float, expected: str
) -> None:
    now = 1000.0
    opened = now - opened_ago
    last = None if age is None else now - age
    assert judge(spec(), 1, last, state("running"), now, opened, opened).state == expected
    assert judge(spec(), 1, last, state("failed"), now, opened, opened).state == "stale"


def test_a_channel_of_events_is_never_too_old() -> None:
    events = spec(None)
    assert judge(events, 1, None, None, 1e6) == Freshness("waiting", None, None, None)
    assert judge(events, 1, 0.0, None, 1e6).state == "live"
    assert judge(events, 1, 0.0, state("failed"), 1e6).state == "stale"


@given(st.floats(0.5, 200), st.integers(1, 50), st.floats(0, 100), st.floats(0.1, 10), st.floats(0, 5))
def test_it_is_stale_exactly_when_older_than_allowed(
    rate_hz: float, divisor: int, age: float, periods: float, least: float
) -> None:
    row = spec(rate_hz, stale_periods=periods, stale_min_s=least + 0.01)
    freshness = judge(row, divisor, 1000.0 - age, state("running"), 1000.0)
    assert freshness.limit_s == max(periods * divisor / rate_hz, least + 0.01)
    assert freshness.age_s is not None
    assert (freshness.state == "stale") == (freshness.age_s > freshness.limit_s)
    assert freshness.commanded_hz == rate_hz / divisor


# --- measured rate ---


@given(st.floats(0.5, 50), st.floats(0.01, 0.5))
def test_a_steady_rate_is_measured_and_the_memory_stays_small(rate_hz: float, step_s: float) -> None:
    meter = RateMeter()
    assert meter.sample(0.0, 0) is None
    rate = None
    for number in range(1, 200):
        now = number * step_s
        rate = meter.sample(now, int(now * rate_hz))
        assert len(meter._samples) <= 23
    assert rate == pytest.approx(rate_hz, abs=1 / 1.4)


def test_the_rate_falls_to_zero_once_nothing_comes() -> None:
    meter = RateMeter(window_s=1.0)
    for number in range(21):
        meter.sample(number / 10, number)
    assert [meter.sample(2.0 + n / 10, 20) for n in (0, 5, 10, 20)] == pytest.approx([10, 5, 0, 0])


# --- in a graph ---


class Sensor(Module):
    broken_from_the_start = False

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.images = self.output("images", Twist)
        self.broken = self.broken_from_the_start
        self.every(0.1, self.beat)

    async def beat(self) -> None:
        if self.broken:
            raise OSError("the cable is out")
        self.images.publish(Twist(self.clock.now(), 1.0, 0.0))


class Detector(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.images = self.input("images", Twist)
        self.odometry = self.input("odometry", Twist)
        self.found = self.output("found", Twist)
        self.on(self.images, self.look)

    async def look(self, image: Twist) -> None:
        self.found.publish(image)


class Listener(Module):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.found = self.input("found", Twist, lossless=True, capacity=100)


@pytest.fixture
def graph(build: Build) -> Graph:
    return build(
        {
            "Sensor": (Sensor, {}, {"images": "images"}),
            "Detector": (Detector, {"images": "images", "odometry": "odometry"}, {"found": "found"}),
            "Listener": (Listener, {"found": "found"}, {}, {"hang_after_s": 1e6}),
        },
        {
            "images": {"rate_hz": 10},
            "odometry": {"rate_hz": 100, "external": True, "decimable": False},
            "found": {"rate_hz": 10},
            "spare": {},
        },
    )


@in_virtual_time
async def test_the_commanded_divisor_follows_the_filters_down_the_chain(graph: Graph) -> None:
    assert commanded_divisors(graph) == {"images": 1, "odometry": 1, "found": 1, "spare": CLOSED}
    graph.filters.apply({"Detector.images": 3, "Detector.found": 2})
    assert commanded_divisors(graph) == {"images": 1, "odometry": 1, "found": 6, "spare": CLOSED}
    graph.filters.apply({"Sensor.images": 2, "Listener.found": 5})
    assert commanded_divisors(graph)["found"] == 12
    graph.filters.apply({"Detector.images": CLOSED})
    divisors = commanded_divisors(graph)
    assert (divisors["images"], divisors["found"]) == (CLOSED, CLOSED)


@in_virtual_time
async def test_what_the_source_leaves_out_slows_its_own_channel_and_nothing_after_it(graph: Graph) -> None:
    graph.filters.apply({"Detector.images": 4})
    images = graph.modules["Sensor"].context.outputs["images"]
    images.thinned = images.divisor
    assert images.divisor == 4
    divisors = commanded_divisors(graph)
    assert (divisors["images"], divisors["found"]) == (4, 4)


def test_a_feedback_cycle_is_followed_once(build: Build) -> None:
    graph = build(
        {"A": (Detector, {"images": "b"}, {"found": "a"}), "B": (Detector, {"images": "a"}, {"found": "b"})},
        {"a": {}, "b": {"feedback": True}},
    )
    graph.filters.apply({"A.images": 2})
    assert commanded_divisors(graph) == {"a": 2, "b": 2}


@in_virtual_time
async def test_switching_attention_never_raises_a_false_alarm_and_a_lost_source_is_said_once(
    graph: Graph, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    caplog.set_level(logging.INFO, "hbba.freshness")
    clock = VirtualClock()
    supervisor = Supervisor(graph.modules, clock)
    watch = FreshnessWatch(graph, supervisor.states)
    seen: list[tuple[str, str]] = []
    watch.observe(lambda name, freshness: seen.append((name, freshness.state)) if name == "images" else None)

    async def look_for(seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            await clock.sleep(0.05)
            watch.sample(clock.now())

    async with supervisor:
        await look_for(3)
        assert watch.latest["images"].rate_hz == pytest.approx(10, abs=0.6)
        graph.filters.apply({"Detector.images": 20})
        await look_for(10)
        graph.filters.apply({"Detector.images": CLOSED})
        await look_for(10)
        assert str(watch.latest["images"].state) == "closed"
        graph.filters.apply({"Detector.images": 1})
        await look_for(3)
        assert set(seen) <= {("images", "waiting"), ("images", "live"), ("images", "closed")}
        assert "stale" not in [f.state for n, f in watch.latest.items() if n in ("images", "found")]
        graph.modules["Sensor"].module.broken = True  # type: ignore[attr-defined]
        monkeypatch.setattr(Sensor, "broken_from_the_start", True)
        await look_for(0.4)
        assert str(watch.latest["images"].state) == "stale"
        await look_for(2)
        monkeypatch.setattr(Sensor, "broken_from_the_start", False)
        await look_for(5)
    said = [record.getMessage() for record in caplog.records if "channel images" in record.getMessage()]
    assert said[0].startswith("channel images is stale: its newest message is 1.")
    assert said[0].endswith("s old, 0.30 s allowed; look at Sensor.images")
    assert said[1:] == ["channel images is live again"]


@in_virtual_time
async def test_a_hiccup_is_reported_to_observers_and_not_written_to_the_log(
    graph: Graph, caplog: pytest.LogCaptureFixture
) -> None:
    clock = VirtualClock()
    watch = FreshnessWatch(graph, {"Sensor": ModuleState("Sensor", "running", clock.now())})
    seen: list[str] = []
    watch.observe(lambda name, freshness: seen.append(freshness.state) if name == "images" else None)
    for _ in range(3):
        graph.channels["images"].publish(Twist(clock.now(), 0.0, 0.0))
        watch.sample(clock.now())
        await clock.sleep(GRACE_S + 1)
        watch.sample(clock.now())
        await clock.sleep(0.5)
    assert seen == ["live", "stale"] * 3
    assert not [message for message in caplog.messages if "channel images" in message]


@in_virtual_time
async def test_a_module_that_runs_again_is_given_time_for_its_first_message(graph: Graph) -> None:
    clock = VirtualClock()
    states = {"Sensor": ModuleState("Sensor", "running", clock.now())}
    watch = FreshnessWatch(graph, states)
    graph.channels["images"].publish(Twist(clock.now(), 0.0, 0.0))
    assert watch.sample(clock.now())["images"].state == "live"
    await clock.sleep(60)
    states["Sensor"] = ModuleState("Sensor", "failed", clock.now() - 59, 1)
    assert watch.sample(clock.now())["images"].state == "stale"
    states["Sensor"] = ModuleState("Sensor", "running", clock.now(), 2)
    await clock.sleep(0.2)
    assert watch.sample(clock.now())["images"].state == "waiting"
    await clock.sleep(0.2)
    assert watch.sample(clock.now())["images"].state == "stale"


@in_virtual_time
async def test_a_channel_that_should_come_from_outside_and_does_not_is_stale(graph: Graph) -> None:
    clock = VirtualClock()
    watch = FreshnessWatch(graph, {})
    assert watch.sample(clock.now())["odometry"].state == "waiting"
    await asyncio.sleep(GRACE_S - 0.1)
    assert watch.sample(clock.now())["odometry"].state == "waiting", "what brings it may be just starting"
    await asyncio.sleep(0.2)
    assert watch.sample(clock.now())["odometry"].state == "stale"
    graph.channels["odometry"].publish(Twist(clock.now(), 0.0, 0.0))
    assert watch.sample(clock.now())["odometry"].state == "live"


@in_virtual_time
async def test_after_a_reset_the_first_messages_are_due_again(graph: Graph) -> None:
    clock = VirtualClock()
    supervisor = Supervisor(graph.modules, clock)
    watch = FreshnessWatch(graph, supervisor.states)
    async with supervisor:
        for _ in range(30):
            await asyncio.sleep(0.2)
            watch.sample(clock.now())
        now = clock.now()
        assert watch.latest["images"].rate_hz == pytest.approx(10, abs=1)
        graph.channels["images"].clear()
        assert watch.read(now)["images"].state == "stale", "nothing came for longer than is allowed"
        watch.reset()
        assert watch.latest == {}
        # Time has gone back: what holds now began now, and nothing was measured yet.
        there = watch.sample(now - 100)["images"]
        assert (there.age_s, there.rate_hz) == (None, None)
        assert watch.read(now - 99.5)["images"].rate_hz == 0.0


@in_virtual_time
async def test_a_start_and_an_opening_are_quiet_and_a_source_that_never_comes_is_said_once(
    graph: Graph, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "hbba.freshness")
    clock = VirtualClock()
    states = {name: ModuleState(name, "running", clock.now()) for name in graph.modules}
    watch = FreshnessWatch(graph, states)
    images = graph.channels["images"]

    async def look_for(seconds: float, *, feed: bool) -> None:
        for _ in range(round(seconds / 0.1)):
            await clock.sleep(0.1)
            graph.channels["odometry"].publish(Twist(clock.now(), 0.0, 0.0))
            if feed:
                images.publish(Twist(clock.now(), 0.0, 0.0))
                graph.channels["found"].publish(Twist(clock.now(), 0.0, 0.0))
            watch.sample(clock.now())

    await look_for(GRACE_S - 0.2, feed=False)
    await look_for(5, feed=True)
    graph.filters.apply({"Detector.images": CLOSED})
    await look_for(20, feed=False)
    graph.filters.apply({"Detector.images": 1})
    await look_for(GRACE_S - 0.2, feed=False)
    assert caplog.messages == []
    await look_for(10, feed=False)
    (said,) = [message for message in caplog.messages if "channel images" in message]
    assert said.endswith("look at Sensor.images")


@in_virtual_time
async def test_another_divisor_gives_a_lost_source_no_second_grace(graph: Graph) -> None:
    clock = VirtualClock()
    watch = FreshnessWatch(graph, {"Sensor": ModuleState("Sensor", "running", clock.now())})
    graph.channels["images"].publish(Twist(clock.now(), 0.0, 0.0))
    await clock.sleep(10)
    watch.sample(clock.now())
    await clock.sleep(GRACE_S + 0.1)
    assert watch.sample(clock.now())["images"].state == "stale"
    graph.filters.apply({"Sensor.images": 2})
    assert watch.sample(clock.now())["images"].state == "waiting"
    await clock.sleep(0.7)
    assert watch.sample(clock.now())["images"].state == "stale"


@in_virtual_time
async def test_a_channel_without_a_source_is_no_fault(build: Build, caplog: pytest.LogCaptureFixture) -> None:
    graph = build({"Sensor": (Sensor, {}, {"images": "images"})}, {"images": {"rate_hz": 10}, "drive": {"rate_hz": 20}})
    graph.channels["drive"].observe(lambda _: None)
    assert sources(graph) == {"images"}
    watch = FreshnessWatch(graph, {})
    for now in (0.0, 10.0, 100.0):
        assert watch.sample(now)["drive"].state != "stale"
    assert caplog.messages == []
