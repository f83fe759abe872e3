"""Loud noises in one microphone's sound: the thesis's rule (4.2), made robust; no event loop, constant work per frame.

The thesis calls a frame of 512 samples a loud noise where its energy is more than 20 times the moving mean of the last
200 frames. Ours keeps that and adds to it::

    e = mean square of the frame from 300 Hz to 6 kHz          b = mean of min(e', CLIP max(b', floor / ratio))
    loud:  e > max(floor, ratio b, CREST q)                        over the last 200 frames (e', b': as they were)

- *Band.* Below 300 Hz lie hum, footfalls, the thud of a door and of a microphone that is switched on, above 6 kHz
  little of a clap or a voice.
- *Robust background b.* A frame counts at most ``CLIP`` times the background of its time: one clap hardly changes it,
  while a lasting change of level is followed within seconds, however large.
- *No thud.* A frame with more than ``THUD`` times as much energy outside the band as in it begins no noise, however
  loud.
- *Usual peaks q.* The 98 % quantile of the frames, tracked by steps up and down (stochastic quantile): speech and music
  exceed their own mean often, and these peaks are no events.
- *Attack.* A clap or a call rises steeply: a frame below ``ATTACK`` times the mean of those a moment before begins no
  noise, unless it is ``PLAIN`` times the floor. The louder syllables of speech rise gradually.
- *Floor.* No frame below it is loud, whatever the background; a background below ``floor / ratio`` has no effect.
- *One noise, one event.* A noise begins where a frame is loud and lasts while frames stay above a quarter of that; the
  next can begin only ``hold_off`` frames after its end. There is no detection before a background is known.

Except for the floor, only ratios of energies are compared: the result is independent of gain as long as the background
stays above ``floor / ratio``.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

#: Samples per frame (thesis 4.2).
FRAME = 512
#: Greatest weight of a frame in the background, as a multiple of the background.
CLIP = 4.0
#: Least energy of a loud frame over the usual peaks: 6.5 dB.
CREST = 4.5
#: Greatest whole energy of a noise over its energy in the band; above, it is a thud: 7 dB.
THUD = 5.0
#: Least rise over the mean from 0.15 to 0.03 s before: 12.5 dB.
ATTACK = 18.0
#: Energy over the floor from which no rise is needed: 8 dB.
PLAIN = 6.3
#: A noise lasts while its frames exceed this share of the threshold.
LASTS = 0.25

_HIGH_PASS_HZ = 300.0
_DECIMATED_HZ = 12_000.0
_FULL_SCALE = 32768.0
#: Quantile of the usual peaks, and its step up per frame above it: 0.3 decibels.
_BELOW = 0.98
_UP = 10.0 ** (0.03 * _BELOW)
_DOWN = 10.0 ** (-0.03 * (1.0 - _BELOW))
#: Frames, 0.85 s: longer than a clap and most calls.
_SHORT = 80
#: Frames, about 0.1 s: a longer sound above the usual peaks moves them no further.
_SYLLABLE = 10
#: Number of frames whose mean a noise must exceed, without the last ones, in which a call may rise.
_BEFORE, _RISE = 14, 2
_LONG_AGO = 1 << 30
#: -90 dB: one step of 16 bits. A background below it is silence.
_SILENCE = 1e-9


def decibels(energy: float) -> float:
    """``energy`` (mean square, full scale 1) in dB of full scale; -120 at the least."""
    return 10.0 * float(np.log10(max(energy, 1e-12)))


def high_pass(edge_hz: float, rate_hz: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Numerator and denominator (3,) of Butterworth's second order by the bilinear transform, -3 dB at ``edge_hz``.

    As ``scipy.signal.butter`` makes it, which takes half a second to import.
    """
    k = math.tan(math.pi * edge_hz / rate_hz)
    norm = 1.0 / (1.0 + math.sqrt(2.0) * k + k * k)
    denominator = [1.0, 2.0 * (k * k - 1.0) * norm, (1.0 - math.sqrt(2.0) * k + k * k) * norm]
    return np.array([norm, -2.0 * norm, norm]), np.array(denominator)


