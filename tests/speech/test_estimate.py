from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.speech.estimate import estimated_mouth, estimated_words
from app.speech.text_only import TextOnly
from app.speech.visemes import Viseme, of_phoneme


@given(st.text(max_size=80), st.floats(0.1, 60))
def test_estimated_words_fill_the_time_in_order(text: str, duration_s: float) -> None:
    words = estimated_words(text, duration_s)
    assert all(word.start_s <= word.end_s for word in words)
    assert all(a.end_s <= b.start_s and a.end <= b.begin for a, b in pairwise(words))
    assert not words or (words[0].start_s == 0 and words[-1].end_s <= duration_s * (1 + 1e-9))
    moments = estimated_mouth(text, words)
    assert all(a.start_s <= b.start_s for a, b in pairwise(moments))


def test_a_hundred_and_sixty_words_take_a_minute() -> None:
    utterance = TextOnly(160).synthesize("hello " * 160, "en")
    assert utterance.duration_s == pytest.approx(60.0)
    assert len(utterance.words) == 160
    assert utterance.samples.size == 0


def test_the_mouth_closes_at_punctuation_and_at_the_end() -> None:
    utterance = TextOnly().synthesize("no, wow", "en")
    pause_s = (utterance.words[0].end_s + utterance.words[1].start_s) / 2
    assert utterance.viseme_at(pause_s) is Viseme.CLOSED
    assert utterance.viseme_at(utterance.words[1].start_s) is Viseme.PURSED
    assert utterance.viseme_at(utterance.duration_s) is Viseme.CLOSED
    assert utterance.word_at(-0.1) == -1
    assert utterance.word_at(pause_s) == 0
    assert utterance.word_at(utterance.duration_s) == 1


@pytest.mark.parametrize(
    ("ipa", "viseme"),
    [
        ("", Viseme.CLOSED),
        ("m", Viseme.CLOSED),
        ("ˈɑː", Viseme.OPEN),
        ("ˌoʊ", Viseme.ROUND),
        ("ɛ̃", Viseme.SPREAD),
        ("u", Viseme.PURSED),
        ("v", Viseme.TEETH),
        ("k", Viseme.NARROW),
        ("ə", Viseme.MID),
    ],
)
def test_a_phoneme_has_a_viseme(ipa: str, viseme: Viseme) -> None:
    assert of_phoneme(ipa) is viseme
