"""An hour of a laboratory's sound at one microphone, the claps and calls in it known: generated, seeded, in blocks.

Levels follow from those at 1 m (dB SPL) and the distance, in a room of 300 m^3 with 0.5 s of reverberation, whose
critical distance is 2 m for a voice; 65 dB SPL at the microphone is -32 dB of full scale, as on the robot
(``MicrophonesConfig.sensitivity_db``).

*Loud noises* are the claps (82 to 92 dB in their loudest 10 ms) and the calls (79 to 88 dB there: from loud speech to a
shout, ANSI S3.5) of people 1 to 3 m away. All else is not: conversations 3 to 7 m away (58 to 66 dB on average) whose
talkers pause, music from the next room, steps, doors that close, things put down, and the microphone being switched on;
under it the fans, whose level wanders by 10 dB up and down within minutes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, fftconvolve, lfilter, sosfilt

RATE = 48_000
#: A block's length (s).
BLOCK_S = 10.0
#: 65 dB SPL in dB of full scale.
_REFERENCE_DB = -32.0 - 65.0
_CRITICAL_M = 2.0
_RT60_S = 0.5

Sound = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Event:
    """One sound: ``kind``, its ``begin`` (s, when it arrives at the microphone), and whether it is a loud noise."""

    begin: float
    kind: str
    loud: bool
    seed: int
    level_db: float
    distance_m: float


@dataclass(frozen=True, slots=True)
class Script:
    """What happens within ``duration_s``."""

    seed: int
    duration_s: float
    events: tuple[Event, ...]
    #: (begin, end) s of each stretch of music, and the seed it is played from.
    music: tuple[tuple[float, float, int], ...]
    #: (begin, end) s while the microphone is off.
    off: tuple[tuple[float, float], ...]

    @property
    def truth(self) -> NDArray[np.float64]:
        """When the loud noises begin (N,), s, in order."""
        return np.array([event.begin for event in self.events if event.loud])


def script(seed: int, duration_s: float = 3600.0) -> Script:
    """What happens in ``duration_s`` of the laboratory; per hour about 240 loud noises and 2,500 others."""
    rng = np.random.default_rng(seed)
    hours = duration_s / 3600.0
    events: list[Event] = []

    def add(begin: float, kind: str, loud: bool, level: tuple[float, float], far: tuple[float, float]) -> None:
        events.append(Event(begin, kind, loud, int(rng.integers(1 << 31)), rng.uniform(*level), rng.uniform(*far)))

    off = [(0.0, 0.3)]
    off += [
        (t, t + rng.uniform(0.5, 3.0))
        for t in np.sort(rng.uniform(min(60, duration_s / 3), duration_s - 20, max(1, round(6 * hours))))
    ]
    t = 8.0
    while t < duration_s - 3:
        if not any(begin - 1.0 < t < end + 2.0 for begin, end in off):
            if rng.random() < 0.55:
                level, far = rng.uniform(82, 92), rng.uniform(1, 3)
                # Some clap two or three times.
                for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
                    add(t, "clap", True, (level - 1, level + 1), (far, far))
                    t += rng.uniform(0.75, 1.1)
            else:
                add(t, "call", True, (79, 88), (1, 3))
        t += rng.uniform(1.5, 20.0)
    for begin in rng.uniform(0, duration_s, round(9 * hours) or 1):
        end = min(duration_s, begin + rng.uniform(40, 240))
        t, level, far = begin, rng.uniform(58, 66), rng.uniform(3, 7)
        while t < end:
            add(t, "talk", False, (level - 2, level + 2), (far, far))
            t += rng.uniform(1.5, 3.5) + rng.exponential(1.2)
    for begin in rng.uniform(0, duration_s, round(40 * hours) or 1):
        t, level, far = begin, rng.uniform(52, 62), rng.uniform(2, 7)
        for _ in range(int(rng.integers(6, 30))):
            add(t, "step", False, (level - 3, level + 3), (far, far))
            t += rng.uniform(0.48, 0.6)
    for begin in rng.uniform(0, duration_s, round(40 * hours) or 1):
        add(begin, "door", False, (62, 72), (3, 8))
    for begin in rng.uniform(0, duration_s, round(60 * hours) or 1):
        add(begin, "thing", False, (55, 66), (2, 5))
    music = [(b, b + rng.uniform(60, 240), int(rng.integers(1 << 31))) for b in rng.uniform(0, duration_s, 4)]
    return Script(seed, duration_s, tuple(sorted(events, key=lambda e: e.begin)), tuple(music), tuple(off))


def blocks(plan: Script) -> Iterator[NDArray[np.int16]]:
    """The microphone's samples, int16, block by block of :data:`BLOCK_S`."""
    length = round(BLOCK_S * RATE)
    fans = _Fans(plan)
    waiting = list(plan.events)
    tail = np.zeros(0, np.float32)
    noise = np.random.default_rng((plan.seed, 1))
    for number in range(math.ceil(plan.duration_s / BLOCK_S)):
        begin = number * length
        mixed = np.zeros(max(length, len(tail)) + 1, np.float32)
        mixed[: len(tail)] += tail
        while waiting and waiting[0].begin * RATE < begin + length:
            event = waiting.pop(0)
            sound = heard(event)
            at = round(event.begin * RATE) - begin
            if at + len(sound) > len(mixed):
                mixed = np.concatenate((mixed, np.zeros(at + len(sound) - len(mixed), np.float32)))
            mixed[at : at + len(sound)] += sound
        block, tail = mixed[:length], mixed[length:]
        block = block + fans.next(length) + _music(plan, begin, length)
        block += noise.normal(0, _amplitude(-75.0), length).astype(np.float32)
        for start, end in plan.off:
            _switch(block, round(start * RATE) - begin, round(end * RATE) - begin)
        yield np.clip(np.rint(block * 32768), -32768, 32767).astype(np.int16)


