"""Sound source localization by the microphones' cross-correlations.

Steered response power with phase transform (DiBiase 2000; Valin et al. 2004), with five changes for several
simultaneous and weak talkers:

* frequencies are weighted at each instant by their level above background and reverberation (:mod:`spectral_mask`), and
  then normalized over the time of the mean: a frequency that a weak talker dominates for a moment counts as much as one
  that a strong talker always dominates;
* sources are searched in a mean over half a second, and followed in a mean over a tenth of that;
* the cross spectra of the background, as of the robot's own fans, are learnt and subtracted;
* a found source is subtracted frequency by frequency, by the microphones' agreement in its direction, before the next
  search; erasing the lags around it would erase others too;
* wave fronts are spheres from a talker's usual distance, not planes: at 0.5 m from a 0.5 m array the difference is a
  quarter of a period and more at speech frequencies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.onsets import Onsets
from app.modules.perception.voices.spectral_mask import SpectralMask
from app.modules.perception.voices.steered_response import SteeredResponse

_SMALL = 1e-12
#: Directions closer than this (cosine of 4 degrees) are one.
_SAME = float(np.cos(np.radians(4.0)))
#: A direction found within this (cosine of 8 degrees) of an expected one is the same source.
_NEAR = float(np.cos(np.radians(8.0)))
#: A weaker peak within this (cosine of 20 degrees, a lobe's width), below this share, is a side lobe.
_LOBE, _LOBE_SHARE = float(np.cos(np.radians(20.0))), 0.6
#: Least value of the grid point nearest to a maximum, as a share of it.
_GRID_SHARE = 0.35
#: Greatest delay of a first reflection that frames and beams can resolve (s).
_REFLECTION_S = (0.0008, 0.012)
#: Rotation of the array (rad, time constant) over which a mean is too blurred for the search.
_SMEARED = float(np.radians(6.0))
#: Share of frequencies at background level for which only the background sounds.
_ALONE = 0.9
#: Period (steps) of the test whether the background has a direction.
_JUDGE_STEPS = 12
#: Observation time (s) after which half of a learnt background is subtracted.
_UNSURE_S = 0.2


@dataclass(frozen=True, slots=True)
class LocalizerSettings:
    """Parameters of the localization.

    ``frame``: samples per transform, every ``frame / 2``; ``frames``: transforms per step. Every ``search_every`` steps
    the sphere is searched for at most ``sources`` in the mean over ``search_memory_s`` (time constant); in all other
    steps found and expected directions are followed in the mean over ``follow_memory_s``. ``lowest_hz``,
    ``highest_hz``: used band (Hz). ``points``: directions on the whole sphere, of which those above ``lowest_deg`` are
    searched. ``range_m``: assumed distance of sources. ``weight_offset``: added to the summed weight of a frequency
    before the division, so that rarely weighted ones count little. ``tail``, ``tail_s``, ``floor``: see
    :class:`SpectralMask`. ``still_s``: time constant of the learnt background. ``least_power``, ``least_share``: least
    power of a peak, and least share of the strongest.
    """

    frame: int = 1024
    frames: int = 4
    search_every: int = 2
    search_memory_s: float = 0.4
    follow_memory_s: float = 0.06
    sources: int = 4
    lowest_hz: float = 200.0
    highest_hz: float = 7000.0
    points: int = 2400
    lowest_deg: float = -20.0
    range_m: float = 1.8
    weight_offset: float = 0.05
    tail: float = 0.45
    tail_s: float = 0.085
    floor: float = 0.01
    still_s: float = 4.0
    least_power: float = 0.02
    least_share: float = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Peaks:
    """Directions of sound in one step, strongest first.

    - ``directions`` (K, 3) float64, unit vectors from the array's middle in its axes.
    - ``powers`` (K,) float64 in [0, 1]: agreement of the microphones on it over the last half second; ``recent`` (K,):
      over the last moments.
    - ``echoes`` (K,) >= 0: greatest correlation with a delayed copy of a stronger peak's beam; about 0.3 between two
      talkers, about 0.6 between a talker and a wall reflection; 0 for the strongest.
    - ``steady`` (K, 3): direction over the last half second with the other sources subtracted; more accurate than
      ``directions`` for standing sources, delayed for moving ones; NaN where the search found none.
    - ``onsets`` (K, 4): see ``Onsets.agreement``.
    """

    directions: NDArray[np.float64]
    powers: NDArray[np.float64]
    recent: NDArray[np.float64]
    echoes: NDArray[np.float64]
    steady: NDArray[np.float64]
    onsets: NDArray[np.float64]


NO_PEAKS = Peaks(
    np.zeros((0, 3)),
    np.zeros(0),
    recent=np.zeros(0),
    echoes=np.zeros(0),
    steady=np.zeros((0, 3)),
    onsets=np.zeros((0, 4)),
)


class Localizer:
    """Finds the directions of sounds, step by step; its state is the recent past of the sound.

    ``rate`` (Hz) of the samples; ``step``: samples per call of :meth:`process`; ``hop``: samples between frames.
    ``window`` (frame,): square root of a Hann window, whose squares at hops add up to one. ``spectra`` (F, M, frame / 2
    + 1) complex64: windowed spectra of the last step's frames, for a separator.
    """

    def __init__(self, array: MicrophoneArray, rate: int, settings: LocalizerSettings = LocalizerSettings()) -> None:
        self.array = array
        self.rate = rate
        self.settings = settings
        self.hop = settings.frame // 2
        self.step = self.hop * settings.frames
        self.window = np.sqrt(np.hanning(settings.frame + 1)[:-1]).astype(np.float32)
        self.frequencies = np.fft.rfftfreq(settings.frame, 1 / rate)
        chosen = np.flatnonzero((self.frequencies >= settings.lowest_hz) & (self.frequencies <= settings.highest_hz))
        self._band = slice(int(chosen[0]), int(chosen[-1]) + 1)
        self._response = SteeredResponse(
            array,
            rate,
            self.band,
            points=settings.points,
            lowest_deg=settings.lowest_deg,
            range_m=settings.range_m,
        )
        self._clarity = SpectralMask(len(chosen), self.hop / rate, settings.tail, settings.tail_s, settings.floor)
        self._onsets = Onsets()
        pairs, bins = len(array.first), len(chosen)
        # The robot's own noise does not change with lost samples: never reset.
        self._still = np.zeros((pairs, bins), np.complex64)
        self._still_weight = np.zeros(bins, np.float32)
        self._still_steps = 0
        self._directed = False
        self._unsure_steps = _UNSURE_S * rate / self.step
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next samples do not follow the last."""
        pairs, bins = len(self.array.first), self._band.stop - self._band.start
        self._past = np.zeros((self.hop, len(self.array)), np.float32)
        self.spectra = np.zeros((self.settings.frames, len(self.array), self.hop + 1), np.complex64)
        self._long = np.zeros((pairs, bins), np.complex64)
        self._short = np.zeros((pairs, bins), np.complex64)
        #: Of the means: the weights of all, and the background's share of them.
        self._long_weight = np.zeros((2, bins), np.float32)
        self._short_weight = np.zeros((2, bins), np.float32)
        self._steps = 0
        self._found = NO_PEAKS
        self._clarity.reset()
        self._onsets.reset()

    def process(
        self, samples: NDArray[np.float32], expected: NDArray[np.float64] | None = None, turned: float = 0.0
    ) -> Peaks:
        """Peaks of the next ``step`` samples (step, M), in [-1, 1), columns as the array's positions.

        ``expected`` (E, 3): unit vectors of expected sources, which are followed without waiting for the next search.
        ``turned`` (rad, left positive): rotation of the array about its z since the last step; a rotation shortens the
        search's mean, so that it does not blur.
        """
        if samples.shape != (self.step, len(self.array)):
            raise ValueError(f"samples are ({self.step}, {len(self.array)}), not {samples.shape}")
        self._update_means(samples, abs(turned) / _SMEARED)
        if turned:
            self._found = replace(self._found, directions=_turned(self._found.directions, -turned))
        self._steps += 1
        if self._steps % self.settings.search_every == 0:
            self._found = self._search()
        return self._follow(expected)

    @property
    def band(self) -> NDArray[np.float64]:
        """The frequencies (B,) Hz of :meth:`cross_spectra`."""
        return np.asarray(self.frequencies[self._band], np.float64)

    def clearness(self) -> float:
        """Mean weight of the current frequencies, in [0, 1]: level above background and reverberation."""
        return float(self._short_weight[0].mean())

    def cross_spectra(self) -> NDArray[np.complex64]:
        """Mean cross spectra of the pairs over the last moments (P, B), without the background, each absolute value at
        most about 1."""
        return self._clear(self._short, self._short_weight)

    def _update_means(self, samples: NDArray[np.float32], smeared: float) -> None:
        settings, hop = self.settings, self.hop
        sound = np.concatenate([self._past, samples])
        self._past = sound[-hop:]
        frames = np.stack([sound[k * hop : k * hop + settings.frame].T for k in range(settings.frames)])
        self.spectra = fft.rfft(frames * self.window, axis=-1)
        spectra = self.spectra[:, :, self._band]
        squares = spectra.real**2 + spectra.imag**2
        phases = spectra / (np.sqrt(squares) + np.float32(_SMALL))
        powers = squares.mean(axis=1)
        heard = [(self._clarity.weigh(power), self._clarity.background, self._clarity.quiet) for power in powers]
        weights = np.stack([weight for weight, _, _ in heard])
        self._onsets.update(phases, powers, weights)
        still = np.stack([weight * background for weight, background, _ in heard])
        quiet = float(np.min([alone.mean() for _, _, alone in heard]))
        weighted = phases * weights[:, None, :]
        conjugate = phases.conj()
        cross = np.empty_like(self._long)
        begin = 0
        for microphone in range(len(self.array) - 1):
            end = begin + len(self.array) - 1 - microphone
            np.sum(weighted[:, microphone, None] * conjugate[:, microphone + 1 :], axis=0, out=cross[begin:end])
            begin = end
        sums = np.stack([weights.sum(axis=0), still.sum(axis=0)])
        step_s = self.step / self.rate
        for mean, total, age in (
            (self._long, self._long_weight, step_s / settings.search_memory_s + smeared),
            (self._short, self._short_weight, step_s / settings.follow_memory_s),
        ):
            keep = float(np.exp(-age))
            mean *= np.float32(keep)
            mean += cross * np.float32((1 - keep) / settings.frames)
            total *= np.float32(keep)
            total += sums * np.float32((1 - keep) / settings.frames)
        if self._clarity.settled and quiet > _ALONE:
            self._learn_still(cross, sums[0])

    def _learn_still(self, cross: NDArray[np.complex64], weight: NDArray[np.float32]) -> None:
        """Update the background's cross spectra while only the background sounds, weighted as all sound is."""
        keep = np.float32(np.exp(-self.step / self.rate / self.settings.still_s))
        self._still = self._still * keep + cross
        self._still_weight = self._still_weight * keep + weight
        self._still_steps += 1
        if self._still_steps % _JUDGE_STEPS == 0:
            agreed = self._still / (self._still_weight + np.float32(_SMALL))
            strength = self._response.on_grid(self._response.correlation(agreed)).max() / len(self._still)
            self._directed = bool(strength > self.settings.least_power)

    def _clear(self, mean: NDArray[np.complex64], weights: NDArray[np.float32]) -> NDArray[np.complex64]:
        """The cross spectra (P, B) of a mean without those of the background, normalized by frequency."""
        if not self._directed:
            return np.asarray(mean / (weights[0] + np.float32(self.settings.weight_offset)))
        trust = np.float32(self._still_steps / (self._still_steps + self._unsure_steps))
        still = self._still * (trust * weights[1] / (self._still_weight + np.float32(_SMALL)))
        return np.asarray((mean - still) / (weights[0] + np.float32(self.settings.weight_offset)))

    def _search(self) -> Peaks:
        whole = self._clear(self._long, self._long_weight)
        pairs = np.float32(len(whole))
        cross = whole
        directions: list[NDArray[np.float64]] = []
        powers: list[float] = []
        echoes: list[float] = []
        beams: list[NDArray[np.complex64]] = []
        for number in range(self.settings.sources):
            correlation = self._response.correlation(cross)
            response = self._response.on_grid(correlation)
            best = int(response.argmax())
            least = max(self.settings.least_power, self.settings.least_share * max(powers, default=0.0))
            if response[best] < _GRID_SHARE * least * pairs:
                break
            direction, power = self._response.climb(correlation, self._response.grid[best][None], 1)
            if power[0] < least:
                break
            steering = self._response.steering(direction)[0]
            copies = [
                self._copy(whole, beam, steering) / math.sqrt(stronger * power[0])
                for beam, stronger, other in zip(beams[:2], powers[:2], directions[:2], strict=True)
                if other @ direction[0] < _NEAR
            ]
            directions.append(direction[0])
            powers.append(float(power[0]))
            beams.append(steering)
            echoes.append(max(copies, default=0.0))
            if number + 1 < self.settings.sources:
                turned = steering[self.array.first] * steering[self.array.second].conj()
                share = (cross * turned).real.sum(axis=0) / pairs
                share = np.maximum(0, np.convolve(share, np.full(5, 0.2, np.float32), "same"))
                cross = cross - share * turned.conj()
        if not directions:
            return NO_PEAKS
        places = np.array(directions)
        nothing = np.zeros(len(powers))
        return Peaks(
            places,
            np.array(powers),
            recent=nothing,
            echoes=np.array(echoes),
            steady=places,
            onsets=np.zeros((len(powers), 4)),
        )

    def _copy(self, cross: NDArray[np.complex64], beam: NDArray[np.complex64], later: NDArray[np.complex64]) -> float:
        """The greatest correlation of the second of two beams (M, B) with the first at any delay of a first reflection.

        Computed from cross spectra (P, B) alone: those of two beams are linear in the microphones'.
        """
        first, second = self.array.first, self.array.second
        product = (cross * (beam[first] * later[second].conj())).sum(axis=0)
        product += (cross.conj() * (beam[second] * later[first].conj())).sum(axis=0)
        spectrum = np.zeros(self.settings.frame, np.complex64)
        spectrum[self._band] = product
        # A delay of n samples turns frequency k by exp(2j pi k n / frame): the forward transform finds n.
        sizes = np.abs(fft.fft(spectrum))
        pairs, bins = cross.shape
        begin, end = (round(seconds * self.rate) for seconds in _REFLECTION_S)
        return float(sizes[begin:end].max() / (2 * pairs * bins))

    def _follow(self, expected: NDArray[np.float64] | None) -> Peaks:
        found = self._found
        starts, powers, echoes, steady = found.directions, found.powers, found.echoes, found.steady
        if expected is not None and len(expected):
            meant = np.full(len(expected), -1)
            if len(starts):
                nearness = expected @ starts.T
                meant = np.where(nearness.max(axis=1) > _NEAR, nearness.argmax(axis=1), -1)
            known = meant >= 0
            # An expected direction is the better start where it and the search mean the same source.
            taken = set(meant.tolist())
            new = [k for k in range(len(starts)) if k not in taken]
            of_expected = np.where(known, np.append(powers, 0)[meant], 0)
            powers = np.concatenate([of_expected, powers[new]])
            echoes = np.concatenate([np.where(known, np.append(echoes, 0)[meant], 0), echoes[new]])
            steady = np.concatenate([np.append(steady, [[np.nan] * 3], axis=0)[meant], steady[new]])
            starts = np.concatenate([expected, starts[new]])
        if not len(starts):
            return NO_PEAKS
        correlation = self._response.correlation(self.cross_spectra())
        directions, recent = self._response.climb(correlation, starts, 1)
        nearness = directions @ directions.T
        chosen: list[int] = []
        for k in range(len(directions)):
            if not any(nearness[k, other] > _SAME for other in chosen):
                chosen.append(k)
        chosen.sort(key=lambda k: -powers[k])
        # Side lobes of a strong source rise and fall with it.
        loud = recent.tolist()
        clear = [
            not any(loud[k] < _LOBE_SHARE * loud[other] and nearness[k, other] > _LOBE for other in chosen)
            for k in chosen
        ]
        recent[chosen] = np.where(clear, recent[chosen], 0)
        directions = directions[chosen]
        onsets = self._onsets.agreement(self._response.steering(directions))
        return Peaks(
            directions,
            powers[chosen],
            recent=recent[chosen],
            echoes=echoes[chosen],
            steady=steady[chosen],
            onsets=onsets,
        )


def _turned(directions: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """``directions`` (K, 3) turned left by ``angle`` (rad) about z."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(directions @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