class BandEnergy:
    """Energies of the frames of one microphone between 300 Hz and 6 kHz; keeps the filter's state between calls."""

    def __init__(self, rate: int) -> None:
        # A power of two, so that it divides a frame.
        self._step = 1 << max(0, round(math.log2(rate / _DECIMATED_HZ)))
        b, a = high_pass(_HIGH_PASS_HZ, rate / self._step)
        #: State of the filter after a constant input of 1, for which the output is zero.
        self._rest: NDArray[np.float64] = np.array([-b[0], b[2]])
        # The filter over a whole frame is linear in its samples and state: one matrix for both is several times faster
        # than a general filter call.
        self._count = FRAME // self._step
        inputs = np.eye(self._count + 2)
        passed, state = np.empty((self._count, self._count + 2)), inputs[self._count :].copy()
        for row in range(self._count):
            passed[row] = b[0] * inputs[row] + state[0]
            state[0] = b[1] * inputs[row] - a[1] * passed[row] + state[1]
            state[1] = b[2] * inputs[row] - a[2] * passed[row]
        self._filter = np.concatenate([passed, state]).astype(np.float32)
        self._inputs: NDArray[np.float32] = np.zeros(self._count + 2, np.float32)
        self._scale = 1.0 / (self._count * (self._step * _FULL_SCALE) ** 2)
        self._started = False

    def frame(self, samples: NDArray[np.int16]) -> float:
        """Mean square, full scale 1, of one frame ``samples`` (512,) int16, which may be a column of many channels."""
        inputs, count = self._inputs, self._count
        np.add.reduce(samples.reshape(count, self._step), axis=1, dtype=np.float32, out=inputs[:count])
        if not self._started:
            # Initialized to a constant first sample: no step at the beginning.
            inputs[count:] = self._rest * inputs[0]
            self._started = True
        outputs = self._filter @ inputs
        inputs[count:] = outputs[count:]
        passed = outputs[:count]
        return float(passed @ passed) * self._scale


def whole_energy(samples: NDArray[np.int16]) -> float:
    """Mean square, full scale 1, of one frame ``samples`` (512,) int16, whatever its frequencies."""
    exact = samples.astype(np.float64)
    return float(exact @ exact) / (len(exact) * _FULL_SCALE**2)


@dataclass(frozen=True, slots=True)
class LoudnessRule:
    """Thresholds of a loud frame. ``floor_db`` is in dB of full scale, lengths are in frames."""

    ratio: float = 20.0
    floor_db: float = -32.0
    window: int = 200
    history: int = 100
    hold_off: int = 24

    @property
    def floor(self) -> float:
        """The least energy of a loud frame."""
        return float(10.0 ** (self.floor_db / 10.0))

    @classmethod
    def lasting(
        cls, rate: int, ratio: float, floor_db: float, window_s: float, history_s: float, hold_off_s: float
    ) -> LoudnessRule:
        """The rule for sound of ``rate`` samples a second, with its lengths in seconds."""
        frames_per_s = rate / FRAME
        window = max(2, round(window_s * frames_per_s))
        return cls(
            ratio=ratio,
            floor_db=floor_db,
            window=window,
            history=max(1, min(window, round(history_s * frames_per_s))),
            hold_off=max(1, round(hold_off_s * frames_per_s)),
        )


@dataclass(frozen=True, slots=True)
class Onset:
    """Onset of a loud noise: energy as a multiple of the background's, and level of the frame (dB of full scale)."""

    ratio: float
    level_db: float


def onset_of(frame: NDArray[np.int16], energy: float, detector: OnsetDetector) -> Onset | None:
    """Pass the next ``frame`` (512,) int16 with its :class:`BandEnergy` ``energy`` to ``detector``; the onset, if there
    is one."""
    ratio = detector.update(energy, partial(whole_energy, frame))
    return None if ratio is None else Onset(ratio, decibels(whole_energy(frame)))


