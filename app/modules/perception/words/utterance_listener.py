"""From the sound of all microphones to single utterances: endpointing by one microphone, the beam by all. Pure."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.resampling import Resampler, resampled
from app.modules.perception.words.endpointing import Endpointer, Utterance
from app.modules.perception.words.utterance_beam import RATE, UtteranceBeam

_FULL_SCALE = np.float32(32768)
#: Sound (s) before an utterance by which its noise is known, at most, and sound between them that is neither.
_NOISE_S, _APART_S = 1.5, 0.03
#: Sound (s) kept beyond the longest utterance, the noise before it and the pause after it.
_SPARE_S = 1.0
#: Peak of an utterance given to a recognizer, of full scale.
_PEAK = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class HeardUtterance:
    """``samples`` (N,) int16 at 16 kHz from sample ``begin`` to ``end`` of the microphones; ``direction`` (3,): a unit
    vector in the array's axes from its middle."""

    samples: NDArray[np.int16]
    begin: int
    end: int
    direction: NDArray[np.float64]


class UtteranceListener:
    """Hears utterances of at most ``longest_s`` (s) by the microphones of ``array`` at ``rate`` (Hz, 16,000 and more).

    Longer ones are talk, and left out.
    """

    def __init__(self, array: MicrophoneArray, rate: int, longest_s: float) -> None:
        if rate < RATE:
            raise ValueError(f"words need sound of at least {RATE} samples a second, not {rate}")
        self._rate = rate
        self._longest_s = longest_s
        self._beam = UtteranceBeam(array)
        self._channels = list(array.channels)
        self._endpointer = Endpointer()
        self._resampler = Resampler(rate, RATE)
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next samples do not follow the last."""
        self._endpointer.reset()
        self._resampler.reset()
        self._sound: deque[tuple[int, NDArray[np.int16]]] = deque()
        self._first: int | None = None

    def process(self, samples: NDArray[np.int16], first_sample: int) -> list[HeardUtterance]:
        """Take the next samples (N, C), of which the first is number ``first_sample``; the utterances that they end."""
        if self._first is None:
            self._first = first_sample
        self._sound.append((first_sample, samples))
        one = samples[:, self._channels[0]].astype(np.float32) / _FULL_SCALE
        ended = self._endpointer.update(self._resampler.process(one))
        heard = [self._heard(utterance) for utterance in ended if self._short(utterance)]
        oldest = first_sample - round((self._longest_s + _NOISE_S + _SPARE_S) * self._rate)
        while self._sound[0][0] + len(self._sound[0][1]) < oldest:
            self._sound.popleft()
        return heard

    def _short(self, utterance: Utterance) -> bool:
        return utterance.end - utterance.begin <= self._longest_s * RATE

    def _heard(self, utterance: Utterance) -> HeardUtterance:
        quiet = max(utterance.quiet_from, utterance.begin - round(_NOISE_S * RATE))
        before, begin, end = (self._number(at) for at in (quiet, utterance.begin, utterance.end))
        noise = self._resampled(before, begin - round(_APART_S * self._rate))
        focused = self._beam.focus(self._resampled(begin, end), noise)
        peak = max(float(np.abs(focused.samples).max(initial=0)), 1e-6)
        samples = np.rint(focused.samples * (_PEAK / peak) * _FULL_SCALE).astype(np.int16)
        return HeardUtterance(samples, begin, end, focused.direction)

    def _number(self, at: int) -> int:
        """Number of the microphones' sample that the endpointer's sample ``at`` (16 kHz) was made of."""
        assert self._first is not None
        return self._first + max(0, round((at / RATE - self._resampler.delay_s) * self._rate))

    def _resampled(self, begin: int, end: int) -> NDArray[np.float32]:
        """Samples ``begin`` to ``end`` at 16 kHz (N, M), of full scale 1."""
        pieces = [s[max(0, begin - at) : max(0, end - at)] for at, s in self._sound if at < end and begin < at + len(s)]
        if not pieces:
            return np.zeros((0, len(self._channels)), np.float32)
        sound = np.concatenate(pieces)[:, self._channels].astype(np.float32) / _FULL_SCALE
        return resampled(sound, self._rate, RATE)
