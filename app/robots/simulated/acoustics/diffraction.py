"""Diffraction by the torso: the exact response of a rigid sphere at microphones on its surface, and tables of it.

Phase convention ``exp(+j w t)``, as numpy's FFTs have it: a delay of tau is ``exp(-j w tau)``. Responses are relative
to the free field that the same source would make at the sphere's middle, so they tend to 1 (and the right phase) where
waves are long, and to 2 for a microphone that faces the source where they are short.

Sources: R. O. Duda and W. L. Martens, "Range dependence of the response of a spherical head model", JASA 104, 1998
(equations 1 to 4); plane waves: J. W. Strutt, "On the acoustic shadow of a sphere", 1904.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

SPEED_OF_SOUND_MPS = 343.0
"""At 20 degrees Celsius."""

TAPS, LEAD = 128, 16
"""Length of a tabulated response (samples), and how many of them come before its arrival."""
_FRACTIONS = 32
_ANGLE_STEP_DEG = 2.5
_FREE_M, _NEAREST_M = 0.02, 0.05
_PASS, _STOP = 0.80, 0.98
"""Band, as shares of half the sampling rate, in which responses fade to zero, so that they stay short."""


def sphere_response(
    radius_m: float, cosines: ArrayLike, frequencies_hz: ArrayLike, distance_m: float = math.inf
) -> NDArray[np.complex128]:
    """Pressure on a rigid sphere's surface, relative to the free field at its middle: (angles, frequencies) complex128.

    ``cosines`` (angles,) of the angle between microphone and source seen from the middle, in [-1, 1]; ``distance_m``
    of a point source from the middle, inf for a plane wave. Raises ValueError for a source inside the sphere.
    """
    if distance_m <= radius_m:
        raise ValueError(f"a source {distance_m} m from the middle is inside the sphere of {radius_m} m")
    cos = np.clip(np.atleast_1d(np.asarray(cosines, dtype=np.float64)), -1.0, 1.0)
    k = 2 * math.pi * np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64)) / SPEED_OF_SOUND_MPS
    k = np.maximum(k, 1e-3 / radius_m)  # at 0 Hz the series is 0/0; its limit is reached long before
    ka = k * radius_m
    near = radius_m / distance_m
    # Terms fall off beyond m = ka, and, for a near source, like near**m
    order = math.ceil(float(ka.max()) + 4 * float(ka.max()) ** (1 / 3) + 12)
    if near > 0:
        order = max(order, min(600, math.ceil(math.log(1e-6) / math.log(near))))
    total = np.zeros((cos.size, k.size), dtype=np.complex128)
    x = ka if near == 0 else np.stack([ka, k * distance_m])
    last, this = _first_hankels(x)
    legendre_last, legendre = np.ones_like(cos), cos
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for m in range(order + 1):
            # Here last is h_m, this is h_m+1; upward, both recursions are stable
            at_surface, above = (last, this) if near == 0 else (last[0], this[0])
            slope = m / ka * at_surface - above
            if near == 0:
                # j_m - (j'_m / h'_m) h_m on the surface is -i / (ka^2 h'_m), by the Wronskian
                term = (1j**m) * (-1j) / (ka**2 * slope)
            else:
                term = -last[1] / slope * (distance_m / (k * radius_m**2))
            term = np.where(np.isfinite(term), term, 0.0)
            total += (2 * m + 1) * legendre_last[:, None] * term
            last, this = this, (2 * m + 3) / x * this - last
            legendre_last, legendre = legendre, ((2 * m + 3) * cos * legendre - (m + 1) * legendre_last) / (m + 2)
    if near > 0:
        total *= np.exp(1j * k * distance_m)
    return total


def _first_hankels(x: NDArray[np.float64]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Spherical Hankel functions of the second kind and orders 0 and 1."""
    wave = np.exp(-1j * x) / x
    return 1j * wave, wave * (1j / x - 1)


@dataclass(frozen=True, slots=True, eq=False)
class ResponseTable:
    """Impulse responses with the travel time taken out, by angle and by fraction of a sample.

    ``responses`` (angles, fractions, TAPS) float32: row ``[i, j]`` arrives ``LEAD + j / fractions`` samples after its
    beginning, from an angle of ``i * step`` (rad) to the microphone. A free field has one angle.
    """

    responses: NDArray[np.float32]
    step: float


