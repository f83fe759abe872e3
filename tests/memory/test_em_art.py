"""EM-ART: the published checks of its program, and what always holds."""

from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import given

from app.memory.em_art import EMArt, Parameters, Pattern
from app.memory.matching import complement_fit, episode_vigilance, learned, plain_fit, rate_after, rate_before

PUBLISHED = Parameters(absent_counts=True)
NEUTRAL = {"neutral": 0.7}
#: The five inputs of the published program's tests of episodes: a robot waits, meets a person, and goes elsewhere.
INPUTS: tuple[Pattern, ...] = (
    {"desire": {"wait": 1}, "place": {"lab 1033": 1}, "emotion": NEUTRAL},
    {"person": {"b": 1}, "desire": {"wait": 1}, "place": {"lab 1033": 1}, "emotion": NEUTRAL},
    {"person": {"b": 1}, "desire": {"go to": 1}, "place": {"lab 1033": 1}, "emotion": NEUTRAL},
    {"desire": {"go to": 1}, "place": {"corridor": 1}, "emotion": NEUTRAL},
    {"desire": {"wait": 1}, "place": {"other lab": 1}, "emotion": {"joy": 0.7}},
)
WAITING: Pattern = {"person": {"b": 1}, "desire": {"wait": 1}, "place": {"room": 1}, "emotion": NEUTRAL}
BOTH = pytest.mark.parametrize("parameters", [PUBLISHED, Parameters()], ids=["as published", "absent does not count"])


def one_episode(parameters: Parameters, emotion: float | None = None) -> EMArt:
    art = EMArt(parameters)
    for pattern in INPUTS:
        art.perceive(pattern, emotion)
    closed = art.close(100.0, emotion)
    assert closed is not None
    assert closed.new
    return art


@BOTH
def test_published_check_1_the_same_input_three_times_is_one_event(parameters: Parameters) -> None:
    art = EMArt(parameters)
    pattern: Pattern = {"person": {"a": 1}, "object": {"ball": 1}, "place": {"lab": 1}, "emotion": {"surprise": 0.7}}
    assert [art.perceive(pattern).event for _ in range(3)] == [1, 1, 1]
    assert art.nodes == 8
    assert art.events[1].weights == pattern


@BOTH
@pytest.mark.parametrize("more", [{"person": {"b": 1, "c": 1}}, {"object": {"book": 1}}], ids=["known", "new channel"])
def test_published_checks_2_and_3_one_more_item_is_another_event_and_the_first_comes_back(
    parameters: Parameters, more: Pattern
) -> None:
    art = EMArt(parameters)
    assert art.perceive(WAITING).new
    assert art.perceive({**WAITING, **more}).new
    assert (len(art.events), art.nodes) == (2, 10)
    again = art.perceive(WAITING)
    assert (again.event, again.new) == (1, False)
    assert (len(art.events), art.nodes) == (2, 10)


@BOTH
def test_published_check_4_five_inputs_are_five_events_and_one_episode(parameters: Parameters) -> None:
    art = one_episode(parameters)
    assert (len(art.events), len(art.episodes)) == (5, 1)
    weights = art.episodes[1].weights
    assert weights == pytest.approx({1: 0.95**4, 2: 0.95**3, 3: 0.95**2, 4: 0.95, 5: 1.0})
    assert art.under_way == (), "all activations are cleared"


@BOTH
@pytest.mark.parametrize("emotion", [None, 0.0], ids=["unknown", "none felt"])
def test_published_check_5_the_episode_is_recognized_from_its_first_input_on(
    parameters: Parameters, emotion: float | None
) -> None:
    art = one_episode(parameters, emotion)
    for number, pattern in enumerate(INPUTS):
        perceived = art.perceive(pattern, emotion)
        assert not perceived.new
        assert perceived.event == number + 1
        assert perceived.recognized is not None
        assert perceived.recognized.episode == 1
        assert [each.event for each in perceived.recognized.anticipated] == [2, 3, 4, 5][number:]
    closed = art.close(200.0, emotion)
    assert closed is not None
    assert (closed.episode, closed.new) == (1, False)
    assert (len(art.events), len(art.episodes)) == (5, 1)
    assert (art.episodes[1].times, art.episodes[1].first, art.episodes[1].last) == (2, 100.0, 200.0)


