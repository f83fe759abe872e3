"""What shows of what is felt: with hysteresis, in steps, bounded, and settled."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from app.attention.emotions import EMOTIONS
from app.attention.showing import STEP, Showing, ShowingLimits
from app.messages import Emotion, ShownEmotion

LIMITS = ShowingLimits(begins=0.5, ends=0.3, most=0.75)
intensities = st.floats(0, 1)
feelings = st.fixed_dictionaries(dict.fromkeys(EMOTIONS, intensities))


def shown(*anger: float, most: float = 1.0) -> list[float]:
    """How strongly anger shows, as it takes these intensities one after the other; 0: not."""
    showing = Showing(ShowingLimits(0.5, 0.3, most))
    states = [showing.update({"anger": each}) for each in anger]
    assert all(state is None or state.emotion == "anger" for state in states)
    return [0.0 if state is None else state.strength for state in states]


def test_an_emotion_shows_from_its_beginning_until_it_is_well_below() -> None:
    assert shown(0.0, 0.45, 0.5, 0.45, 0.31, 0.29, 0.45, 0.5) == [0.0, 0.0, 0.5, 0.5, 0.25, 0.0, 0.0, 0.5]


def test_it_shows_in_steps_that_do_not_flicker_and_at_most_so_strongly() -> None:
    assert shown(0.74, 0.76, 0.74, 0.7, 0.76, 0.6) == [0.5, 0.75, 0.75, 0.75, 0.75, 0.5]
    assert shown(0.5, 0.8, 1.0, most=0.75) == [0.5, 0.75, 0.75]
    assert shown(0.5, 0.8, 1.0, most=0.3) == [0.3, 0.3, 0.3]


def test_another_emotion_shows_once_it_is_clearly_stronger() -> None:
    showing = Showing(LIMITS)

    def emotion(**felt: float) -> Emotion | None:
        state = showing.update({each: felt.get(each, 0.0) for each in EMOTIONS})
        return None if state is None else state.emotion

    assert emotion(joy=0.6, sadness=0.55) == "joy"
    assert emotion(joy=0.6, sadness=0.65) == "joy"
    assert emotion(joy=0.6, sadness=0.75) == "sadness"
    assert emotion(joy=0.7, sadness=0.65) == "sadness"
    assert emotion(joy=0.45, sadness=0.31) == "sadness", "what begins is to be strong enough"
    assert emotion(joy=0.45, sadness=0.2) is None
    assert emotion() is None


@given(st.lists(feelings, min_size=1, max_size=12))
def test_what_shows_is_bounded_settles_at_once_and_goes_with_what_is_felt(course: list[dict[Emotion, float]]) -> None:
    showing = Showing(LIMITS)
    for felt in course:
        state = showing.update(felt)
        if state is not None:
            assert STEP <= state.strength <= LIMITS.most
            assert felt[state.emotion] >= LIMITS.ends
        elif max(felt.values()) >= LIMITS.begins:
            raise AssertionError("the strongest shows")
        assert [showing.update(felt) for _ in range(3)] == [state] * 3
    assert showing.update(dict.fromkeys(EMOTIONS, 0.0)) is None
    assert Showing(LIMITS).update(felt) == _fresh(felt), "nothing of what was felt before is left"


def _fresh(felt: dict[Emotion, float]) -> ShownEmotion | None:
    other = Showing(LIMITS)
    other.update({"joy": 1.0})
    other.update({})
    return other.update(felt)


@given(st.lists(intensities, min_size=2, max_size=30))
def test_it_changes_no_more_often_than_what_is_felt_moves(course: list[float]) -> None:
    """Each change of strength, and each beginning after an end, takes a way of what is felt."""
    strengths = shown(*course, most=1.0)
    changes = sum(before != after for before, after in pairwise(strengths))
    way = sum(abs(after - before) for before, after in pairwise(course))
    assert changes <= 1 + way / (STEP / 8)
