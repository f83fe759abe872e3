"""PocketSphinx with the model of its wheel, on words said by espeak-ng."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import resample_poly

from app.base.errors import ConfigError
from app.speech.espeak import Espeak
from app.speech.pocketsphinx import PocketSphinx, confidence
from app.speech.recognition import RATE, Recognition, RecognitionError, RecognizerConfig
from app.speech.recognition_process import RecognitionProcess

WORDS = ("yes", "no", "next", "wait", "kitchen")


def said(text: str, seconds_around: float = 0.25) -> NDArray[np.int16]:
    """``text`` in a little noise, at RATE."""
    pytest.importorskip("espeakng_loader")
    utterance = Espeak().synthesize(text, "en")
    sound = resample_poly(utterance.samples.astype(np.float64), 320, utterance.rate // 50)
    loud = np.flatnonzero(np.abs(sound) > 0.03 * np.abs(sound).max())
    around = np.zeros(round(seconds_around * RATE))
    whole = np.concatenate([around, sound[loud[0] : loud[-1]], around])
    noise = np.random.default_rng(1).normal(0, 0.005 * np.abs(whole).max(), len(whole))
    return np.asarray(np.rint(0.5 * 32767 * (whole + noise) / np.abs(whole + noise).max()), np.int16)


def alike(found: Recognition | None, other: Recognition | None) -> None:
    """The same, but for rounding: the decoder begins with those Gaussians that fitted its last frame."""
    assert found is not None
    assert other is not None
    assert (found.text, found.confidence) == (other.text, pytest.approx(other.confidence, abs=0.02))


@pytest.fixture(scope="module")
def engine() -> PocketSphinx:
    pytest.importorskip("pocketsphinx")
    return PocketSphinx()


@pytest.mark.slow
def test_words_are_recognized_and_sure(engine: PocketSphinx) -> None:
    for word in WORDS:
        found = engine.recognize(said(word), WORDS, "en")
        assert found is not None
        assert (found.text, found.confidence > 0.8) == (word, True), word


@pytest.mark.slow
def test_other_talk_is_unsure(engine: PocketSphinx) -> None:
    for text in ("my brother", "seventy", "good morning everybody"):
        found = engine.recognize(said(text), WORDS, "en")
        assert found is None or found.confidence < 0.5, (text, found)


@pytest.mark.slow
def test_a_phrase_of_several_words_is_one_answer(engine: PocketSphinx) -> None:
    found = engine.recognize(said("go on please"), ("go on please", "come back"), "en")
    assert found is not None
    assert found.text == "go on please"


@pytest.mark.slow
def test_a_result_hardly_depends_on_the_utterance_before(engine: PocketSphinx) -> None:
    first = engine.recognize(said("kitchen"), WORDS, "en")
    engine.recognize(said("no"), WORDS, "en")
    alike(engine.recognize(said("kitchen"), WORDS, "en"), first)


def test_an_empty_utterance_checks_words_and_language(engine: PocketSphinx) -> None:
    nothing = np.zeros(0, np.int16)
    assert engine.recognize(nothing, WORDS, "en-gb") is None
    with pytest.raises(RecognitionError, match="the word 'xyzzyish' is not in PocketSphinx's dictionary"):
        engine.recognize(nothing, ("yes", "xyzzyish"), "en")
    with pytest.raises(RecognitionError, match="cannot recognize words in 'fr'"):
        engine.recognize(nothing, ("oui",), "fr")


def test_a_folder_without_a_model_is_refused_in_a_sentence(tmp_path: Path) -> None:
    pytest.importorskip("pocketsphinx")
    with pytest.raises(RecognitionError, match=r"must be a folder with an acoustic model"):
        PocketSphinx(tmp_path).recognize(np.zeros(0, np.int16), WORDS, "en")


def test_confidence_needs_a_margin_and_a_score() -> None:
    assert confidence(1000, -45) > 0.95
    assert confidence(50, -45) < 0.5
    assert confidence(1000, -90) < 0.05


def test_a_class_that_does_not_exist_is_named() -> None:
    with pytest.raises(ConfigError, match=r"there is no recognizer 'app\.speech\.pocketsphinx:Sphinx'"):
        RecognizerConfig.model_validate({"class": "app.speech.pocketsphinx:Sphinx"}).make()


@pytest.mark.slow
def test_a_process_of_its_own_recognizes_the_same(engine: PocketSphinx) -> None:
    process = RecognitionProcess(RecognizerConfig())
    try:
        alike(process.recognize(said("next"), WORDS, "en"), engine.recognize(said("next"), WORDS, "en"))
        with pytest.raises(RecognitionError, match="'fr'"):
            process.recognize(np.zeros(0, np.int16), ("oui",), "fr")
    finally:
        process.close()
