from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from app.messages import Twist
from app.runtime.clock import in_virtual_time
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.filter import CLOSED
from app.runtime.graph import Graph
from app.runtime.module import Module, ModuleContext

Build = Callable[..., Graph]
Make = Callable[..., Twist]


class Recorder(Module):
    """Notes in ``events`` (a service) everything that happens to it."""

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.events: list[Any] = self.service(list)
        self.numbers = self.input("numbers", Twist, capacity=10)
        self.words = self.output("words", Twist)
        self.on(self.numbers, self.take)
        self.every(1.0, self.beat)

    async def start(self) -> None:
        self.events.append("start")

    async def stop(self) -> None:
        self.events.append("stop")

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self.events.append(dict(parameters))
        if parameters.get("wrong"):
            raise ValueError("a parameter that cannot be")

    def last_word(self, port: str) -> Twist:
        self.events.append(f"last word on {port}")
        return Twist(0.0, 0.0, 0.0)

    async def take(self, message: Twist) -> None:
        self.events.append(message.linear_mps)

    async def beat(self) -> None:
        self.events.append(f"beat at {self.clock.now() - 1_000_000:g}")


class FailsToStart(Recorder):
    async def start(self) -> None:
        await super().start()
        raise ModuleFailed("no camera")


class SlowBeat(Recorder):
    async def beat(self) -> None:
        await super().beat()
        await self.clock.sleep(2.5)


def graph_of(build: Build, module_class: type[Module]) -> tuple[Graph, Any, list[Any]]:
    events: list[Any] = []
    graph = build(
        {"R": (module_class, {"numbers": "n"}, {"words": "w"})},
        {"n": {"external": True}, "w": {}},
        services={list: events},
    )
    return graph, graph.modules["R"], events


async def run_for(module: Module, seconds: float, during: Callable[[], None] = lambda: None) -> None:
    task = asyncio.create_task(module.run())
    await asyncio.sleep(seconds / 2)
    during()
    await asyncio.sleep(seconds / 2)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task


@in_virtual_time
async def test_a_module_starts_takes_messages_beats_and_stops(build: Build, make: Make) -> None:
    graph, slot, events = graph_of(build, Recorder)
    await run_for(slot.module, 2.5, lambda: graph.channels["n"].publish(make(7)))
    assert events == ["start", {}, "beat at 0", "beat at 1", 7.0, "beat at 2", "stop"]
    assert not slot.module.running


@in_virtual_time
async def test_a_start_that_fails_half_way_is_still_stopped(build: Build) -> None:
    _, slot, events = graph_of(build, FailsToStart)
    with pytest.raises(ModuleFailed, match="no camera"):
        await slot.module.run()
    assert events == ["start", "stop"]


@in_virtual_time
async def test_beats_missed_while_one_ran_are_skipped(build: Build) -> None:
    _, slot, events = graph_of(build, SlowBeat)
    await run_for(slot.module, 6)
    assert [e for e in events if "beat" in e] == ["beat at 0", "beat at 2.5", "beat at 5"]


class OnceLate(Recorder):
    """Its first beat takes longer than a period."""

    async def beat(self) -> None:
        await super().beat()
        if self.events[-1] == "beat at 0":
            await self.clock.sleep(1.25)


@in_virtual_time
async def test_a_late_beat_does_not_shift_the_next(build: Build) -> None:
    _, slot, events = graph_of(build, OnceLate)
    await run_for(slot.module, 4.5)
    beats = [e for e in events if isinstance(e, str) and "beat" in e]
    assert beats == ["beat at 0", "beat at 1.25", "beat at 2", "beat at 3", "beat at 4"]


@in_virtual_time
async def test_messages_are_handled_in_order_and_one_at_a_time(build: Build, make: Make) -> None:
    graph, slot, events = graph_of(build, Recorder)

    def publish() -> None:
        for value in range(5):
            graph.channels["n"].publish(make(value))

    await run_for(slot.module, 1, publish)
    assert [e for e in events if isinstance(e, float)] == [0, 1, 2, 3, 4]


class Strict(Recorder):
    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.on(self.input("events", Twist, capacity=2, lossless=True), self.take)


class Forgiving(Strict):
    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        self.events.append(f"{port}: {loss}")