@lru_cache(maxsize=16)
def response_table(radius_m: float, rate: int) -> ResponseTable:
    """The table of a microphone on a rigid sphere of ``radius_m``; 0 for a microphone in the free field."""
    size = 2 * TAPS
    frequencies = np.fft.rfftfreq(size, 1 / rate)
    share = frequencies / (rate / 2)
    band = np.cos(0.5 * math.pi * np.clip((share - _PASS) / (_STOP - _PASS), 0, 1)) ** 2
    if radius_m == 0:
        angles, spectra = np.zeros(1), np.ones((1, frequencies.size), dtype=np.complex128)
    else:
        angles = np.radians(np.arange(0.0, 180.0 + 1e-6, _ANGLE_STEP_DEG))
        spectra = sphere_response(radius_m, np.cos(angles), frequencies)
        extra = plane_path(radius_m, angles) / SPEED_OF_SOUND_MPS
        spectra *= np.exp(2j * math.pi * np.outer(extra, frequencies))
    delays = (LEAD + np.arange(_FRACTIONS) / _FRACTIONS) / rate
    shifts = np.exp(-2j * math.pi * np.outer(delays, frequencies)) * band
    responses = np.fft.irfft(spectra[:, None, :] * shifts[None], size)[..., :TAPS]
    fade = np.ones(TAPS)
    fade[-16:] = np.cos(0.5 * math.pi * (np.arange(16) + 0.5) / 16) ** 2
    return ResponseTable(np.ascontiguousarray(responses * fade, dtype=np.float32), math.radians(_ANGLE_STEP_DEG))


