from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.speech.text_spans import sentences_of, spoken_words, words_of


def cut(text: str) -> list[str]:
    return [text[begin:end] for begin, end in sentences_of(text)]


@pytest.mark.parametrize(
    ("text", "sentences"),
    [
        ("Hello. How are you?", ["Hello.", "How are you?"]),
        ("It is 3.5 m away! “Come.” Now", ["It is 3.5 m away!", "“Come.”", "Now"]),
        ("Bonjour… ça va ?", ["Bonjour…", "ça va ?"]),
        ("one\n\ntwo", ["one", "two"]),
        ("  ... - ", []),
        ("你好。再见！", ["你好。", "再见！"]),
    ],
)
def test_a_text_is_cut_into_sentences(text: str, sentences: list[str]) -> None:
    assert cut(text) == sentences


@given(st.text(st.sampled_from("ab 3.!?,\n'”…-"), max_size=60))
def test_sentences_follow_each_other_and_hold_every_word(text: str) -> None:
    spans = sentences_of(text)
    assert all(a[1] <= b[0] for a, b in pairwise(spans))
    for word in words_of(text):
        assert any(begin <= word[0] and word[1] <= end for begin, end in spans)


def test_parts_of_a_word_are_one_word() -> None:
    text = "jusqu'à 3.5 m"
    words = spoken_words(text, [(0, 0.0, 0.2), (6, 0.2, 0.4), (8, 0.4, 0.5), (9, 0.5, 0.7), (12, 0.7, 0.9)])
    assert [(text[w.begin : w.end], w.start_s, w.end_s) for w in words] == [
        ("jusqu'à", 0.0, 0.4),
        ("3.5", 0.4, 0.7),
        ("m", 0.7, 0.9),
    ]


def test_a_word_without_an_event_has_no_time() -> None:
    words = spoken_words("one two", [(4, 0.3, 0.5)])
    assert [(w.begin, w.end) for w in words] == [(4, 7)]