class OnsetDetector:
    """Detects onsets frame by frame: ``update(energy)`` gives the ratio to the background where a loud noise begins."""

    def __init__(self, rule: LoudnessRule | None = None) -> None:
        self._rule = rule or LoudnessRule()
        self._floor = self._rule.floor
        self._energies = [0.0] * self._rule.window
        self._known = 0
        self._next = 0
        self._sum = 0.0
        self._usual_peaks = 0.0
        self._before: deque[float] = deque([0.0] * _BEFORE, _BEFORE)
        #: Frames since the end of the last noise.
        self._quiet = _LONG_AGO
        #: Frames since the onset of the last noise.
        self._age = _LONG_AGO
        #: Consecutive frames above the usual peaks.
        self._above = 0

    def follow(self, rule: LoudnessRule) -> None:
        """Use ``rule`` from now on; restarts if its window differs."""
        if rule.window != self._rule.window:
            self._energies = [0.0] * rule.window
            self._known = self._next = 0
            self._sum = self._usual_peaks = 0.0
        self._rule, self._floor = rule, rule.floor

    @property
    def background(self) -> float:
        """The background's energy; 0 before the first frame."""
        return self._sum / self._known if self._known else 0.0

    @property
    def threshold(self) -> float | None:
        """The energy above which the next frame is loud; None while the background is not known yet."""
        return self._loud() if self._known >= self._rule.history else None

    def _loud(self) -> float:
        return max(self._floor, self._rule.ratio * max(self.background, _SILENCE), CREST * self._usual_peaks)

    def update(self, energy: float, whole: Callable[[], float] | None = None) -> float | None:
        """Take the energy of the next frame; its ratio to the background if a loud noise begins with it, or None.

        ``whole`` gives the energy of all frequencies and is called only where it decides; None: no frame counts as a
        thud.
        """
        rule = self._rule
        if self._known < rule.history:
            self._remember(energy)
            self._before.append(energy)
            self._usual_peaks = max(self._usual_peaks * (_UP if energy > self._usual_peaks else _DOWN), self.background)
            return None
        background = max(self.background, _SILENCE)
        loud = self._loud()
        under_way = self._quiet < rule.hold_off
        begins = (
            energy > loud
            and not under_way
            and (energy > PLAIN * self._floor or self._sudden(energy))
            and (whole is None or whole() < THUD * energy)
        )
        self._before.append(energy)
        self._age = 0 if begins else self._age + 1
        if energy > LASTS * loud and (begins or under_way):
            self._quiet = 0
        else:
            self._quiet += 1
        self._remember(min(energy, CLIP * max(background, self._floor / rule.ratio)))
        if energy <= self._usual_peaks:
            self._usual_peaks *= _DOWN
            self._above = 0
        else:
            self._above += 1
            # A lasting sound moves it little, and a detected noise not at all: a second clap must remain detectable.
            if self._above <= _SYLLABLE and (self._quiet >= rule.hold_off or self._age > _SHORT):
                self._usual_peaks *= _UP
        # A rising background raises the peaks as well: their own steps are slow.
        self._usual_peaks = max(self._usual_peaks, self.background)
        return energy / background if begins else None

    def _sudden(self, energy: float) -> bool:
        return energy * (_BEFORE - _RISE) > ATTACK * sum(islice(self._before, _BEFORE - _RISE))

    def _remember(self, energy: float) -> None:
        place = self._next
        if self._known < len(self._energies):
            self._known += 1
        self._sum += energy - self._energies[place]
        self._energies[place] = energy
        self._next = (place + 1) % len(self._energies)
        if self._next == 0:
            # Recomputed, so that rounding errors of sums do not accumulate.
            self._sum = sum(self._energies)
