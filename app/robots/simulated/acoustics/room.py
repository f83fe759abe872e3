"""A shoebox room: its image sources, its late reverberation, and the impulse responses of microphones in it.

Early sound is exact: the images of J. B. Allen and D. A. Berkley, "Image method for efficiently simulating small-room
acoustics", JASA 65, 1979, each through the torso's response for its own direction. Late sound is statistical: waves
from all directions, with the density of the images, decaying with the configured reverberation time; its coherence
between microphones is that of a diffuse field, torso included. Reflections are specular; frequency enters in two bands
(``bands.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.bands import AIR_DB_PER_M, fast_length, join, low_pass
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS, TAPS, BaffledMicrophones

Vector = tuple[float, float, float]
Impulses = NDArray[np.float32]
_DIRECTIONS = 64
_FADE_S = 0.004


@dataclass(frozen=True, slots=True)
class Shoebox:
    """A room with its lower corner at ``corner`` (m, world), ``size`` (m), and ``rt60_s`` of the low and high band."""

    corner: Vector
    size: Vector
    rt60_s: tuple[float, float]

    @property
    def volume_m3(self) -> float:
        return math.prod(self.size)

    @property
    def surface_m2(self) -> float:
        """Area of all six walls (m^2)."""
        x, y, z = self.size
        return 2 * (x * y + y * z + z * x)

    @property
    def reflection(self) -> NDArray[np.float64]:
        """Amplitude reflected by a wall, by band: by Eyring's formula for ``rt60_s``, less the absorption of air."""
        air = np.log(10) / 10 * AIR_DB_PER_M * SPEED_OF_SOUND_MPS  # of energy, 1/s
        decay = np.maximum(6 * math.log(10) / np.array(self.rt60_s) - air, 0.5)
        hits_per_s = SPEED_OF_SOUND_MPS * self.surface_m2 / (4 * self.volume_m3)
        reflected: NDArray[np.float64] = np.exp(-0.5 * decay / hits_per_s)
        return reflected

    def contains(self, p_W: ArrayLike, margin_m: float = 0.0) -> bool:
        """Whether the point (m, world) is inside, or not farther than ``margin_m`` outside."""
        within = np.asarray(p_W) - np.array(self.corner)
        return bool(np.all(within >= -margin_m) and np.all(within <= np.array(self.size) + margin_m))

    def clamp(self, p_W: ArrayLike, margin_m: float = 0.02) -> NDArray[np.float64]:
        """The point (..., 3) m at or nearest to the given one that is inside by ``margin_m``."""
        low = np.array(self.corner)
        return np.clip(np.asarray(p_W, dtype=np.float64), low + margin_m, low + np.array(self.size) - margin_m)

    def late_power(self, after_s: ArrayLike) -> NDArray[np.float64]:
        """Energy of late sound per second, ``after_s`` (n,) s after an impulse of 1 at 1 m, by band: (n, 2).

        Images fill the spherical shell with constant density; each contributes the inverse square of its path's length,
        less the walls' absorption.
        """
        after = np.atleast_1d(np.asarray(after_s, dtype=np.float64))[:, None]
        density = 4 * math.pi * SPEED_OF_SOUND_MPS / self.volume_m3
        power: NDArray[np.float64] = density * np.exp(-6 * math.log(10) * after / np.array(self.rt60_s))
        return power


@dataclass(frozen=True, slots=True, eq=False)
class Images:
    """Image sources, nearest first: ``p_W`` (K, 3) m world, ``gains`` (K, 2) amplitude at 1 m by band.

    ``departures`` (K, 3) are unit vectors along which their sound leaves the true source.
    """

    p_W: NDArray[np.float64]
    gains: NDArray[np.float64]
    departures: NDArray[np.float64]
    distances: NDArray[np.float64]


