from __future__ import annotations

import importlib.util
import sys
import threading
from itertools import pairwise

import numpy as np
import pytest

from app.speech import espeak
from app.speech.espeak import Espeak
from app.speech.manner import USUAL, Manner
from app.speech.utterance import SpeechError, Utterance
from app.speech.visemes import Viseme

needs_espeak = pytest.mark.skipif(
    importlib.util.find_spec("espeakng_loader") is None, reason="the extra 'speech' is not installed"
)


def said(utterance: Utterance) -> list[str]:
    return [utterance.text[word.begin : word.end] for word in utterance.words]


def test_without_the_package_the_remedy_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "espeakng_loader", None)
    espeak._library.cache_clear()
    with pytest.raises(SpeechError, match=r"pip install 'hbba\[speech\]'"):
        Espeak().synthesize("hello", "en")


@needs_espeak
@pytest.mark.parametrize(
    ("text", "language"),
    [
        ("Suivez-moi jusqu'à 3.5 mètres, s'il vous plaît. Merci!", "fr"),
        ("Come here, robot: it is 3.5 m away.", "en"),
        ("Größe und Übermut.", "de"),
    ],
)
def test_words_are_those_of_the_text_each_at_its_time(text: str, language: str) -> None:
    utterance = Espeak().synthesize(text, language)
    assert said(utterance) == text.split()
    assert all(word.start_s < word.end_s for word in utterance.words)
    assert all(a.end_s <= b.start_s for a, b in pairwise(utterance.words))
    assert utterance.duration_s == pytest.approx(len(utterance.samples) / utterance.rate)


@needs_espeak
def test_the_last_word_of_a_clause_ends_at_its_pause() -> None:
    utterance = Espeak().synthesize("Hello, robot.", "en")
    hello, robot = utterance.words
    between = utterance.samples[int(hello.end_s * utterance.rate) : int(robot.start_s * utterance.rate)]
    assert robot.start_s - hello.end_s > 0.1
    assert np.abs(between).max() < 0.1 * np.abs(utterance.samples).max()


@needs_espeak
def test_lips_close_for_m_and_open_for_a() -> None:
    shapes = [moment.viseme for moment in Espeak().synthesize("mama", "en").mouth]
    assert shapes[:2] == [Viseme.CLOSED, Viseme.OPEN]
    assert Viseme.CLOSED in shapes[2:]


@needs_espeak
def test_a_language_it_does_not_have_is_named() -> None:
    with pytest.raises(SpeechError, match="no voice 'xx'"):
        Espeak().synthesize("hello", "xx")


@needs_espeak
def test_voices_differ_and_any_text_is_safe() -> None:
    high, low = Espeak(pitch=90).synthesize("hello", "en"), Espeak(pitch=10).synthesize("hello", "en")
    assert not np.array_equal(high.samples[:2000], low.samples[:2000])
    whole = Espeak().synthesize("hello\0 world <break time='9s'/>", "en")
    assert said(whole)[:2] == ["hello\0", "world"]
    assert Espeak().synthesize("", "en").words == ()


@needs_espeak
def test_a_manner_hastens_and_raises_the_voice_by_its_shares_within_bounds() -> None:
    text = "Mary ran away in early morning."
    usual, fast, high = (
        Espeak("m3").synthesize(text, "en", manner) for manner in (USUAL, Manner(1.12), Manner(1, 1.12))
    )
    assert usual.duration_s / fast.duration_s == pytest.approx(1.12, abs=0.08)
    assert pitch_hz(high) / pitch_hz(usual) == pytest.approx(1.12, abs=0.05)
    assert high.duration_s == pytest.approx(usual.duration_s, rel=0.05)
    assert said(fast) == said(high) == text.split()
    with pytest.raises(ValueError, match="the rate of speaking is a number over 0, not 0"):
        Manner(rate=0)
    assert Espeak(words_per_minute=450, pitch=99).synthesize("hello", "en", Manner(2, 2)).duration_s > 0


def pitch_hz(utterance: Utterance) -> float:
    """The median frequency of the voice, by autocorrelation of its loud parts."""
    size, rate = round(0.05 * utterance.rate), utterance.rate
    frames = utterance.samples[: len(utterance.samples) // size * size].reshape(-1, size).astype(float)
    loud = frames[np.std(frames, axis=1) > 0.3 * np.std(utterance.samples)]
    lags = np.arange(rate // 300, rate // 60)
    found = []
    for frame in loud - loud.mean(axis=1, keepdims=True):
        likeness = [
            frame[lag:] @ frame[:-lag] / np.sqrt((frame[lag:] @ frame[lag:]) * (frame[:-lag] @ frame[:-lag]))
            for lag in lags
        ]
        found.append(rate / lags[int(np.argmax(likeness))])
    return float(np.median(found))


@needs_espeak
def test_two_threads_take_turns() -> None:
    texts = ("one two three", "seven")
    alone = [Espeak().synthesize(text, "en") for text in texts]
    results: list[bool] = []

    def speak(text: str, known: Utterance) -> None:
        for _ in range(5):
            utterance = Espeak().synthesize(text, "en")
            # espeak-ng varies a length by a millisecond.
            same_length = abs(utterance.duration_s - known.duration_s) < 0.02
            results.append(said(utterance) == said(known) and same_length)

    threads = [threading.Thread(target=speak, args=pair) for pair in zip(texts, alone, strict=True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [True] * 10
