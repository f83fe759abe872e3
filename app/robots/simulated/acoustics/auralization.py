"""Auralization: sound at the microphones, block by block, through rooms and around the torso, with moving sources and
robot. A sound's travel time is a continuous read position, so a moving source has its Doppler shift without clicks.
Differences between microphones, and the room, are impulse responses, updated with motion and cross-faded over one
block. Reverberation later than ``Auralizer.early_s`` after the direct sound is the room's, one convolution for all
sounds in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.bands import AIR_DB_PER_M, low_pass
from app.robots.simulated.acoustics.convolver import Partitions, Spectra, Tail, finish, transform
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS, TAPS, BaffledMicrophones
from app.robots.simulated.acoustics.dry_sound import DrySound, Samples, ramp, read_between
from app.robots.simulated.acoustics.room import MOUTH_MEAN, Images, Shoebox, diffuse_noise, early, images, late

MARGIN = 64
"""Samples of a kernel before the arrival at the array's middle: some microphones are nearer."""
_JUMP_M = 0.3
_MOVED_M, _TURNED_RAD, _LOOKED = 0.015, math.radians(0.7), math.cos(math.radians(6))
_REFLECTION_TAPS = 48
_LATE_DECAY_DB = 45.0
_LATE_NOISE = 1 << 15


@dataclass(frozen=True, slots=True, eq=False)
class SoundPath:
    """Path of a sound to the listener: a virtual source at ``p_W`` (3,) m in ``room`` (None: outdoors), after
    ``before_m``.

    ``gains`` (2,): attenuation by doors and walls, by band, in addition to the spreading over the whole length;
    ``late``: amplitude of its part in the reverberation of the listener's room, 1 for a source in the room.
    """

    room: Shoebox | None
    p_W: NDArray[np.float64]
    before_m: float = 0.0
    gains: tuple[float, float] = (1.0, 1.0)
    late: float = 1.0


class AcousticSpace(Protocol):
    """Geometry of sources and listener."""

    def way(self, p_WS: NDArray[np.float64], p_WA: NDArray[np.float64]) -> SoundPath:
        """Path of sound from ``p_WS`` to ``p_WA`` (3,) m."""


@dataclass(frozen=True, slots=True)
class OneRoom:
    """A single room, or the outdoors (None)."""

    room: Shoebox | None

    def way(self, p_WS: NDArray[np.float64], p_WA: NDArray[np.float64]) -> SoundPath:
        return SoundPath(
            self.room, p_WS if self.room is None else self.room.clamp(p_WS), late=0.0 if self.room is None else 1.0
        )


@dataclass(frozen=True, slots=True, eq=False)
class Emission:
    """A sound from sample number ``begin`` on, at its place at the block's end.

    ``name`` is unique. ``p_W`` (3,) m; ``looks``: unit vector of a mouth's direction, None for an omnidirectional
    source; ``gain``: of amplitude; ``level``: root mean square at 1 m of its loudest part, before ``gain``.
    """

    name: str
    dry: DrySound
    begin: int
    p_W: NDArray[np.float64]
    gain: float = 1.0
    looks: NDArray[np.float64] | None = None
    level: float = 1.0


