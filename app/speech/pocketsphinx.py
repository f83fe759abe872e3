"""PocketSphinx: small grammars, by the optional package ``pocketsphinx``, whose wheel brings an English model.

Each phrase is a path through the grammar; its score is of each frame's sound by the path's phones against the best of
all phones of the model. Two numbers say how sure the best phrase is, and both must be good (:func:`confidence`): by how
much the next best phrase is worse, which is small where two sound alike; and the mean score of a frame, which is low
where something else was said that sounds like none of them.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.speech.recognition import RATE, Recognition, RecognitionError

#: Of the model in the wheel.
_LANGUAGE = "en"
#: The logarithm's base of scores.
_BASE = 1.0001
#: Middle and width of the two logistic functions of :func:`confidence`, chosen by ``benchmarks/words.py``.
_MARGIN, _MARGIN_WIDTH = 150.0, 100.0
_FRAME_SCORE, _FRAME_SCORE_WIDTH = -64.0, 2.5
#: Utterances shorter than this (s) have no word.
_LEAST_S = 0.1


def confidence(margin: float, frame_score: float) -> float:
    """In [0, 1], of a phrase that is better than the next by ``margin`` and has ``frame_score`` a frame."""
    return _logistic((margin - _MARGIN) / _MARGIN_WIDTH) * _logistic((frame_score - _FRAME_SCORE) / _FRAME_SCORE_WIDTH)


class PocketSphinx:
    """PocketSphinx with the model in the folder ``path`` (an acoustic model, and one dictionary ``*.dict`` beside its
    files), of any language; None: the package's, of English."""

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._decoder: Any = None
        #: Names of the grammars that the decoder has.
        self._grammars: set[str] = set()

    def recognize(self, samples: NDArray[np.int16], phrases: Sequence[str], language: str) -> Recognition | None:
        """As :class:`~app.speech.recognition.RecognitionEngine` says."""
        self._check(phrases, language)
        if len(samples) < _LEAST_S * RATE:
            return None
        best = self._decoded(samples, tuple(phrases))
        if best is None:
            return None
        text, score, frames = best
        others = tuple(phrase for phrase in phrases if phrase != text)
        second = self._decoded(samples, others) if others else None
        margin = math.inf if second is None else score - second[1]
        return Recognition(text, confidence(margin, score / max(1, frames)))

    def _check(self, phrases: Sequence[str], language: str) -> None:
        decoder = self._opened()
        if self._path is None and language.partition("-")[0] != _LANGUAGE:
            raise RecognitionError(
                f"PocketSphinx's own model is English, and cannot recognize words in {language!r}: give the recognizer "
                "the path of a model of that language"
            )
        for phrase in phrases:
            for word in phrase.split():
                if decoder.lookup_word(word) is None:
                    raise RecognitionError(f"the word {word!r} is not in PocketSphinx's dictionary: use another")

    def _opened(self) -> Any:
        if self._decoder is None:
            try:
                from pocketsphinx import Decoder
            except ImportError:
                raise RecognitionError("recognizing words needs PocketSphinx: pip install 'hbba[words]'") from None
            # All phones are scored in each frame, and no lattice: else scores of two grammars are not comparable.
            # Without lm=None, it reads a language model of 27 MB.
            options: dict[str, Any] = {"lm": None, "loglevel": "FATAL", "compallsen": True, "bestpath": False}
            if self._path is not None:
                dictionaries = sorted(self._path.glob("*.dict"))
                if len(dictionaries) != 1:
                    raise RecognitionError(
                        f"{self._path} must be a folder with an acoustic model of PocketSphinx and one file *.dict"
                    )
                options |= {"hmm": str(self._path), "dict": str(dictionaries[0])}
            try:
                self._decoder = Decoder(**options)
            except RuntimeError as failure:
                raise RecognitionError(f"PocketSphinx cannot read the model in {self._path}: {failure}") from None
        return self._decoder

    def _decoded(self, samples: NDArray[np.int16], phrases: tuple[str, ...]) -> tuple[str, float, int] | None:
        """The best of ``phrases``, its score and the number of frames; None where no path fits."""
        decoder = self._decoder
        name = hashlib.sha256("|".join(phrases).encode()).hexdigest()
        if name not in self._grammars:
            grammar = f"#JSGF V1.0; grammar g; public <phrase> = {' | '.join(phrases)};"
            decoder.add_jsgf_string(name, grammar)
            self._grammars.add(name)
        decoder.activate_search(name)
        # The estimate of the noise is else that of the utterance before: results would depend on it.
        decoder.reinit_feat()
        decoder.start_utt()
        decoder.process_raw(samples.tobytes(), full_utt=True)
        decoder.end_utt()
        found = decoder.hyp()
        if found is None or not found.hypstr:
            return None
        # A word of several pronunciations may come with a number: again(2).
        text = re.sub(r"\(\d+\)", "", found.hypstr)
        if text not in phrases:
            return None
        return text, math.log(max(found.score, 1e-300)) / math.log(_BASE), int(decoder.n_frames())


def _logistic(x: float) -> float:
    return 1 / (1 + math.exp(-max(-50.0, min(50.0, x))))