def test_something_else_is_not_recognized() -> None:
    art = one_episode(Parameters())
    assert art.perceive({"person": {"z": 1}, "place": {"cellar": 1}}).recognized is None
    closed = art.close(1.0)
    assert closed is not None
    assert closed.new


def test_an_event_that_is_anticipated_is_recognized_with_less_and_only_at_the_next_input() -> None:
    parameters = Parameters(channels={"object": 1.0})
    first, second = {"object": {"door": 1.0}}, {"object": {"a": 1.0, "b": 1.0, "c": 1.0}}
    less = {"object": {"a": 1.0, "b": 1.0, "c": 0.3}}
    art = EMArt(parameters)
    art.perceive(first)
    art.perceive(second)
    art.close(1.0)
    perceived = art.perceive(first)
    assert perceived.recognized is not None
    (expected,) = perceived.recognized.anticipated
    assert (expected.event, expected.vigilance) == (2, pytest.approx(0.75))
    assert complement_fit(less["object"], second["object"]).match < 0.95
    found = art.perceive(less)
    assert (found.event, found.new, found.anticipated) == (2, False, True)
    unexpected = EMArt(parameters)
    unexpected.perceive(first)
    unexpected.perceive(second)
    assert unexpected.perceive(less).new


def test_vigilance_of_anticipated_events_rises_in_their_order() -> None:
    art = one_episode(Parameters())
    recognized = art.perceive(INPUTS[0]).recognized
    assert recognized is not None
    lowered = [0.95 - each.vigilance for each in recognized.anticipated]
    assert lowered == pytest.approx([0.2, 0.15, 0.1, 0.05])


def test_emotion_changes_rates_and_vigilance_as_published() -> None:
    assert rate_before(0.6, 1.0) == pytest.approx(0.6 + 0.25 * 0.6 * 0.5)
    assert rate_before(0.6, 0.0) == pytest.approx(0.6 - 0.25 * 0.6 * 0.5)
    assert rate_after(0.6, 1.0) == pytest.approx(0.6 - 0.375 * 0.6 * 0.5)
    assert rate_after(0.9, 0.0) == 1.0, "at most 1"
    assert rate_before(0.11, 0.0) == 0.1, "at least 0.1"
    assert rate_before(0.6, None) == rate_after(0.6, None) == rate_before(0.6, 0.5) == 0.6
    assert episode_vigilance(0.55, 1.0, {1: 0.1}) == pytest.approx(0.55 - 0.2 * 0.55 * 0.5)
    assert episode_vigilance(0.55, 0.0, {1: 0.1}) == pytest.approx(0.55 + 0.2 * 0.55 * 0.5)
    assert episode_vigilance(0.55, None, {1: 0.7, 2: 0.9}) == 0.7
    assert episode_vigilance(0.5, 1.0, {1: 0.1}) == 0.45
    assert episode_vigilance(0.55, None, {1: 1.0}) == 0.85
    calm, moved = one_episode(Parameters(), 0.0).episodes[1], one_episode(Parameters(), 1.0).episodes[1]
    assert moved.learning_rate < calm.learning_rate


def test_known_items_that_are_absent_blur_events_as_published_and_do_not_otherwise() -> None:
    def distinguished(parameters: Parameters, known: int) -> bool:
        art = EMArt(parameters)
        for number in range(known):
            art.perceive({"object": {f"other {number}": 1.0}, "place": {f"room {number}": 1.0}})
        one = art.perceive({"object": {"cup": 1.0}, "place": {"kitchen": 1.0}})
        return art.perceive({"object": {"cup": 1.0, "plate": 1.0}, "place": {"kitchen": 1.0}}).event != one.event

    assert distinguished(PUBLISHED, 7)
    assert not distinguished(PUBLISHED, 12)
    assert distinguished(Parameters(), 12)
    assert distinguished(Parameters(), 40)


def test_what_usually_happens_is_recognized_before_what_fits_a_little_better_and_learned_only_if_it_fits() -> None:
    def after(habit: float) -> int | None:
        art = EMArt(Parameters(habit=habit))
        for rooms in ("abcdef", "abcdef", "abcdef", "axy"):
            for room in rooms:
                art.perceive({"place": {room: 1.0}})
            art.close(1.0)
        found = art.perceive({"place": {"a": 1.0}}).recognized
        for room in "xy":
            art.perceive({"place": {room: 1.0}})
        closed = art.close(2.0)
        assert closed is not None
        assert closed.episode == 2, "the exception is learned as such"
        return None if found is None else found.episode

    assert after(habit=0.0) == 2, "as published: of the shorter one, the first event weighs more"
    assert after(habit=0.25) == 1


