"""Modules that stand for others."""

from __future__ import annotations

from typing import Any

import pytest

from app.runtime.filter import CLOSED
from app.runtime.freshness import commanded_divisors
from app.runtime.graph import Graph, WiringError
from tests.runtime.wired import Build, Relay, Source, Wheels, refused


def with_stand_in(build: Build, **spec: Any) -> Graph:
    """``Relay`` and ``Relay@desk``, which stands for it; attention has the filters of both."""
    wiring = ({"numbers": "n"}, {"relayed": "r"})
    graph: Graph = build(
        {"Source": (Source, {}, {"numbers": "n"}), "Relay": (Relay, *wiring), "Relay@desk": (Relay, *wiring, spec)},
        {"n": {}, "r": {}},
        attended=("Relay.numbers", "Relay@desk.numbers"),
    )
    return graph


def test_a_module_that_stands_for_another_publishes_on_its_channels_and_shares_what_it_keeps(build: Build) -> None:
    graph = with_stand_in(build, stands_for="Relay")
    assert graph.producers["r"] == "Relay.relayed"
    assert graph.alternatives == {"r": ("Relay@desk.relayed",)}
    graph.modules["Relay@desk"].module.persistent["next"] = 3
    assert graph.modules["Relay"].module.persistent == {"next": 3}


@pytest.mark.parametrize("spec", [{}, {"stands_for": "Source"}])
def test_no_other_second_producer_is_allowed(build: Build, spec: dict[str, Any]) -> None:
    with pytest.raises(WiringError, match=r"channel r already has a producer, Relay\.relayed"):
        with_stand_in(build, **spec)


def test_a_module_stands_for_one_that_there_is(build: Build) -> None:
    with pytest.raises(WiringError, match="stands_for: no module 'Rely'; did you mean"):
        with_stand_in(build, stands_for="Rely")


def test_the_producer_at_work_is_the_one_that_is_fed(build: Build) -> None:
    graph = with_stand_in(build, stands_for="Relay")
    assert graph.producer_at_work("r") == "Relay.relayed"
    graph.filters.apply({"Relay@desk.numbers": 2})
    assert graph.producer_at_work("r") == "Relay@desk.relayed"
    subscription = graph.channels["r"].subscribe("test")
    assert commanded_divisors(graph)["r"] == 2
    graph.filters.apply({"Relay@desk.numbers": CLOSED, "Relay.numbers": 4})
    assert graph.producer_at_work("r") == "Relay.relayed"
    assert commanded_divisors(graph)["r"] == 4
    subscription.close()


def test_nothing_stands_for_a_module_that_can_move_the_robot(build: Build) -> None:
    wiring = ({"numbers": "n"}, {"relayed": "r"})
    modules = {
        "Source": (Source, {}, {"numbers": "n"}),
        "Relay": (Relay, *wiring),
        "Relay@desk": (Relay, *wiring, {"stands_for": "Relay"}),
        "Wheels": (Wheels, {"driven": "r"}, {}),
    }
    assert "Relay.relayed leads to Wheels.driven and can move the robot" in refused(build, modules, {"n": {}, "r": {}})
