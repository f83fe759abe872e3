"""Relative message rates."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.lanes import LaneSampler, RatioWindow
from app.attention.strategies import CLOSED, Strategy
from app.runtime.filter import RateFilter


@given(st.integers(1, 15))
def test_the_rate_is_what_the_filter_lets_through(divisor: int) -> None:
    """20 samples a second of a filter that is offered 100 messages a second."""
    rate_filter, window = RateFilter(divisor), RatioWindow()
    passed = 0
    for beat in range(60):
        window.add(beat * 0.05, 5 * beat, passed)
        passed += sum(rate_filter.offer() for _ in range(5))
    ratio = window.ratio()
    assert ratio == pytest.approx(1 / divisor, abs=0.011)


def test_nothing_offered_has_no_rate() -> None:
    window = RatioWindow()
    assert window.ratio() is None
    for beat in range(30):
        window.add(beat * 0.05, 7, 3)
    assert window.ratio() is None


def test_what_was_before_the_last_second_does_not_count() -> None:
    window = RatioWindow()
    for beat in range(21):
        window.add(beat * 0.05, 10 * beat, 0)
    for beat in range(21, 42):
        window.add(beat * 0.05, 10 * beat, 10 * (beat - 20))
    assert window.ratio() == pytest.approx(1.0)


def test_in_paused_time_nothing_piles_up_and_the_rate_stays() -> None:
    window = RatioWindow()
    for beat in range(30):
        window.add(beat * 0.05, 10 * beat, 5 * beat)
    rate = window.ratio()
    for _ in range(1000):
        window.add(29 * 0.05, 290, 145)
    assert window.ratio() == rate
    assert len(window._samples) < 30


def test_what_a_strategy_closes_on_purpose_holds_its_class_not_up() -> None:
    planned = {"Plan.scans": 1.0, "Plan.twist": 1.0}
    straight = {"Toward.scans": 4.0, "Toward.twist": 1.0, "Plan.twist": CLOSED}
    strategies = [Strategy("plan", "GoTo", 8.0, filters=planned), Strategy("toward", "GoTo", 2.0, filters=straight)]
    graph: Any = SimpleNamespace(filters=SimpleNamespace(names=lambda: {*planned, *straight}))
    lanes = LaneSampler(graph, ["GoTo"], strategies)

    def shown(selected: list[str], divisors: dict[str, float], ratios: dict[str, float]) -> tuple[Any, Any]:
        all_closed = dict.fromkeys([*planned, *straight], CLOSED)
        nothing: dict[str, float | None] = dict.fromkeys(all_closed)
        (row,) = lanes.rows({}, selected, {}, all_closed | divisors, nothing | ratios)
        return row.divisor, row.rate

    assert shown(["plan"], planned | {"Plan.twist": CLOSED}, {"Plan.scans": 1.0}) == (CLOSED, 0.0), "nothing comes out"
    assert shown(["toward"], straight, {"Toward.scans": 0.25, "Plan.twist": 0.0}) == (4, 0.25)
    assert shown(["plan"], planned, {"Plan.scans": 1.0, "Plan.twist": 1.0}) == (1, 1.0)
    assert shown(["plan"], planned | {"Plan.scans": CLOSED}, {"Plan.twist": 1.0}) == (CLOSED, 0.0), "not on purpose"
    assert shown([], {}, {}) == (CLOSED, 0.0)


def test_a_strategy_shows_the_divisor_of_its_main_input_and_names_the_others() -> None:
    filters = {"Camera.images": 1.0, "Panorama.images": 2.0, "Log.images": CLOSED}
    strategies = [Strategy("seen", "Telepresence", 8.0, filters=filters)]
    graph: Any = SimpleNamespace(filters=SimpleNamespace(names=lambda: set(filters)))
    lanes = LaneSampler(graph, ["Telepresence"], strategies)
    (row,) = lanes.rows({}, ["seen"], {}, filters, {"Camera.images": 1.0, "Panorama.images": 0.5, "Log.images": 0.0})
    assert (row.divisor, row.rate) == (1, 1.0)
    assert row.divisors == {"Camera.images": 1, "Panorama.images": 2}
    (row,) = lanes.rows({}, [], {}, dict.fromkeys(filters, CLOSED), dict.fromkeys(filters))
    assert (row.divisor, row.divisors) == (CLOSED, {})