def plane_path(radius_m: float, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Additional path (m) of a plane wave, relative to the middle, around the sphere to its surface at ``angles``."""
    lit: NDArray[np.float64] = np.where(
        angles <= math.pi / 2, -radius_m * np.cos(angles), radius_m * (angles - math.pi / 2)
    )
    return lit


@dataclass(frozen=True, slots=True, eq=False)
class BaffledMicrophones:
    """Microphones around a middle A, each on a rigid sphere about A through itself, or in the free field.

    ``p_AM`` (M, 3) float64 m in the axes of the body; ``rate`` samples per second; ``shadow`` whether the sphere is
    there. Microphones within 2 cm of A hear a free field anyway.
    """

    p_AM: NDArray[np.float64]
    rate: int
    shadow: bool = True
    _groups: dict[bool, tuple[tuple[NDArray[np.intp], float], ...]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        for near in (False, True):
            free = near or not self.shadow
            radii = [0.0 if free or r < _FREE_M else round(float(r), 3) for r in np.linalg.norm(self.p_AM, axis=1)]
            self._groups[near] = tuple((np.flatnonzero(np.isclose(radii, r)), r) for r in sorted(set(radii)))

    def arrivals(self, p_AS: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lengths (S, M) m of the shortest ways round the torso, and angles (S, M) rad for :func:`response_table`.

        ``p_AS`` (S, 3) m. In the light the angle is that between the microphone's normal and the way to the source;
        beyond the edge of the shadow it grows with the arc that the wave creeps. A source within the sphere (the
        robot's own loudspeaker) is in the free field.
        """
        straight = np.linalg.norm(p_AS[:, None, :] - self.p_AM, axis=2)
        if not self.shadow:
            return straight, np.zeros_like(straight)
        radii = np.linalg.norm(self.p_AM, axis=1)
        distances = np.linalg.norm(p_AS, axis=1)[:, None]
        outside = distances > 1.02 * radii
        safe = np.where(outside, distances, np.inf)
        on_sphere = np.maximum(radii, 1e-9)
        cos = np.clip((p_AS @ self.p_AM.T) / (on_sphere * np.maximum(distances, 1e-9)), -1.0, 1.0)
        edge = np.arccos(np.clip(on_sphere / safe, 0, 1))
        angle = np.arccos(cos)
        beyond = np.maximum(angle - edge, 0.0)
        with np.errstate(invalid="ignore"):
            creeping = np.sqrt(np.maximum(distances**2 - on_sphere**2, 0.0)) + on_sphere * beyond
        shaded = outside & (beyond > 0) & (radii > _FREE_M)
        incidence = np.arccos(np.clip((distances * cos - on_sphere) / np.maximum(straight, 1e-9), -1.0, 1.0))
        # The far pole is fixed, where the paths around both sides meet
        shade_angle = math.pi / 2 * (1 + beyond / np.maximum(math.pi - edge, 1e-9))
        table_angle = np.where(shaded, shade_angle, incidence)
        return np.where(shaded, creeping, straight), np.where(outside, table_angle, 0.0)

    def tables(self, near: bool = False) -> list[tuple[NDArray[np.intp], ResponseTable]]:
        """Microphones (their numbers) that share a table, with it; ``near``: for sources within the sphere."""
        return [(numbers, response_table(radius, self.rate)) for numbers, radius in self._groups[near]]

    def impulses(
        self, p_AS: NDArray[np.float64], gains: NDArray[np.float64], length: int, start_s: float = 0.0, taps: int = TAPS
    ) -> NDArray[np.float32]:
        """Response of the microphones to unit impulses at ``p_AS`` (S, 3) m at time 0: (B, M, length) float32.

        ``gains`` (S, B): amplitudes at 1 m in each of B bands (they fall with the length of the way). Sample 0 is at
        ``start_s`` (s); arrivals are true to 1/64 of a sample; what falls outside is cut off. ``taps`` shortens the
        responses (at least 2 * LEAD).
        """
        bands = gains.shape[1]
        out = np.zeros((bands, self.p_AM.shape[0], length), dtype=np.float32)
        if p_AS.shape[0] == 0:
            return out
        ways, angles = self.arrivals(p_AS)
        within = np.linalg.norm(p_AS, axis=1) <= 1.02 * float(np.linalg.norm(self.p_AM, axis=1).max())
        for near in (False, True) if self.shadow and within.any() else (False,):
            chosen = within if near else ~within if self.shadow else np.ones_like(within)
            if not chosen.any():
                continue
            for microphones, table in self.tables(near):
                self._add(
                    out,
                    microphones,
                    table=table,
                    ways=ways[chosen],
                    angles=angles[chosen],
                    gains=gains[chosen],
                    start_s=start_s,
                    taps=taps,
                )
        return out

    def _add(
        self,
        out: NDArray[np.float32],
        microphones: NDArray[np.intp],
        table: ResponseTable,
        ways: NDArray[np.float64],
        angles: NDArray[np.float64],
        gains: NDArray[np.float64],
        start_s: float,
        taps: int,
    ) -> None:
        ways, angles = ways[:, microphones], angles[:, microphones]
        fractions = table.responses.shape[1]
        ticks = np.rint((ways / SPEED_OF_SOUND_MPS - start_s) * self.rate * fractions).astype(np.int64)
        whole, fraction = np.divmod(ticks, fractions)
        begin = whole - LEAD
        row = np.clip(angles / table.step, 0, table.responses.shape[0] - 1)
        low = np.minimum(row.astype(np.int64), max(table.responses.shape[0] - 2, 0))
        high = np.minimum(low + 1, table.responses.shape[0] - 1)
        share = (row - low).astype(np.float32)[..., None]
        responses = table.responses[low, fraction, :taps] * (1 - share)
        if table.responses.shape[0] > 1:
            responses += table.responses[high, fraction, :taps] * share
        responses /= np.maximum(ways, _NEAREST_M).astype(np.float32)[..., None]
        length = out.shape[2]
        # One long row per band: cut-off samples go to a bin of their own at the end
        place = begin[..., None] + np.arange(taps)
        index = np.where(
            (place >= 0) & (place < length),
            np.arange(microphones.size)[:, None] * length + place,
            microphones.size * length,
        ).ravel()
        size = microphones.size * length + 1
        for band in range(out.shape[0]):
            weights = responses * gains[:, band].astype(np.float32)[:, None, None]
            summed = np.bincount(index, weights.ravel(), size)[:-1]
            out[band, microphones] += summed.reshape(microphones.size, length).astype(np.float32)
