"""espeak-ng, through the library that the optional package ``espeakng-loader`` brings: a hundred languages."""

from __future__ import annotations

import ctypes
import math
import threading
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.speech.manner import USUAL, Manner
from app.speech.text_spans import spoken_words
from app.speech.utterance import MouthMoment, SpeechError, Utterance
from app.speech.visemes import of_phoneme

#: Arguments of the library's functions, by the names of its header.
_SYNCHRONOUS = 2
_PHONEME_EVENTS, _IN_IPA = 1, 2
_CHARACTERS, _UTF8, _END_PAUSE = 1, 1, 0x1000
_RATE, _PITCH = 1, 3
_LIST_ENDS, _WORD, _CLAUSE_ENDS, _PHONEME = 0, 1, 5, 7

#: Bounds of the library's parameters.
_RATES, _PITCHES = (80, 450), (0, 100)
#: So many points of pitch raise a voice by an octave: measured of the voices m3 and f2 from 20 to 80 points, 73 to 80.
_OCTAVE = 75
#: The library has one state for the whole process.
_LOCK = threading.Lock()


class _Identity(ctypes.Union):
    _fields_ = (("number", ctypes.c_int), ("name", ctypes.c_char_p), ("string", ctypes.c_char * 8))


class _Event(ctypes.Structure):
    _fields_ = (
        ("type", ctypes.c_int),
        ("unique_identifier", ctypes.c_uint),
        ("text_position", ctypes.c_int),
        ("length", ctypes.c_int),
        ("audio_position", ctypes.c_int),
        ("sample", ctypes.c_int),
        ("user_data", ctypes.c_void_p),
        ("id", _Identity),
    )


_Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(_Event))


@dataclass(slots=True)
class _Heard:
    """What the library gave: sound, and (time in samples, ...) of words' positions, clause ends and phonemes."""

    pieces: list[NDArray[np.int16]] = field(default_factory=list)
    words: list[tuple[int, int]] = field(default_factory=list)
    ends: list[int] = field(default_factory=list)
    phonemes: list[tuple[int, str]] = field(default_factory=list)

    def take(self, samples: Any, count: int, events: Any) -> int:
        """The library's callback."""
        if count > 0 and samples:
            self.pieces.append(np.ctypeslib.as_array(samples, shape=(count,)).copy())
        index = 0
        while events and (event := events[index]).type != _LIST_ENDS:
            index += 1
            if event.type == _WORD:
                self.words.append((event.sample, event.text_position - 1))
            elif event.type == _CLAUSE_ENDS:
                self.ends.append(event.sample)
            elif event.type == _PHONEME:
                self.phonemes.append((event.sample, event.id.string.decode("utf-8", "ignore")))
        return 0


class Espeak:
    """espeak-ng with one voice.

    ``variant``: of the voice, as ``m3`` or ``f2``, "" for the language's own. ``words_per_minute``: 80 to 450;
    ``pitch``: 0 to 100.
    """

    def __init__(self, variant: str = "", words_per_minute: int = 160, pitch: int = 50) -> None:
        self._variant = variant
        self._words_per_minute = words_per_minute
        self._pitch = pitch

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        """``text`` with the times of words and phonemes; ``manner`` within the library's bounds.

        Raises SpeechError where espeak-ng is not installed, or has no such language or variant.
        """
        heard = _Heard()
        # A null character would end the text, other control characters are commands.
        plain = "".join(character if character.isprintable() else " " for character in text)
        encoded = plain.encode("utf-8", "replace")
        with _LOCK:
            library, rate = _library()
            voice = f"{language}+{self._variant}" if self._variant else language
            if library.espeak_SetVoiceByName(voice.encode("utf-8", "replace")) != 0:
                raise SpeechError(f"espeak-ng has no voice {voice!r}; `espeak-ng --voices` lists the languages")
            library.espeak_SetParameter(_RATE, _within(_RATES, self._words_per_minute * manner.rate), 0)
            library.espeak_SetParameter(_PITCH, _within(_PITCHES, self._pitch + _OCTAVE * math.log2(manner.pitch)), 0)
            callback = _Callback(heard.take)
            library.espeak_SetSynthCallback(callback)
            library.espeak_Synth(encoded, len(encoded) + 1, 0, _CHARACTERS, 0, _UTF8 | _END_PAUSE, None, None)
        return _utterance(text, heard, rate)


def _within(bounds: tuple[int, int], value: float) -> int:
    return min(max(round(value), bounds[0]), bounds[1])


def _utterance(text: str, heard: _Heard, rate: int) -> Utterance:
    samples = np.concatenate(heard.pieces) if heard.pieces else np.zeros(0, np.int16)
    # A word lasts until the next one begins, its clause ends or a pause comes.
    pauses = [at for at, ipa in heard.phonemes if not ipa]
    bounds = sorted([*(at for at, _ in heard.words), *heard.ends, *pauses, len(samples)])
    words = []
    for at, position in heard.words:
        end = next((bound for bound in bounds if bound > at), at)
        words.append((position, at / rate, end / rate))
    mouth = tuple(MouthMoment(at / rate, of_phoneme(ipa)) for at, ipa in heard.phonemes)
    return Utterance(text, samples, rate, duration_s=len(samples) / rate, words=spoken_words(text, words), mouth=mouth)


@lru_cache(maxsize=1)
def _library() -> tuple[Any, int]:
    """The library, set up once for the process, and the rate of its sound."""
    try:
        import espeakng_loader
    except ImportError:
        raise SpeechError("speaking text needs espeak-ng: pip install 'hbba[speech]'") from None
    library = ctypes.CDLL(espeakng_loader.get_library_path())
    options = _PHONEME_EVENTS | _IN_IPA
    rate = library.espeak_Initialize(_SYNCHRONOUS, 0, espeakng_loader.get_data_path().encode(), options)
    if rate <= 0:
        raise SpeechError("espeak-ng is installed but cannot be set up: install the extra again (hbba[speech])")
    return library, int(rate)
