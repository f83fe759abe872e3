"""Emotions: the published figures, and what must hold whatever is desired and exploited."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.attention.desires import Desire, Source
from app.attention.emotions import (
    EMOTIONS,
    PUBLISHED,
    Effects,
    EmotionDynamics,
    Fates,
    advanced,
    fates,
    sources,
)
from app.messages import Desires

NEGLECTED = Fates(neglected=frozenset({"GoTo"}))
EXPLOITED = Fates(exploited=frozenset({"GoTo"}))
NOTHING = Fates()
CLASSES = ("a", "b", "c")

rates = st.dictionaries(st.sampled_from(EMOTIONS), st.floats(-0.1, 0.1))
tables = st.dictionaries(st.sampled_from(CLASSES), st.builds(Effects, rates, rates), min_size=1)


@st.composite
def fortunes(draw: st.DrawFn) -> Fates:
    exploited = draw(st.frozensets(st.sampled_from(CLASSES)))
    return Fates(exploited, draw(st.frozensets(st.sampled_from(CLASSES))) - exploited)


def after(how: Fates, seconds: float, felt: EmotionDynamics | None = None) -> EmotionDynamics:
    felt = felt or EmotionDynamics()
    felt.advance(seconds, how)
    return felt


def levels(felt: EmotionDynamics) -> list[float]:
    return [felt.intensity(emotion) for emotion in EMOTIONS]


def test_a_goal_not_pursued_for_20_s_angers_as_in_the_original() -> None:
    assert after(NEGLECTED, 20).intensity("anger") == pytest.approx(20 * 0.05 - 10 * 0.002)
    assert after(NEGLECTED, 60).intensity("anger") == 1
    assert after(NEGLECTED, 60).intensity("joy") == 0


def test_pursued_again_it_calms_five_times_more_slowly_and_makes_joy() -> None:
    felt = after(EXPLOITED, 20, after(NEGLECTED, 60))
    assert felt.intensity("anger") == pytest.approx(1 - 20 * (0.01 + 0.001))
    assert felt.intensity("joy") == pytest.approx(20 * (0.01 - 0.001))


def test_the_original_s_steps_give_the_same_where_no_bound_is_met() -> None:
    """Its loop, as it is described: each second the classes' figures, every two seconds the decay."""
    anger, fate = 0.25, ({"GoTo": True, "Wander": False}, {"GoTo": False, "Wander": True})
    felt = EmotionDynamics(decay_per_s=0.001)
    felt.advance(0.25 / 0.049, NEGLECTED)
    for second in range(1, 21):
        now = fate[second % 4 == 0]
        for cls, exploited in now.items():
            effects = PUBLISHED[cls]
            anger = min(1.0, max(0.0, anger + (effects.exploited if exploited else effects.neglected)["anger"]))
        anger = max(0.0, anger - 0.002) if second % 2 == 0 else anger
        exploited_now = frozenset(cls for cls, exploited in now.items() if exploited)
        felt.advance(1.0, Fates(exploited_now, frozenset(now) - exploited_now))
        if second % 2 == 0:
            assert felt.intensity("anger") == pytest.approx(anger)
    assert 0.25 < anger < 1


def test_what_feeds_an_emotion_is_known() -> None:
    felt = EmotionDynamics({**PUBLISHED, "Dock": Effects({}, {"anger": 0.03, "fear": 0.02})}, decay_per_s=0)
    felt.advance(10, Fates(neglected=frozenset({"GoTo", "Dock"})))
    assert dict(felt.shares["anger"]) == {"GoTo": pytest.approx(0.5), "Dock": pytest.approx(0.3)}
    assert felt.shares["fear"] == {"Dock": pytest.approx(0.2)}
    assert sources(felt.shares["anger"], 1) == (("GoTo", pytest.approx(0.5)),)
    # What is lost is lost of all alike.
    felt.advance(20, EXPLOITED)
    assert dict(felt.shares["anger"]) == {"GoTo": pytest.approx(0.375), "Dock": pytest.approx(0.225)}


def test_at_its_bound_the_newer_neglect_takes_the_place_of_the_older() -> None:
    shares = advanced({"a": 1.0}, {"b": 0.05}, 0.0, 20.0)
    assert shares == {"a": pytest.approx(math.exp(-1)), "b": pytest.approx(1 - math.exp(-1))}


@settings(max_examples=150)
@given(tables, st.floats(0, 0.05), st.lists(st.tuples(fortunes(), st.floats(0, 300)), max_size=5))
def test_intensities_are_bounded_and_are_the_sum_of_their_sources(
    table: Mapping[str, Effects], decay: float, lapses: list[tuple[Fates, float]]
) -> None:
    felt = EmotionDynamics(table, decay)
    for how, seconds in lapses:
        felt.advance(seconds, how)
        for emotion in EMOTIONS:
            shares = felt.shares[emotion].values()
            assert all(0 < share <= 1 + 1e-9 for share in shares)
            assert 0 <= felt.intensity(emotion) == min(1.0, math.fsum(shares)) <= 1
            assert math.fsum(shares) <= 1 + 1e-9


@settings(max_examples=150)
@given(tables, fortunes(), fortunes(), st.floats(0, 200), st.lists(st.floats(0.01, 1), min_size=1, max_size=12))
def test_it_does_not_matter_how_time_is_divided(
    table: Mapping[str, Effects], first: Fates, then: Fates, seconds: float, parts: list[float]
) -> None:
    whole, divided = (after(first, 25, EmotionDynamics(table)) for _ in range(2))
    whole.advance(seconds, then)
    for part in parts:
        divided.advance(seconds * part / math.fsum(parts), then)
    for emotion in EMOTIONS:
        for cls in CLASSES:
            expected = whole.shares[emotion].get(cls, 0.0)
            assert divided.shares[emotion].get(cls, 0.0) == pytest.approx(expected, abs=1e-7)


@settings(max_examples=60)
@given(tables, fortunes(), fortunes())
def test_it_settles_and_all_calms_when_nothing_is_desired(
    table: Mapping[str, Effects], before: Fates, how: Fates
) -> None:
    felt = after(before, 100, EmotionDynamics(table))
    # Each intensity is a straight line to a bound, or stays where it is.
    felt.advance(1e7, how)
    settled = levels(felt)
    felt.advance(100, how)
    assert levels(felt) == pytest.approx(settled, abs=1e-6)
    felt.advance(1001, NOTHING)
    assert levels(felt) == [0, 0, 0, 0]
    assert all(not shares for shares in felt.shares.values())


def test_a_decay_out_of_its_range_is_refused() -> None:
    with pytest.raises(ValueError, match="from 0 to 1"):
        EmotionDynamics(decay_per_s=1.5)


def test_inhibited_classes_and_weaker_desires_of_a_class_are_not_neglected() -> None:
    me = Source("operator", "x")

    def desire(id_: str, cls: str, intensity: float, utility: float = 1) -> Desire:
        return Desire(id_, cls, intensity, utility, False, {}, me, 0.0)

    message = Desires(
        0.0,
        (desire("1", "GoTo", 4), desire("2", "GoTo", 8), desire("3", "Say", 2), desire("4", "Look", 4, 0)),
        exploited=("2",),
    )
    assert fates(message) == Fates(frozenset({"GoTo"}), frozenset({"Say"}))
