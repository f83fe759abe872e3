"""Classes of sound by features of its spectrum, of one microphone; no event loop, no state.

A stretch of sound (about 1 s) is cut into frames of 21 ms, half overlapping, with a Hann window. Their power spectra
from 200 Hz to 8 kHz give, with e the energy of a frame:

- *level*: the mean of e, and *crest*: how far the loudest frame is above it (dB);
- *centroid*, the mean frequency, and *roll-off*, below which 85 % of the energy lie (E. Scheirer, M. Slaney, ICASSP
  1997; G. Tzanetakis, P. Cook, IEEE TSAP 10(5), 2002);
- *flatness*: geometric over arithmetic mean of a frame's power spectrum, averaged with e; 0 for a tone, 1 for a flat
  spectrum, 0.56 for a frame of white noise (J. Johnston, IEEE JSAC 6(2), 1988; MPEG-7 audio, ISO/IEC 15938-4);
- *onset*: the greatest rise of e over the frames 30 to 50 ms before it (dB), an onset strength (J. Bello and others,
  IEEE TSAP 13(5), 2005);
- *fall*: how far the last tenth of a second is below the loudest frame (dB);
- *active*: the share of the frames within 12 dB of the loudest;
- *steadiness*: cosine between the magnitude spectra of frames 43 ms apart, averaged with e: 1 for a tone that lasts.

:func:`classify` compares them with thresholds, in this order. What is not louder than the robot itself is *silence*. A
loud part that is short, sudden and over is *impulsive*. A spectrum without lines is *broadband* noise, where the level
is steady; where it is uneven, as that of syllables, hisses are allowed for. A spectrum with lines is *tonal* if they
stay, or if the level lasts without a break, else *voice-like*. The thresholds were chosen on the simulated lab's sounds
(docs/noises.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

SoundClassName = Literal["silence", "voice-like", "tonal", "impulsive", "broadband"]

#: Fewer samples a second do not hold the band.
LEAST_RATE_HZ = 16_000
_LEAST_S = 0.2
_FRAME_S = 1024 / 48_000
_BAND_HZ = (200.0, 8000.0)
_ROLL_OFF = 0.85
_ACTIVE = 10.0**-1.2
#: Frames: those that an onset rises over, and those between two that are compared for steadiness.
_BEFORE, _LAG = (5, 2), 4
_END_S = 0.1
#: -120 dB of full scale.
_NOTHING = 1e-12
_FULL_SCALE = 32768.0


@dataclass(frozen=True, slots=True)
class SoundFeatures:
    """Features of a stretch of sound, see the top of this file: levels in dB of full scale, differences in dB, shares
    from 0 to 1."""

    level_db: float
    crest_db: float
    centroid_hz: float
    rolloff_hz: float
    flatness: float
    onset_db: float
    fall_db: float
    active: float
    steadiness: float


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Of :func:`classify`: ``floor_db`` of full scale, in the band of the features; the others as their features.

    A spectrum has no lines from ``flatness`` on, or from ``hissing`` on where the crest is at least ``uneven_db``.
    ``lasting`` is the least active share of a tone without a break.
    """

    floor_db: float = -57.0
    crest_db: float = 8.0
    uneven_db: float = 5.0
    onset_db: float = 22.0
    fall_db: float = 5.0
    active: float = 0.4
    flatness: float = 0.012
    hissing: float = 0.06
    steadiness: float = 0.9
    lasting: float = 0.9


def features(samples: NDArray[np.int16], rate: int) -> SoundFeatures:
    """Features of ``samples`` (N,) int16, ``rate`` of them a second: at least 16 kHz, and 0.2 s of sound.

    Raises ValueError for less.
    """
    size = 2 * round(_FRAME_S * rate / 2)
    if rate < LEAST_RATE_HZ or len(samples) < _LEAST_S * rate:
        raise ValueError(f"{len(samples)} samples at {rate} Hz; at least {_LEAST_S} s at {LEAST_RATE_HZ} Hz are needed")
    window = np.hanning(size)
    frames = np.lib.stride_tricks.sliding_window_view(samples, size)[:: size // 2] * (window / _FULL_SCALE)
    spectra = np.abs(np.fft.rfft(frames, axis=1)) ** 2 * (2 / (size * np.sum(window**2)))
    hz = np.fft.rfftfreq(size, 1 / rate)
    band = (hz >= _BAND_HZ[0]) & (hz <= _BAND_HZ[1])
    hz, power = hz[band], spectra[:, band] + _NOTHING / np.count_nonzero(band)
    energy = power.sum(axis=1)
    level, loudest = energy.mean(), energy.max()
    whole = power.sum(axis=0)
    magnitude = np.sqrt(power / energy[:, None])
    alike = np.sum(magnitude[_LAG:] * magnitude[:-_LAG], axis=1)
    both = np.minimum(energy[_LAG:], energy[:-_LAG])
    first, last = _BEFORE
    before = np.lib.stride_tricks.sliding_window_view(energy[:-last], first - last).mean(axis=1)
    end = round(2 * _END_S / _FRAME_S)
    return SoundFeatures(
        level_db=_db(level),
        crest_db=_db(loudest / level),
        centroid_hz=float(hz @ whole / whole.sum()),
        rolloff_hz=float(hz[np.searchsorted(np.cumsum(whole), _ROLL_OFF * whole.sum())]),
        flatness=float(np.average(np.exp(np.log(power).mean(axis=1)) / power.mean(axis=1), weights=energy)),
        onset_db=_db(np.max(energy[first:] / before[: len(energy) - first])),
        fall_db=_db(loudest / energy[-end:].mean()),
        active=float(np.mean(energy >= _ACTIVE * loudest)),
        steadiness=float(np.average(alike, weights=both)),
    )


def classify(found: SoundFeatures, limits: Thresholds) -> SoundClassName:
    """The class of a stretch of sound with these features."""
    if found.level_db < limits.floor_db:
        return "silence"
    sudden = found.crest_db >= limits.crest_db and found.onset_db >= limits.onset_db
    if sudden and found.fall_db >= limits.fall_db and found.active <= limits.active:
        return "impulsive"
    if found.flatness >= (limits.flatness if found.crest_db < limits.uneven_db else limits.hissing):
        return "broadband"
    lasts = found.active >= limits.lasting
    return "tonal" if lasts or found.steadiness >= limits.steadiness else "voice-like"


def _db(ratio: float) -> float:
    return 10.0 * float(np.log10(ratio))