class Auralizer:
    """Functional core of the simulated microphones: emissions and pose of each block in, sound of the block out."""

    def __init__(
        self,
        microphones: BaffledMicrophones,
        surroundings: AcousticSpace,
        block: int = 512,
        early_s: float = 0.021,
        late_s: float = 0.6,
        refresh_blocks: int = 8,
        floor: float = 0.0,
        voices: int = 8,
        seed: int = 1,
    ) -> None:
        """``late_s``: the longest reverberation there is; ``floor``: root mean square below which nothing is computed;
        at most ``voices`` sounds are heard at once, the loudest."""
        self.microphones = microphones
        self._surroundings = surroundings
        self._block = block
        rate, outputs = microphones.rate, microphones.p_AM.shape[0]
        self._outputs = outputs
        self._step = max(1, round(early_s * rate / block))
        self.early_s = self._step * block / rate
        fade = 256
        self._early_blocks = -(-(self._step * block + fade + TAPS) // block)
        self._tail = Tail(outputs, block, self._step, max(1, math.ceil(late_s * rate / (self._step * block))))
        self._tail_length = self._tail.count * self._tail.delay
        self._mouths_before: Samples = np.zeros(low_pass(rate).size - 1, dtype=np.float32)
        self._noise: Samples | None = None
        self._seed = seed
        self._room: Shoebox | None = None
        self._tails: dict[Shoebox, Spectra] = {}
        self._refresh = refresh_blocks
        self._floor = floor
        self._most = voices
        self._voices: dict[str, _ActiveSource] = {}
        self.position = 0
        """Number of the next block's first sample."""
        self.kernels = 0
        """Impulse responses computed so far."""

    def skip(self, blocks: int) -> None:
        """Skip ``blocks``: sounds continue unheard, reverberation so far is lost."""
        self.position += blocks * self._block
        self._voices.clear()
        self._tail = Tail(self._outputs, self._block, self._step, self._tail.count)
        self._room = None

    def prepare(self, rooms: Sequence[Shoebox] = ()) -> None:
        """Precompute what the first blocks, or the first in each of ``rooms``, would wait for."""
        self.microphones.tables()
        if self._noise is None:
            # Cyclic: the sound has died away before it repeats
            length = min(1 << (self._tail_length - 1).bit_length(), _LATE_NOISE)
            self._noise = diffuse_noise(self.microphones, length, self._seed)
        for room in rooms:
            if room not in self._tails:
                self._tails[room] = self._late_kernel(room, self._noise)

    def block(self, emissions: Sequence[Emission], X_WA: Pose3) -> Samples:
        """The next block (M, block) float32, full scale 1, with the array's middle at ``X_WA`` at its end."""
        before = np.zeros((self._outputs, self._block + 1), dtype=np.complex64)
        after = np.zeros_like(before)
        faded = False
        to_tail = np.zeros((2, self._block), dtype=np.float32)
        ways = [self._surroundings.way(e.p_W, X_WA.translation) for e in emissions]
        audible = self._audible(emissions, ways, X_WA)
        room: Shoebox | None = None
        named = set()
        for number, (emission, way) in enumerate(zip(emissions, ways, strict=True)):
            named.add(emission.name)
            room = room or way.room
            voice = self._voices.get(emission.name)
            if voice is None:
                if number not in audible:
                    continue
                voice = self._voices[emission.name] = _ActiveSource(self._outputs, self._block, self._early_blocks)
            x = voice.read(
                emission, way, X_WA=X_WA, position=self.position, rate=self.microphones.rate, audible=number in audible
            )
            if voice.silent and not x.any():
                continue
            if voice.stale(way, X_WA, emission.looks, self._refresh):
                self.kernels += 1
                impulses = self._impulses(voice, way, X_WA, emission.looks)
                voice.partitions.set_kernel(transform(impulses, self._block, self._early_blocks))
            voice.partitions.feed(x)
            faded |= voice.partitions.add_to(before, after)
            if way.room is not None and way.late > 0:
                to_tail[0 if emission.looks is None else 1] += voice.late(x, way, self.microphones.rate)
        self._voices = {
            name: v for name, v in self._voices.items() if name in named or not self._fade_out(v, before, after)
        }
        self.position += self._block
        out = finish(before, after, faded)
        if room is not None or self._room is not None:
            self._enter(room)
            out += self._tail.process(to_tail[0] + self._from_mouths(to_tail[1]))
        return out

    def _from_mouths(self, samples: Samples) -> Samples:
        """Excitation of a room's reverberation by mouths, which radiate mostly forward."""
        known = np.concatenate([self._mouths_before, samples])
        self._mouths_before = known[known.size - self._mouths_before.size :]
        low = np.convolve(known, low_pass(self.microphones.rate), mode="valid")
        shelved: Samples = MOUTH_MEAN[1] * samples + (MOUTH_MEAN[0] - MOUTH_MEAN[1]) * low
        return shelved.astype(np.float32)

    def _fade_out(self, voice: _ActiveSource, before: NDArray[np.complex64], after: NDArray[np.complex64]) -> bool:
        """Let an ended sound ring out; True when it has."""
        if voice.silent:
            return True
        voice.partitions.feed(np.zeros(self._block, dtype=np.float32))
        voice.partitions.add_to(before, after)
        return False

    def _audible(self, emissions: Sequence[Emission], ways: Sequence[SoundPath], X_WA: Pose3) -> set[int]:
        """Indices of the emissions to compute: the loudest, and none below the floor."""
        levels = []
        for emission, way in zip(emissions, ways, strict=True):
            distance = way.before_m + float(np.linalg.norm(way.p_W - X_WA.translation))
            direct = max(way.gains) / max(distance, 0.1)
            around = 0.0
            if way.room is not None:
                around = way.late**2 * _reverberation(way.room)
            levels.append(emission.gain * emission.level * math.sqrt(direct**2 + around))
        order = sorted(range(len(levels)), key=levels.__getitem__, reverse=True)[: self._most]
        return {number for number in order if levels[number] >= self._floor}

    def _impulses(
        self, voice: _ActiveSource, way: SoundPath, X_WA: Pose3, looks: NDArray[np.float64] | None
    ) -> Samples:
        rate = self.microphones.rate
        straight_m = float(np.linalg.norm(way.p_W - X_WA.translation))
        # The read position includes all of the path but the kernel's margin
        margin_s = (way.before_m + straight_m) / SPEED_OF_SOUND_MPS - voice.delay / rate
        start_s = straight_m / SPEED_OF_SOUND_MPS - margin_s
        length = self._early_blocks * self._block
        if way.room is None:
            found = Images(
                way.p_W[None],
                np.ones((1, 2)),
                ((X_WA.translation - way.p_W) / max(straight_m, 1e-9))[None],
                np.array([straight_m]),
            )
        else:
            reach_m = straight_m + self.early_s * SPEED_OF_SOUND_MPS
            found = images(way.room, way.p_W, X_WA.translation, reach_m)
        air = 10 ** (-AIR_DB_PER_M * (way.before_m + (straight_m if way.room is None else 0.0)) / 20)
        spread = found.distances / np.maximum(found.distances + way.before_m, 1e-9)
        gains = found.gains * spread[:, None] * np.array(way.gains) * air
        found = Images(found.p_W, gains, found.departures, found.distances)
        impulses = early(
            self.microphones, X_WA, found=found, length=length, start_s=start_s, looks=looks, taps=_REFLECTION_TAPS
        )
        if way.room is not None:  # early sound fades out as late sound fades in
            end = self._step * self._block
            fade = round(0.004 * rate)
            impulses[:, end : end + fade] *= np.cos(0.5 * math.pi * (np.arange(fade) + 0.5) / fade)
            impulses[:, end + fade :] = 0
        return impulses

    def _enter(self, room: Shoebox | None) -> None:
        if room == self._room or room is None:
            return
        self._room = room
        self.prepare((room,))
        self._tail.set_kernel(self._tails[room])

    def _late_kernel(self, room: Shoebox, noise: Samples) -> Spectra:
        rate = self.microphones.rate
        heard_s = max(room.rt60_s) * _LATE_DECAY_DB / 60
        length = min(self._tail_length, max(self._tail.delay, round(heard_s * rate)))
        after_s = (self._tail.delay - MARGIN) / rate
        # A separate part of the noise for each room
        own = np.take(noise, np.arange(length) + hash(room.corner) % noise.shape[-1], axis=-1, mode="wrap")
        impulses = late(room, own, length, rate, after_s)
        end = min(length, 2048)
        impulses[:, -end:] *= np.linspace(1, 0, end, dtype=np.float32)
        return self._tail.kernel(impulses)


@lru_cache(maxsize=64)
def _reverberation(room: Shoebox) -> float:
    """Energy of a room's whole reverberation after an impulse of 1 at 1 m."""
    return float(room.late_power(0.0).max()) * max(room.rt60_s) / (6 * math.log(10))


class _ActiveSource:
    def __init__(self, outputs: int, block: int, blocks: int) -> None:
        self.partitions = Partitions(outputs, block, blocks)
        self.delay = 0.0
        self._started = False
        self._gain = 0.0
        self._late_gain = 0.0
        self._age = 0
        self._at: tuple[SoundPath, Pose3, NDArray[np.float64] | None] | None = None

    @property
    def silent(self) -> bool:
        return self.partitions.silent

    def read(self, emission: Emission, way: SoundPath, X_WA: Pose3, position: int, rate: int, audible: bool) -> Samples:
        block = self.partitions.block
        whole_m = way.before_m + float(np.linalg.norm(way.p_W - X_WA.translation))
        delay = max(0.0, whole_m / SPEED_OF_SOUND_MPS * rate - MARGIN)
        gain = emission.gain if audible else 0.0
        if not self._started:
            self.delay, self._gain, self._started = delay, gain, True
        first = position - emission.begin - self.delay
        if gain == 0 and self._gain == 0:
            x = np.zeros(block, dtype=np.float32)
        elif abs(delay - self.delay) <= _JUMP_M / SPEED_OF_SOUND_MPS * rate:
            x = read_between(emission.dry, first, position + block - emission.begin - delay, block)
        else:  # a jump: cross-fade from one path to the other
            share = ramp(0.0, 1.0, block)
            there = position - emission.begin - delay
            old = read_between(emission.dry, first, first + block, block)
            x = old + share * (read_between(emission.dry, there, there + block, block) - old)
        if gain != 1.0 or self._gain != 1.0:
            x = x * ramp(self._gain, gain, block)
        self.delay, self._gain = delay, gain
        return x

    def stale(self, way: SoundPath, X_WA: Pose3, looks: NDArray[np.float64] | None, refresh: int) -> bool:
        """Whether its impulse responses must be computed for the current geometry, which is then noted."""
        self._age += 1
        if self._at is not None:
            if self._age < refresh:
                return False
            then, X, looked = self._at
            moved = max(float(np.abs(way.p_W - then.p_W).max()), float(np.abs(X_WA.translation - X.translation).max()))
            turned = float(np.abs(X_WA.rotation - X.rotation).max())
            same = way.room == then.room and np.allclose(way.gains, then.gains, rtol=0.1, atol=1e-3)
            same = same and (looks is None or looked is None or float(looks @ looked) > _LOOKED)
            if same and moved < _MOVED_M and turned < _TURNED_RAD:
                return False
        self._at = (way, X_WA, looks)
        self._age = 0
        return True

    def late(self, x: Samples, way: SoundPath, rate: int) -> Samples:
        """Its excitation of its room's reverberation, attenuated by the length of the direct path."""
        assert way.room is not None
        whole_s = (self.delay + MARGIN) / rate
        gain = way.late * 10 ** (-3 * whole_s / max(way.room.rt60_s))
        if self._late_gain == 0.0:
            self._late_gain = gain
        y = x * ramp(self._late_gain, gain, x.size)
        self._late_gain = gain
        return y
