"""Budgets and what pressure leaves of them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.budgets import Budgets
from app.attention.desires import GRAIN
from app.attention.strategies import MOST
from app.attention.timeline import Timeline

CHANGES = st.lists(
    st.one_of(
        st.tuples(st.just("set"), st.sampled_from(("cpu", "power")), st.floats(0, 500)),
        st.tuples(st.just("share"), st.sampled_from(("cpu", "power")), st.floats(0, 1)),
    ),
    max_size=8,
)


@given(CHANGES)
def test_no_more_is_left_than_there_is_and_every_change_is_on_the_timeline(
    changes: list[tuple[str, str, float]],
) -> None:
    timeline = Timeline(100, lambda: 0.0)
    budgets = Budgets({"cpu": 100.0, "power": 60.0}, timeline)
    for number, (what, resource, value) in enumerate(changes):
        before = budgets.whole() if what == "set" else budgets.left()
        noted = len(timeline.query())
        changed = getattr(budgets, what)(resource, value, f"reason {number}")
        after = budgets.whole() if what == "set" else budgets.left()
        assert changed == (after != before)
        assert len(timeline.query()) == noted + changed
        for name, left in budgets.left().items():
            assert 0 <= left <= budgets.whole()[name]
            assert left == round(left * GRAIN) / GRAIN


def test_what_cannot_be_is_refused_and_changes_nothing() -> None:
    timeline = Timeline(10, lambda: 0.0)
    budgets = Budgets({"cpu": 100.0}, timeline)
    for value in (-1.0, 2 * MOST, float("nan")):
        with pytest.raises(ValueError, match="the capacity of cpu must be from 0 to 1,000,000,000"):
            budgets.set("cpu", value, "")
        with pytest.raises(ValueError, match="the share of cpu must be from 0 to 1"):
            budgets.share("cpu", value, "")
    with pytest.raises(ValueError, match="no resource 'gpu'; there are: cpu"):
        budgets.set("gpu", 1.0, "")
    assert budgets.whole() == budgets.left() == {"cpu": 100.0}
    assert timeline.query() == ()