@lru_cache(maxsize=64)
def _lattice(size: Vector, reach_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Signs and shifts (K, 3) with ``image = sign * source + shift`` in the room's frame, and reflections (K,)."""
    axes = []
    for length in size:
        n = math.ceil(reach_m / (2 * length)) + 1
        r = np.arange(-n, n + 1)
        # An even image has |2 r| reflections on this axis, a mirrored one |2 r - 1|
        signs = np.concatenate([np.ones(r.size), -np.ones(r.size)])
        shifts = np.concatenate([2 * length * r, 2 * length * r])
        hits = np.concatenate([np.abs(2 * r), np.abs(2 * r - 1)])
        axes.append((signs, shifts, hits))
    grids = [np.stack(np.meshgrid(*parts, indexing="ij"), -1).reshape(-1, 3) for parts in zip(*axes, strict=True)]
    signs, shifts, hits = grids
    # Least distance of the image of any source to any listener in the room
    gap = np.maximum(np.abs(shifts) - np.where(signs > 0, 1.0, 2.0) * np.array(size), 0.0)
    keep = np.linalg.norm(gap, axis=1) <= reach_m
    return signs[keep], shifts[keep], hits[keep].sum(1).astype(np.int64)


def images(room: Shoebox, p_WS: ArrayLike, p_WA: ArrayLike, reach_m: float) -> Images:
    """Every image of a source at ``p_WS`` within ``reach_m`` of ``p_WA`` (m, world), the source itself first."""
    corner = np.array(room.corner)
    source = room.clamp(p_WS) - corner
    listener = np.asarray(p_WA, dtype=np.float64) - corner
    signs, shifts, hits = _lattice(room.size, math.ceil(reach_m / 2.0) * 2.0)
    places = signs * source + shifts
    ways = places - listener
    distances = np.linalg.norm(ways, axis=1)
    chosen = np.flatnonzero((distances <= reach_m) | (hits == 0) & np.all(shifts == 0, axis=1))
    chosen = chosen[np.lexsort((distances[chosen], hits[chosen] > 0))]
    distances = distances[chosen]
    gains = room.reflection ** hits[chosen, None] * 10 ** (-AIR_DB_PER_M * distances[:, None] / 20)
    departures = -signs[chosen] * ways[chosen] / np.maximum(distances, 1e-9)[:, None]
    return Images(places[chosen] + corner, gains, departures, distances)


def mouth(departures: NDArray[np.float64], looks: ArrayLike) -> NDArray[np.float64]:
    """Directivity of a mouth with direction ``looks`` (3,) (unit vector) along ``departures`` (K, 3): (K, 2) by band.

    1 in front; behind, 4 dB less low and 14 dB less high, a smooth fit to measured talkers (W. T. Chu and A. C. C.
    Warnock, "Detailed directivity of sound fields around human talkers", NRC Canada IRC-RR-104, 2002).
    """
    cos = (departures @ np.asarray(looks, dtype=np.float64))[:, None]
    front: NDArray[np.float64] = MOUTH_FRONT + (1 - MOUTH_FRONT) * cos
    return front


MOUTH_FRONT = np.array([0.815, 0.6])
#: Root mean square of :func:`mouth` over all directions, by band: excitation of a room's reverberation by a mouth.
MOUTH_MEAN = np.sqrt(MOUTH_FRONT**2 + (1 - MOUTH_FRONT) ** 2 / 3)


def early(
    microphones: BaffledMicrophones,
    X_WA: Pose3,
    found: Images,
    length: int,
    start_s: float,
    looks: ArrayLike | None = None,
    taps: int = TAPS,
) -> Impulses:
    """The microphones' responses (M, length) to images: ``X_WA`` is the pose of their middle; sample 0 at ``start_s``.

    ``looks``: the unit vector along which a talker's mouth points; None for an omnidirectional source. ``taps``
    shortens the torso's response to all images but the source itself.
    """
    gains = found.gains if looks is None else found.gains * mouth(found.departures, looks)
    p_AS = (found.p_W - X_WA.translation) @ X_WA.rotation
    bands = microphones.impulses(p_AS[:1], gains[:1], length, start_s)
    bands += microphones.impulses(p_AS[1:], gains[1:], length, start_s, taps)
    return join(bands[0], bands[1], microphones.rate)


def diffuse_noise(microphones: BaffledMicrophones, length: int, seed: int) -> NDArray[np.float32]:
    """Diffuse white noise of variance 1 at the microphones: (2, M, length), low and high band. Independent plane waves
    from 64 evenly spread directions. Cyclic where ``length`` is a power of two.
    """
    rng = np.random.default_rng(seed)
    number = np.arange(_DIRECTIONS) + 0.5
    up = 1 - 2 * number / _DIRECTIONS
    round_ = math.pi * (1 + math.sqrt(5)) * number
    flat = np.sqrt(1 - up**2)
    directions = np.stack([flat * np.cos(round_), flat * np.sin(round_), up], axis=1)
    far_m = 100.0
    start_s = (far_m - 0.5) / SPEED_OF_SOUND_MPS
    size = fast_length(max(length, 2 * TAPS))
    spectrum = np.zeros((microphones.p_AM.shape[0], size // 2 + 1), dtype=np.complex128)
    for direction in directions:
        response = microphones.impulses(
            far_m * direction[None], np.full((1, 1), far_m / math.sqrt(_DIRECTIONS)), 2 * TAPS, start_s
        )[0]
        spectrum += np.fft.rfft(rng.standard_normal(size)) * np.fft.rfft(response, size)
    # The low band's filter in the frequency domain, so that the noise stays cyclic
    low = spectrum * np.fft.rfft(low_pass(microphones.rate), size)
    return np.fft.irfft(np.stack([low, spectrum - low]), size).astype(np.float32)[..., :length]


def late(room: Shoebox, noise: NDArray[np.float32], length: int, rate: int, after_s: float) -> Impulses:
    """Late reverberation (M, length) whose sample 0 comes ``after_s`` after the impulse left; it rises over 4 ms.

    ``noise`` (2, M, at least length) is that of :func:`diffuse_noise`.
    """
    times = after_s + np.arange(length) / rate
    envelope = np.sqrt(room.late_power(times) / rate).astype(np.float32)
    rise = max(1, round(_FADE_S * rate))
    envelope[:rise] *= np.sin(0.5 * math.pi * (np.arange(rise)[:length, None] + 0.5) / rise)
    tail: Impulses = np.einsum("nb,bmn->mn", envelope, noise[..., :length], optimize=True)
    return tail


def response(
    room: Shoebox | None,
    p_WS: ArrayLike,
    X_WA: Pose3,
    microphones: BaffledMicrophones,
    seconds: float | None = None,
    early_s: float = 0.08,
    looks: ArrayLike | None = None,
    seed: int = 1,
) -> Impulses:
    """Impulse responses (M, taps) float32 of ``microphones`` with their middle at ``X_WA`` to a source at ``p_WS``.

    An impulse of amplitude 1 leaves the source at sample 0; amplitudes are those at 1 m. Images to ``early_s`` after
    the direct sound, then diffuse reverberation (drawn from ``seed``) to ``seconds`` (default: 1.1 times the RT60).
    ``room`` None is outdoors. ``looks`` makes the source a talker's mouth pointing along that unit vector.
    """
    rate = microphones.rate
    direct_m = float(np.linalg.norm(np.asarray(p_WS) - X_WA.translation))
    if room is None:
        length = round((seconds or 0.0) * rate) or round(direct_m / SPEED_OF_SOUND_MPS * rate) + 2 * TAPS
        alone = Images(
            np.atleast_2d(np.asarray(p_WS, dtype=np.float64)),
            10 ** (-AIR_DB_PER_M[None] * direct_m / 20),
            np.atleast_2d(X_WA.translation - np.asarray(p_WS)) / max(direct_m, 1e-9),
            np.array([direct_m]),
        )
        return early(microphones, X_WA, found=alone, length=length, start_s=0.0, looks=looks)
    length = round((seconds if seconds is not None else 1.1 * max(room.rt60_s)) * rate)
    mixed_s = direct_m / SPEED_OF_SOUND_MPS + early_s
    mixed = round(mixed_s * rate)
    reach_m = mixed_s * SPEED_OF_SOUND_MPS
    impulses = early(
        microphones, X_WA, found=images(room, p_WS, X_WA.translation, reach_m), length=length, start_s=0.0, looks=looks
    )
    # Early sound fades out as late sound fades in, so that the sum is even
    fade = max(1, round(_FADE_S * rate))
    impulses[:, mixed : mixed + fade] *= np.cos(0.5 * math.pi * (np.arange(fade) + 0.5) / fade)[
        : max(0, length - mixed)
    ]
    impulses[:, mixed + fade :] = 0
    if length > mixed:
        noise = diffuse_noise(microphones, length - mixed, seed)
        tail = late(room, noise if looks is None else noise * MOUTH_MEAN[:, None, None], length - mixed, rate, mixed_s)
        impulses[:, mixed:] += tail
    return impulses
