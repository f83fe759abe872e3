"""BSS Eval: how much of a separated sound is its source, how much another's, and how much neither.

Vincent, Gribonval and Fevotte, "Performance measurement in blind audio source separation", IEEE TASLP 14(4), 2006,
version 3 for single-channel references: a source may come back through any filter of ``taps`` taps without loss.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, toeplitz


@dataclass(frozen=True, slots=True)
class Scores:
    """dB, each (K,): of the estimate given to source i, ``order[i]`` being its number."""

    sdr: NDArray[np.float64]
    sir: NDArray[np.float64]
    sar: NDArray[np.float64]
    order: tuple[int, ...]


def bss_eval(references: NDArray[Any], estimates: NDArray[Any], taps: int = 512) -> Scores:
    """Score ``estimates`` (E, N) against the sources ``references`` (K, N), E >= K, in the order with the best SIR."""
    count = len(references)
    length = references.shape[1] + taps - 1
    spectra = np.fft.rfft(references.astype(np.float64), length)
    gram = _gram(spectra, length, taps)
    tables = [_decompose(spectra, gram, estimate.astype(np.float64), length, taps) for estimate in estimates]

    def mean_sir(order: Sequence[int]) -> float:
        return float(np.mean([tables[e][i][1] for i, e in enumerate(order)]))

    order = max(permutations(range(len(estimates)), count), key=mean_sir)
    sdr, sir, sar = np.array([tables[e][i] for i, e in enumerate(order)]).T
    return Scores(sdr, sir, sar, tuple(order))


def _gram(spectra: NDArray[np.complex128], length: int, taps: int) -> NDArray[np.float64]:
    """Inner products of every source at every delay, (K taps, K taps)."""
    count = len(spectra)
    gram = np.empty((count * taps, count * taps))
    for i in range(count):
        for j in range(count):
            lags = np.fft.irfft(spectra[i] * spectra[j].conj(), length)
            # <s_i delayed by a, s_j delayed by b> is the correlation at lag b - a.
            block = toeplitz(np.concatenate((lags[:1], lags[:-taps:-1])), lags[:taps])
            gram[i * taps : (i + 1) * taps, j * taps : (j + 1) * taps] = block
    return gram


def _decompose(
    spectra: NDArray[np.complex128],
    gram: NDArray[np.float64],
    estimate: NDArray[np.float64],
    length: int,
    taps: int,
) -> list[tuple[float, float, float]]:
    """SDR, SIR and SAR (dB) of one estimate, supposing it were each of the sources in turn."""
    count = len(spectra)
    padded = np.fft.rfft(estimate, length)
    products = np.concatenate([np.fft.irfft(padded * s.conj(), length)[:taps] for s in spectra])
    size = np.fft.irfft(padded, length)
    total = float(size @ size)

    def energy_within(block: slice) -> float:
        part, target = gram[block, block], products[block]
        loaded = part + 1e-10 * np.trace(part) / len(part) * np.eye(len(part))
        return float(target @ cho_solve(cho_factor(loaded), target))

    of_all = energy_within(slice(None))
    rows = []
    for i in range(count):
        own = energy_within(slice(i * taps, (i + 1) * taps)) if count > 1 else of_all
        # Projections are nested and orthogonal, so that energies subtract.
        rows.append((_db(own, total - own), _db(own, of_all - own), _db(of_all, total - of_all)))
    return rows


def _db(signal: float, rest: float) -> float:
    return 10 * float(np.log10(max(signal, 1e-30) / max(rest, 1e-30)))