def heard(event: Event) -> Sound:
    """``event`` as the microphone hears it: its direct sound and the room's answer, from the moment it arrives."""
    rng = np.random.default_rng(event.seed)
    dry = _SOUNDS[event.kind](rng)
    # The level is that of the loudest 10 ms, but of talk that of the whole.
    window = len(dry) if event.kind == "talk" else round(0.01 * RATE)
    power = np.convolve(dry.astype(np.float64) ** 2, np.full(window, 1 / window), "valid").max() if window else 0
    dry = dry * np.float32(_amplitude(event.level_db + _REFERENCE_DB) / math.sqrt(max(float(power), 1e-20)))
    count = round(_RT60_S * RATE)
    decay = np.exp(-6.91 * np.arange(count) / count)
    room = rng.normal(0, 1, count) * decay
    # Of the same energy as the direct sound at the critical distance; it comes after the first walls, and duller.
    room *= (1 / _CRITICAL_M) / math.sqrt(float((room**2).sum()))
    room = lfilter([0.35], [1, -0.65], room)
    response = np.zeros(count + 400, np.float64)
    response[400:] = room
    response[0] += 1 / event.distance_m
    return np.asarray(fftconvolve(dry, response), np.float32)


def _amplitude(level_db: float) -> float:
    return float(10 ** (level_db / 20))


# --- Sounds ----------------------------------------------------------------------------------------------------------


def _clap(rng: np.random.Generator) -> Sound:
    """A clap: a burst of some milliseconds with the resonance of the hollow between the hands."""
    t = np.arange(round(0.06 * RATE)) / RATE
    center = rng.uniform(900, 2400)
    sos = butter(2, (0.5 * center, min(2.2 * center, 8000)), "bandpass", fs=RATE, output="sos")
    burst = rng.normal(0, 1, len(t)) * np.exp(-t / rng.uniform(0.002, 0.006)) * (1 - np.exp(-t / 0.0003))
    return np.asarray(sosfilt(sos, burst), np.float32)


