"""Text to speech by espeak-ng, through the library that the optional package ``espeakng-loader`` brings."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

_SYNCHRONOUS = 2
_CHARACTERS, _UTF8 = 1, 1
_RATE, _PITCH = 1, 3
_Callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)


class NoSpeechSynthesis(Exception):
    """Text cannot be spoken here; the message says what to install."""


def speak(
    text: str, language: str = "en", pitch: int = 50, words_per_minute: int = 160
) -> tuple[NDArray[np.float32], int]:
    """``text`` spoken: samples (N,) in [-1, 1] and their rate; ``pitch`` 0 to 100.

    Raises NoSpeechSynthesis where espeak-ng is not installed or has no such language.
    """
    library, rate = _library()
    if library.espeak_SetVoiceByName(language.encode()) != 0:
        raise NoSpeechSynthesis(f"espeak-ng has no language {language!r}")
    library.espeak_SetParameter(_RATE, words_per_minute, 0)
    library.espeak_SetParameter(_PITCH, pitch, 0)
    pieces: list[NDArray[np.int16]] = []

    def take(samples: Any, count: int, _events: Any) -> int:
        if count > 0:
            pieces.append(np.ctypeslib.as_array(samples, shape=(count,)).copy())
        return 0

    callback = _Callback(take)
    library.espeak_SetSynthCallback(callback)
    encoded = text.encode()
    library.espeak_Synth(encoded, len(encoded) + 1, 0, _CHARACTERS, 0, _UTF8, None, None)
    spoken = np.concatenate(pieces) if pieces else np.zeros(0, dtype=np.int16)
    return spoken.astype(np.float32) / 32768.0, rate


@lru_cache(maxsize=1)
def _library() -> tuple[Any, int]:
    try:
        import espeakng_loader
    except ImportError:
        raise NoSpeechSynthesis("speaking text needs espeak-ng: pip install 'hbba[speech]'") from None
    library = ctypes.CDLL(espeakng_loader.get_library_path())
    rate = library.espeak_Initialize(_SYNCHRONOUS, 0, espeakng_loader.get_data_path().encode(), 0)
    if rate <= 0:
        raise NoSpeechSynthesis("espeak-ng is installed but cannot be set up")
    return library, int(rate)