def burst(build: Build, make: Make, module_class: type[Module]) -> tuple[Any, list[Any], Callable[[], None]]:
    """A module with a lossless inbox of 2, and what publishes 5 messages in one go."""
    noted: list[Any] = []
    graph = build({"R": (module_class, {"events": "n"}, {})}, {"n": {"external": True}}, services={list: noted})

    def publish() -> None:
        for value in range(5):
            graph.channels["n"].publish(make(value))

    return graph.modules["R"], noted, publish


@in_virtual_time
async def test_a_lossless_input_that_lost_messages_is_a_failure(build: Build, make: Make) -> None:
    slot, _, publish = burst(build, make, Strict)
    task = asyncio.create_task(slot.module.run())
    await asyncio.sleep(0.5)
    publish()
    await asyncio.wait({task})
    assert isinstance(task.exception(), ExceptionGroup)
    assert task.exception().subgroup(InboxOverflow) is not None


@in_virtual_time
async def test_a_module_may_go_on_after_a_loss_of_its_inbox(build: Build, make: Make) -> None:
    slot, noted, publish = burst(build, make, Forgiving)
    await run_for(slot.module, 1, publish)
    assert [event for event in noted if isinstance(event, float)] == [0, 1]
    assert [event for event in noted if "lost" in str(event)] == [
        "events: R.events: 3 messages lost, the inbox holds 2"
    ]


@in_virtual_time
async def test_parameters_are_handed_over_while_it_runs_and_only_when_they_change(build: Build) -> None:
    _, slot, events = graph_of(build, Recorder)
    slot.configure({"speed": 1})
    assert events == [], "not started: nothing to configure yet"

    def change() -> None:
        slot.configure({"speed": 1})
        slot.configure({"speed": 2})

    await run_for(slot.module, 0.5, change)
    assert [e for e in events if isinstance(e, dict)] == [{"speed": 1}, {"speed": 2}]


@in_virtual_time
async def test_a_module_that_cannot_take_its_parameters_fails_for_itself(build: Build) -> None:
    _, slot, events = graph_of(build, Recorder)
    task = asyncio.create_task(slot.module.run())
    await asyncio.sleep(0.5)
    slot.configure({"wrong": True})
    with pytest.raises(ExceptionGroup) as caught:
        await task
    assert caught.group_contains(ValueError, match="a parameter that cannot be")
    assert events[-1] == "stop"


@in_virtual_time
async def test_an_input_that_is_not_wired_is_simply_not_served(build: Build) -> None:
    events: list[Any] = []
    graph = build({"R": (Recorder, {}, {})}, {}, services={list: events})
    module: Any = graph.modules["R"].module
    await run_for(module, 0.5)
    assert events[-1] == "stop"
    with pytest.raises(ModuleFailed, match=r"R\.numbers is not connected"):
        _ = module.numbers.subscription


@in_virtual_time
async def test_compute_runs_in_the_modules_thread_and_raises_its_error(build: Build) -> None:
    _, slot, _ = graph_of(build, Recorder)
    module = slot.module
    first, second = await module.compute(threading.current_thread), await module.compute(threading.current_thread)
    assert first is second is not threading.main_thread()
    assert first.name == "module R"
    assert first.daemon
    with pytest.raises(ZeroDivisionError):
        await module.compute(divmod, 1, 0)
    slot.context.worker.shutdown()


# --- outputs ---


def test_an_output_filter_decimates_what_its_module_publishes(build: Build, make: Make) -> None:
    graph, slot, _ = graph_of(build, Recorder)
    inbox = graph.channels["w"].subscribe("test", capacity=10)
    slot.module.words.filter.divisor = 2
    for value in range(5):
        slot.module.words.publish(make(value))
    assert [inbox.receive_nowait().linear_mps for _ in range(3)] == [0, 2, 4]
    assert graph.channels["w"].statistics().published == 3
    assert slot.module.words.offered == 5


def test_the_last_word_is_published_exactly_once_when_the_output_closes(build: Build, make: Make) -> None:
    graph, slot, events = graph_of(build, Recorder)
    inbox = graph.channels["w"].subscribe("test", capacity=10)
    slot.module.words.publish(make(9))
    graph.filters.apply({"R.words": CLOSED})
    graph.filters.apply({"R.words": CLOSED})
    slot.module.words.publish(make(9))
    assert [inbox.receive_nowait().linear_mps for _ in range(2)] == [9, 0]
    assert inbox.statistics().depth == 0
    graph.filters.apply({"R.words": 3})
    assert events == ["last word on words"]
    graph.filters.apply({"R.words": CLOSED})
    assert events == ["last word on words"] * 2


