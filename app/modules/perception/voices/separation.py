"""Source separation: spatial masks by direction, and the multichannel Wiener filter that predicts the masked sound.

Model: each frame's spectrum x(f) of all microphones belongs to one talker or to the room. x(f) is Gaussian with the
covariance a aᴴ + N for a talker of direction d, a(f) being the steering vector of pure delays, and N for the room, N =
δ Γ + ε I being diffuse sound and the microphones' own noise. The likelihood of each, independent of loudness (Tyler
1987's angular Gaussian; Ito, Araki and Nakatani 2016)::

    p_k = c_k / (1 - c_k |aᴴ N⁻¹ x|² / xᴴ N⁻¹ x)^M      c_k = 1 / (1 + aᴴ N⁻¹ a)      γ_k = p_k / (ν + Σ_j p_j)

γ_k, the share of source k, is its mask. The filter w_k(f) that predicts the masked sound of one microphone from all of
them, in the least squares of the last seconds, is the multichannel Wiener filter (Doclo and Moonen 2002)::

    w_k = (E[x xᴴ] + λ I)⁻¹ E[γ_k x x_ref*]        y_k = w_kᴴ x · max(floor, |w_kᴴ x|² / Σ_j |w_jᴴ x|²)

The filter does not need exact steering: echoes of a voice help to predict it, whereas a beamformer treats them as
noise; and the voice's presence in the covariance does not cancel it, as in a minimum variance beamformer. The result is
the voice at that microphone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import SPEED_OF_SOUND, arrivals

Spectra = NDArray[np.complex64]
#: Half of the least output rate (Hz).
OUTPUT_RATE = 16_000


@dataclass(frozen=True, slots=True)
class SeparatorSettings:
    """Parameters of the separation.

    ``frame``: output samples per transform, every ``frame / 2``; ``frames``: transforms per block. Frequencies in Hz.
    ``memory_s``: time constant of the filters' statistics. ``diffuse`` (δ), ``noise`` (ε), ``room`` (ν): the room's
    part. ``load`` (λ): diagonal loading as a share of the mean power. ``reference``: the predicted microphone.
    ``range_m``: assumed distance of sources.
    """

    frame: int = 1024
    frames: int = 4
    lowest_hz: float = 60.0
    highest_hz: float = 7600.0
    memory_s: float = 1.0
    diffuse: float = 0.5
    noise: float = 0.05
    room: float = 0.5
    load: float = 0.02
    floor: float = 0.1
    reference: int = 0
    range_m: float = 1.8


@dataclass(frozen=True, slots=True, eq=False)
class Separated:
    """One block: column i of ``samples`` (N, K) float32, in [-1, 1) and beyond, is source ``tracks[i]``.

    ``first_sample`` is the number, at the separator's ``output_rate``, of the first of them since the last reset.
    """

    tracks: tuple[int, ...]
    samples: NDArray[np.float32]
    first_sample: int


class Separator:
    """Separates several sources, block by block.

    ``rate`` (Hz, from 16,000 up) of the microphones; ``output_rate``: an integer fraction of it between 16 and 32 kHz;
    ``step``: samples per call of :meth:`process`.
    """

    def __init__(self, array: MicrophoneArray, rate: int, settings: SeparatorSettings = SeparatorSettings()) -> None:
        if rate < OUTPUT_RATE:
            raise ValueError(f"separation needs sound of at least {OUTPUT_RATE} samples a second, not {rate}")
        self.array = array
        self.settings = settings
        self.ratio = rate // OUTPUT_RATE
        self.output_rate = rate // self.ratio
        self._hop = settings.frame // 2
        self.step = self._hop * self.ratio * settings.frames
        self._window_in = _root_hann(settings.frame * self.ratio)
        self._window_out = _root_hann(settings.frame) / np.float32(self.ratio)
        frequencies = np.fft.rfftfreq(settings.frame, 1 / self.output_rate)
        band = np.flatnonzero((frequencies >= settings.lowest_hz) & (frequencies <= settings.highest_hz))
        self._band = slice(int(band[0]), int(band[-1]) + 1)
        self._frequencies = frequencies[self._band]
        self._room = np.linalg.inv(self._room_covariance()).astype(np.complex64)
        self._directions: dict[int, tuple[NDArray[np.float64], Spectra, NDArray[np.float32]]] = {}
        self.reset()

    def reset(self) -> None:
        """Discard the past: the next samples do not follow the last."""
        microphones, bins = len(self.array), len(self._frequencies)
        hop = self._hop * self.ratio
        #: The last hop of the block before, and the block.
        self._sound = np.zeros((microphones, hop + self.step), np.float32)
        self._frames = np.zeros((microphones, self.settings.frames, 2 * hop), np.float32)
        self._covariance = np.zeros((bins, microphones, microphones), np.complex64)
        self._predicted: dict[int, Spectra] = {}
        self._tails: dict[int, NDArray[np.float32]] = {}
        self._next = -self._hop

    def process(
        self, samples: NDArray[np.float32], sources: Sequence[tuple[int, NDArray[np.float64]]], outputs: int = 2
    ) -> Separated:
        """Separate the next ``step`` samples (step, M), in [-1, 1), columns as the array's positions.

        ``sources``: known tracks with their directions (3,) in the array's axes, by priority; the first ``outputs`` are
        separated. The output ends half a frame before the input. A source that is no longer among them fades out.
        """
        if samples.shape != (self.step, len(self.array)):
            raise ValueError(f"samples are ({self.step}, {len(self.array)}), not {samples.shape}")
        spectra = self._transform(samples)
        tracks = tuple(track for track, _ in sources)
        wanted = tracks[:outputs]
        covariance = self._learn(spectra)
        shares = self._shares(spectra, sources) if tracks else None
        self._predicted = {track: self._predicted[track] for track in wanted if track in self._predicted}
        if shares is None:
            return self._overlap((), np.zeros((0, self.settings.frames, len(self._frequencies)), np.complex64))
        self._predict(spectra, shares, wanted)
        weights = solved(covariance, np.stack([self._predicted[track] for track in wanted], axis=-1))
        voices = np.asarray(weights.conj().transpose(0, 2, 1) @ spectra, np.complex64)
        if len(wanted) > 1:
            powers = voices.real**2 + voices.imag**2
            gains = powers / (powers.sum(axis=1, keepdims=True) + np.float32(1e-20))
            voices *= np.maximum(gains, np.float32(self.settings.floor))
        return self._overlap(wanted, voices.transpose(1, 2, 0))

    # --- models of room and sources ---

    def _room_covariance(self) -> NDArray[np.float64]:
        offsets = self.array.offsets
        apart = np.linalg.norm(offsets[:, None] - offsets, axis=2)
        # Coherence of diffuse sound: sin(kd) / kd.
        diffuse = np.sinc(2 * self._frequencies[:, None, None] * apart / SPEED_OF_SOUND)
        return np.asarray(self.settings.diffuse * diffuse + self.settings.noise * np.eye(len(offsets)))

    def _steer(self, track: int, direction: NDArray[np.float64]) -> tuple[Spectra, NDArray[np.float32]]:
        """N⁻¹ a (F, M) and c (F,) of a direction; kept while it moves by less than half a degree."""
        known = self._directions.get(track)
        if known is None or known[0] @ direction < np.cos(np.radians(0.5)):
            delays = arrivals(self.array.offsets, direction[None], self.settings.range_m, self.array.body_m)[0]
            steering = np.exp(-2j * np.pi * self._frequencies[:, None] * delays).astype(np.complex64)
            seen = (self._room @ steering[:, :, None])[:, :, 0]
            strength = (steering.conj() * seen).sum(axis=1).real
            known = (direction, seen, (1 / (1 + strength)).astype(np.float32))
            self._directions[track] = known
        return known[1], known[2]

    def _shares(self, spectra: Spectra, sources: Sequence[tuple[int, NDArray[np.float64]]]) -> NDArray[np.float32]:
        """γ (F, K, T) of all sources."""
        steered = {track: self._steer(track, direction) for track, direction in sources}
        self._directions = {track: self._directions[track] for track in steered}
        seen = np.stack([pair[0] for pair in steered.values()], axis=1)
        strengths = np.stack([pair[1] for pair in steered.values()], axis=1)[:, :, None]
        whole = (spectra.conj() * (self._room @ spectra)).sum(axis=1, keepdims=True).real + np.float32(1e-20)
        along = seen.conj() @ spectra
        rest = 1 - strengths * (along.real**2 + along.imag**2) / whole
        likelihoods = strengths * np.exp(-len(self.array) * np.log(np.maximum(rest, np.float32(1e-3))))
        return np.asarray(likelihoods / (np.float32(self.settings.room) + likelihoods.sum(axis=1, keepdims=True)))

    # --- statistics of the filters ---

    @property
    def _keep(self) -> np.float32:
        block_s = self.settings.frames * self._hop / self.output_rate
        return np.float32(np.exp(-block_s / self.settings.memory_s))

    def _learn(self, spectra: Spectra) -> Spectra:
        """E[x xᴴ] + λ I, this block included."""
        self._covariance = self._keep * self._covariance + spectra @ spectra.conj().transpose(0, 2, 1)
        microphones = len(self.array)
        power = np.trace(self._covariance, axis1=1, axis2=2).real / microphones
        load = (self.settings.load * power + np.float32(1e-9))[:, None, None] * np.eye(microphones, dtype=np.float32)
        return np.asarray(self._covariance + load, np.complex64)

    def _predict(self, spectra: Spectra, shares: NDArray[np.float32], wanted: tuple[int, ...]) -> None:
        """E[γ x x_ref*] of the sources wanted, this block included."""
        reference = spectra[:, self.settings.reference].conj()
        masked = shares[:, : len(wanted)] * reference[:, None]
        new = spectra @ masked.transpose(0, 2, 1)
        for index, track in enumerate(wanted):
            before = self._predicted.get(track)
            self._predicted[track] = new[:, :, index] if before is None else self._keep * before + new[:, :, index]

    # --- spectra and back ---

    def _transform(self, samples: NDArray[np.float32]) -> Spectra:
        """Spectra (F, M, T) of the block's frames."""
        # In preallocated arrays: at their size, allocation costs as much as the transform.
        hop, sound = self._hop * self.ratio, self._sound
        sound[:, :hop] = sound[:, -hop:]
        sound[:, hop:] = samples.T
        frames = np.lib.stride_tricks.sliding_window_view(sound, 2 * hop, axis=1)[:, ::hop]
        np.multiply(frames, self._window_in, out=self._frames)
        spectra = fft.rfft(self._frames, axis=-1, overwrite_x=True)[..., self._band]
        return np.ascontiguousarray(spectra.transpose(2, 0, 1), np.complex64)

    def _overlap(self, tracks: tuple[int, ...], voices: Spectra) -> Separated:
        """Sound (N, K) of the spectra ``voices`` (K, T, F), and of sources that fade out, by overlap-add."""
        settings, hop = self.settings, self._hop
        full = np.zeros((len(tracks), settings.frames, settings.frame // 2 + 1), np.complex64)
        full[..., self._band] = voices
        frames = fft.irfft(full, axis=-1).astype(np.float32, copy=False) * self._window_out
        leaving = tuple(track for track in self._tails if track not in tracks)
        sound = np.zeros(((settings.frames + 1) * hop, len(tracks) + len(leaving)), np.float32)
        for column, track in enumerate((*tracks, *leaving)):
            if track in self._tails:
                sound[:hop, column] = self._tails[track]
        for number in range(settings.frames):
            sound[number * hop : number * hop + settings.frame, : len(tracks)] += frames[:, number].T
        self._tails = {track: sound[-hop:, column].copy() for column, track in enumerate(tracks)}
        first, self._next = self._next, self._next + settings.frames * hop
        # There is no sound before the first sample.
        missing = max(0, -first)
        return Separated((*tracks, *leaving), sound[missing:-hop], first + missing)


def solved(matrices: Spectra, sides: Spectra) -> Spectra:
    """x (F, M, K) of ``matrices`` (F, M, M) x = ``sides`` (F, M, K), for Hermitian positive definite matrices.

    Gauss elimination of all matrices at once: for many small systems a third of the time of one after another. Without
    pivoting, since the matrices are definite.
    """
    size = matrices.shape[1]
    rows = np.concatenate([matrices, sides], axis=2).transpose(1, 2, 0).copy()
    for k in range(size):
        rows[k, k + 1 :] /= rows[k, k].real
        rows[k + 1 :, k + 1 :] -= rows[k + 1 :, k, None] * rows[k, None, k + 1 :]
    found = rows[:, size:]
    for k in range(size - 2, -1, -1):
        found[k] -= (rows[k, k + 1 : size, None] * found[k + 1 :]).sum(axis=0)
    return found.transpose(2, 0, 1)


def _root_hann(size: int) -> NDArray[np.float32]:
    """Square root of a periodic Hann window: its squares at hops of half its length add up to one."""
    return np.sqrt(np.hanning(size + 1)[:-1]).astype(np.float32)