def test_what_is_used_least_is_forgotten_first_and_age_counts() -> None:
    art = EMArt(Parameters())
    for visit in range(3):
        for room in range(3 - visit):
            art.perceive({"place": {f"room {room}": 1.0}})
            art.close(100.0 * visit + room)
    assert [each.times for each in art.episodes.values()] == [3, 2, 1]
    assert art.bound(episodes=2, events=100, since=0.0) == (3,)
    assert art.bound(episodes=9, events=1, since=0.0) == (2,)
    assert len(art.events) == 1, "events go with their episodes"
    assert art.bound(episodes=9, events=9, since=1000.0) == (1,)
    assert not art.episodes
    assert not art.events
    assert art.perceive({"place": {"room 0": 1.0}}).event > 3, "no number is used again"


def test_an_episode_that_never_ends_is_bounded() -> None:
    art = EMArt(Parameters())
    for number in range(400):
        art.perceive({"object": {f"thing {number}": 1.0}})
    assert len(art.events) == len(art.under_way) == 90  # 0.95^90 < 0.01


def test_bad_input_is_refused_with_what_is_allowed() -> None:
    art = EMArt(Parameters())
    with pytest.raises(ValueError, match="'smell' is no channel of this memory; there are: person, object"):
        art.perceive({"smell": {"soup": 1.0}})
    with pytest.raises(ValueError, match=r"object soup: an activation is from 0 to 1, not 1\.5"):
        art.perceive({"object": {"soup": 1.5}})
    assert not art.events


UNIT = st.floats(0, 1, allow_nan=False, width=32)
WEIGHTS = st.dictionaries(st.sampled_from("abcdef"), UNIT.filter(lambda w: w >= 0.01), max_size=6)
PATTERNS = st.fixed_dictionaries({}, optional=dict.fromkeys(("person", "object", "place", "desire"), WEIGHTS))
INTENSITIES = st.none() | UNIT


@given(WEIGHTS, WEIGHTS, UNIT)
def test_learning_never_makes_the_match_worse(weights: Pattern, pattern: Pattern, rate: float) -> None:
    after = learned(weights, pattern, rate, 0.0)  # type: ignore[arg-type]
    assert complement_fit(pattern, after).match >= complement_fit(pattern, weights).match - 1e-6  # type: ignore[arg-type]
    assert plain_fit(pattern, after).match >= plain_fit(pattern, weights).match - 1e-6  # type: ignore[arg-type]


@given(WEIGHTS, UNIT)
def test_learning_the_same_again_changes_nothing(weights: dict[str, float], rate: float) -> None:
    assert learned(weights, weights, rate, 0.01) == weights


@given(st.lists(st.tuples(PATTERNS, INTENSITIES, st.booleans()), max_size=16))
def test_whatever_comes_in_everything_stays_in_range_and_bounded(
    inputs: list[tuple[Pattern, float | None, bool]],
) -> None:
    art = EMArt(Parameters())
    for number, (pattern, emotion, over) in enumerate(inputs):
        perceived = art.perceive(pattern, emotion)
        event = art.events[perceived.event]
        if not perceived.new and not perceived.anticipated:
            for channel, relevance in art.parameters.channels.items():
                fit = complement_fit(pattern.get(channel, {}), event.weights.get(channel, {}))
                assert fit.match >= 0.95 * relevance - 0.02, "the winner resonates after it has learned, to the cut-off"
        if over:
            art.close(float(number), emotion)
            art.bound(episodes=4, events=8, since=number - 10.0)
            assert len(art.episodes) <= 4
            assert len(art.events) <= 8
    for event in art.events.values():
        assert 0.1 <= event.learning_rate <= 1
        assert all(0 < w <= 1 for items in event.weights.values() for w in items.values())
    for episode in art.episodes.values():
        assert 0.1 <= episode.learning_rate <= 1
        assert 0.45 <= episode.vigilance <= 0.85
        assert all(0 < w <= 1 and key in art.events for key, w in episode.weights.items())