def test_no_last_word_before_anything_was_said(build: Build) -> None:
    events: list[Any] = []
    graph = build({"R": (Recorder, {}, {"words": "w"})}, {"w": {}}, services={list: events}, attended=("R.words",))
    assert graph.filters.divisors()["R.words"] == CLOSED
    assert graph.channels["w"].statistics().published == 0
    assert events == []


def test_a_channel_that_is_closed_hears_no_last_word_and_holds_up_no_other_filter(build: Build) -> None:
    events: list[Any] = []
    outputs: dict[str, tuple[type[Module], dict[str, str], dict[str, str]]]
    outputs = {name: (Recorder, {}, {"words": name.lower()}) for name in ("A", "B", "C")}
    graph = build(outputs, {"a": {}, "b": {}, "c": {}}, services={list: events})
    graph.channels["b"].close()
    graph.filters.apply(dict.fromkeys(("A.words", "B.words", "C.words"), CLOSED))
    assert set(graph.filters.divisors().values()) == {CLOSED}
    assert [graph.channels[name].statistics().published for name in "abc"] == [1, 0, 1]
    assert events == ["last word on words"] * 2


class BrokenLastWord(Recorder):
    def last_word(self, port: str) -> Twist:
        raise ValueError("no word comes")


@in_virtual_time
async def test_a_last_word_that_fails_is_its_modules_failure_and_stops_no_intention(build: Build) -> None:
    events: list[Any] = []
    graph = build(
        {"A": (BrokenLastWord, {}, {"words": "a"}), "B": (Recorder, {}, {"words": "b"})},
        {"a": {}, "b": {}},
        services={list: events},
    )
    task = asyncio.create_task(graph.modules["A"].module.run())
    await asyncio.sleep(0.1)
    graph.filters.apply({"A.words": CLOSED, "B.words": CLOSED})
    assert set(graph.filters.divisors().values()) == {CLOSED}
    assert graph.channels["b"].statistics().published == 1
    with pytest.raises(ExceptionGroup) as caught:
        await task
    assert caught.group_contains(ValueError, match="no word comes")


def test_an_output_reports_how_often_it_is_wanted(build: Build) -> None:
    graph, slot, _ = graph_of(build, Recorder)
    words = slot.module.words
    reported: list[float] = []
    end = words.on_divisor(reported.append)
    inbox = graph.channels["w"].subscribe("test")
    assert words.wanted
    words.filter.divisor = CLOSED
    assert not words.wanted
    inbox.filter.divisor = CLOSED
    words.filter.divisor = 2
    inbox.filter.divisor = 6
    other = graph.channels["w"].subscribe("other", divisor=4)
    assert reported == [CLOSED, 1, CLOSED, 12, 4]
    other.close()
    end()
    words.filter.divisor = CLOSED
    assert reported == [CLOSED, 1, CLOSED, 12, 4, 12]


def test_a_new_instance_takes_over_its_outputs_and_the_old_one_falls_silent(build: Build, make: Make) -> None:
    graph, slot, events = graph_of(build, Recorder)
    inbox = graph.channels["w"].subscribe("test", capacity=10)
    old = slot.module
    reported: list[float] = []
    old.words.on_divisor(reported.append)
    old.words.filter.divisor = 2
    old.words.publish(make(1))
    new = slot.renew()
    old.words.publish(make(2))
    assert not old.words.wanted
    for value in (3, 4):
        new.words.publish(make(value))
    # φ and its phase outlive the instance: 1 passed, so 3 is decimated and 4 passes.
    assert [inbox.receive_nowait().linear_mps for _ in range(2)] == [1, 4]
    assert inbox.statistics().depth == 0
    graph.filters.apply({"R.words": CLOSED})
    assert events == ["last word on words"], "asked of the new instance alone"
    assert reported == [1, 2]
    assert slot.context.outputs["words"] is new.words


def test_an_unwired_output_swallows_what_it_is_given(build: Build, make: Make) -> None:
    graph = build({"R": (Recorder, {}, {})}, {}, services={list: []})
    words = graph.modules["R"].context.outputs["words"]
    words.publish(make(1))
    assert not words.wanted
    graph.filters.apply({"R.words": CLOSED})
