from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.modules.behaviors.speech.barge_in import BargeIn
from app.modules.behaviors.speech.speech_queue import SpeechRequest, next_request


def request(desire: str, priority: int = 5, created: float = 0.0, *, interruptible: bool = True) -> SpeechRequest:
    return SpeechRequest(
        desire, desire, "en", priority=priority, interruptible=interruptible, volume=1.0, created=created
    )


def said_next(requests: list[SpeechRequest], current: str | None) -> str | None:
    chosen = next_request(requests, current)
    return None if chosen is None else chosen.desire


def test_the_greatest_priority_is_first_then_the_oldest() -> None:
    requests = [request("new", created=2), request("old", created=1), request("weak", 1)]
    assert said_next(requests, None) == "old"
    assert said_next([*requests, request("urgent", 9, created=3)], None) == "urgent"
    assert said_next([], None) is None


def test_what_is_being_said_goes_on_unless_something_more_urgent_may_interrupt_it() -> None:
    old, new = request("old", created=1), request("new", created=2)
    assert said_next([old, new], "new") == "new"
    urgent = request("urgent", 9, created=3)
    assert said_next([old, urgent], "old") == "urgent"
    firm = request("firm", interruptible=False)
    assert said_next([firm, urgent], "firm") == "firm"
    assert said_next([urgent], "firm") == "urgent"


@given(st.lists(st.tuples(st.integers(0, 3), st.floats(0, 9), st.booleans()), min_size=1, max_size=6))
def test_every_text_is_said_at_last(made: list[tuple[int, float, bool]]) -> None:
    waiting = [request(str(n), p, c, interruptible=i) for n, (p, c, i) in enumerate(made)]
    said: list[str] = []
    current: str | None = None
    while waiting:
        current = said_next(waiting, current)
        assert current is not None
        assert said_next(waiting, current) == current
        said.append(current)
        waiting = [r for r in waiting if r.desire != current]
    assert sorted(said) == sorted(str(n) for n in range(len(made)))


def test_a_person_who_goes_on_talking_makes_the_robot_yield() -> None:
    barge_in = BargeIn(0.5, 1.0)
    for tenth in range(5):
        barge_in.hear(10 + tenth / 10, voice=True)
        assert not barge_in.yields(10 + tenth / 10)
    barge_in.hear(10.7, voice=False)
    barge_in.hear(10.75, voice=True)
    assert barge_in.yields(10.75)
    assert barge_in.yields(11.74)
    assert not barge_in.yields(11.8)


def test_a_short_sound_and_a_robot_that_does_not_yield() -> None:
    barge_in = BargeIn(0.5, 1.0)
    barge_in.hear(10.0, voice=True)
    barge_in.hear(10.6, voice=True)
    assert not barge_in.yields(10.6)
    never = BargeIn(None, 1.0)
    for tenth in range(100):
        never.hear(tenth / 10, voice=True)
    assert not never.yields(10.0)