def _voice(rng: np.random.Generator, seconds: float, pitch: float, effort: float, rise_s: float) -> Sound:
    """A vowel: pulses of the voice through three formants; ``effort`` (0..1) makes it brighter, as shouting does."""
    count = round(seconds * RATE)
    t = np.arange(count) / RATE
    f = pitch * (1 + 0.15 * np.sin(np.pi * t / seconds) + 0.01 * np.sin(2 * np.pi * 5 * t))
    phase = np.cumsum(f) / RATE
    pulses = np.diff(np.floor(phase), prepend=0.0)
    source = lfilter([1], [1, -(0.97 - 0.25 * effort)], pulses) + 0.02 * rng.normal(0, 1, count)
    out = np.zeros(count)
    vowel = _VOWELS[int(rng.integers(len(_VOWELS)))]
    for formant, gain in zip(vowel, (1.0, 0.7, 0.4 + 0.4 * effort), strict=True):
        r = math.exp(-math.pi * (60 + 0.06 * formant) / RATE)
        out += gain * (1 - r) * lfilter([1], [1, -2 * r * math.cos(2 * math.pi * formant / RATE), r * r], source)
    envelope = np.minimum(1, t / rise_s) * np.minimum(1, (seconds - t) / 0.06)
    return np.asarray(lfilter([1, -0.95], [1], out) * envelope, np.float32)


_VOWELS = ((730, 1090, 2440), (530, 1840, 2480), (270, 2290, 3010), (570, 840, 2410), (300, 870, 2240))


def _call(rng: np.random.Generator) -> Sound:
    """Hey! A name! One or two shouted syllables."""
    pitch = rng.uniform(150, 380)
    parts = [_voice(rng, rng.uniform(0.15, 0.5), pitch, 1.0, rng.uniform(0.008, 0.03))]
    if rng.random() < 0.5:
        parts.append(np.zeros(round(rng.uniform(0.02, 0.06) * RATE), np.float32))
        parts.append(_voice(rng, rng.uniform(0.15, 0.4), pitch * 1.1, 1.0, 0.02))
    return np.concatenate(parts)


def _talk(rng: np.random.Generator) -> Sound:
    """A sentence of unlike syllables, some of them hissed."""
    pitch = rng.uniform(90, 230)
    parts: list[Sound] = []
    for _ in range(int(rng.integers(5, 14))):
        if rng.random() < 0.3:
            hiss = rng.normal(0, 0.004, round(rng.uniform(0.04, 0.1) * RATE))
            parts.append(np.asarray(lfilter([1, -0.9], [1], hiss) * np.hanning(len(hiss)), np.float32))
        syllable = _voice(rng, rng.uniform(0.1, 0.25), pitch * rng.uniform(0.85, 1.2), 0.3, rng.uniform(0.015, 0.05))
        parts.append(syllable * np.float32(10 ** (rng.uniform(-8, 3) / 20)))
        if rng.random() < 0.3:
            parts.append(np.zeros(round(rng.uniform(0.03, 0.2) * RATE), np.float32))
    return np.concatenate(parts)


def _step(rng: np.random.Generator) -> Sound:
    """Heel and sole: a thud and a click."""
    t = np.arange(round(0.12 * RATE)) / RATE
    thud = np.sin(2 * np.pi * rng.uniform(60, 110) * t) * np.exp(-t / 0.025)
    click = np.diff(rng.normal(0, 1, len(t)), prepend=0) * np.exp(-t / 0.004) * rng.uniform(0.05, 0.25)
    return np.asarray((thud + click) * (1 - np.exp(-t / 0.002)), np.float32)


def _door(rng: np.random.Generator) -> Sound:
    """A door that closes: its panel's thud, then the latch."""
    t = np.arange(round(0.5 * RATE)) / RATE
    thud = sum(np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) for f in rng.uniform(50, 260, 5)) * np.exp(-t / 0.06)
    latch = rng.normal(0, 1, len(t)) * np.exp(-np.abs(t - rng.uniform(0.03, 0.12)) / 0.004) * rng.uniform(0.3, 1.0)
    rattle = lfilter(*butter(2, (400, 3000), "bandpass", fs=RATE), rng.normal(0, 1, len(t))) * np.exp(-t / 0.05)
    return np.asarray((thud + latch + 0.5 * rattle) * (1 - np.exp(-t / 0.004)), np.float32)


def _thing(rng: np.random.Generator) -> Sound:
    """A cup, a tool put on a table."""
    t = np.arange(round(0.15 * RATE)) / RATE
    ring = sum(np.sin(2 * np.pi * f * t) * np.exp(-t / rng.uniform(0.005, 0.03)) for f in rng.uniform(300, 4000, 6))
    return np.asarray(ring * (1 - np.exp(-t / 0.001)), np.float32)


_SOUNDS = {"clap": _clap, "call": _call, "talk": _talk, "step": _step, "door": _door, "thing": _thing}


class _Fans:
    """Fans and ventilation: hum, its harmonics and air, whose level wanders by 10 dB up and down within minutes."""

    def __init__(self, plan: Script) -> None:
        self._rng = np.random.default_rng((plan.seed, 2))
        self._periods = self._rng.uniform((150, 60), (420, 200))
        self._phases = self._rng.uniform(0, 2 * math.pi, 2)
        self._air = butter(1, 1200, "lowpass", fs=RATE)
        self._rumble = butter(1, 60, "lowpass", fs=RATE)
        self._states = [np.zeros(1), np.zeros(1)]
        self._at = 0

    def next(self, length: int) -> Sound:
        """The next ``length`` samples."""
        t = (self._at + np.arange(length)) / RATE
        self._at += length
        air, self._states[0] = lfilter(*self._air, self._rng.normal(0, 4.0, length), zi=self._states[0])
        rumble, self._states[1] = lfilter(*self._rumble, self._rng.normal(0, 50.0, length), zi=self._states[1])
        hum = sum(math.sqrt(2) * 0.7**k * np.sin(2 * np.pi * 118 * (k + 1) * t + k) for k in range(8))
        p, q = (
            np.sin(2 * np.pi * t / period + phase) for period, phase in zip(self._periods, self._phases, strict=True)
        )
        drift_db = 7.0 * p + 3.0 * q
        return np.asarray((0.8 * air + 0.6 * hum + rumble) * _amplitude(-56.0) * 10 ** (drift_db / 20), np.float32)


def _music(plan: Script, begin: int, length: int) -> Sound:
    """Music of the next room: drums and chords at 110 beats a minute, dull from the wall between."""
    out = np.zeros(length, np.float32)
    beat = round(RATE * 60 / 110)
    for start_s, end_s, seed in plan.music:
        start, end = round(start_s * RATE), round(min(end_s, plan.duration_s) * RATE)
        if end <= begin or start >= begin + length:
            continue
        first, last = max(0, (begin - start) // beat - 2), (begin + length - start) // beat + 1
        stretch = np.zeros((last - first + 3) * beat, np.float64)
        t = np.arange(2 * beat) / RATE
        for number in range(first, last):
            rng = np.random.default_rng((seed, number))
            chord = rng.choice((196.0, 220.0, 261.6, 293.7, 329.6, 392.0), 3)
            played = sum(_note(f, 2 * beat) for f in chord.tolist()) * np.exp(-t / 0.5)
            drum = (
                2.0 * np.sin(2 * np.pi * 55 * t) * np.exp(-t / 0.08)
                if number % 2 == 0
                else rng.normal(0, 1.2, len(t)) * np.exp(-t / 0.04)
            )
            at = (number - first) * beat
            stretch[at : at + 2 * beat] += played + drum
        dull = lfilter(*butter(2, 1500, "lowpass", fs=RATE), stretch) * _amplitude(-49.0)
        offset = begin - (start + first * beat)
        instants = np.arange(length)
        inside = (begin + instants >= start) & (begin + instants < end)
        piece = np.zeros(length, np.float64)
        source = offset + instants
        good = inside & (source >= 0) & (source < len(dull))
        piece[good] = dull[source[good]]
        out += piece.astype(np.float32)
    return out


@cache
def _note(frequency: float, length: int) -> NDArray[np.float64]:
    """``length`` samples of a note and its octave."""
    t = np.arange(length) / RATE
    return np.asarray(np.sin(2 * np.pi * frequency * t) + 0.4 * np.sin(4 * np.pi * frequency * t))


def _switch(block: Sound, start: int, end: int) -> None:
    """The microphone off from ``start`` to ``end`` (samples from the block's begin), and the thump of its coming on."""
    length = len(block)
    if start < length and end > 0:
        block[max(0, start) : min(length, end)] = 0.0
    settle = round(0.4 * RATE)
    if end < length and end + settle > 0:
        begin, stop = max(0, end), min(length, end + settle)
        t = (np.arange(begin, stop) - end) / RATE
        # Its bias settles, and its gain comes up.
        block[begin:stop] = block[begin:stop] * np.minimum(1, t / 0.15) + (0.25 * np.exp(-t / 0.05)).astype(np.float32)
