"""Offline rendering of sound scenes without a running world, for benchmarks and tests, with the code of the live
microphones.

from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene

array = BaffledMicrophones(positions - positions.mean(0), 48000, shadow=True)      # False: no torso, free field
room = Shoebox(corner=(0, 0, 0), size=(6, 5, 3), rt60_s=(0.45, 0.40))        # low and high band
talker = OfflineSource(samples_48k, lambda t: (2 + 0.5 * t, 3.0, 1.6), begin_s=0.5, looks="listener")
samples, truth = render_scene([talker], Pose3.from_translation_rpy((3, 2, 1.0)), room, 6.0, array, noise=0.001)
samples        # (channels, N) float32, full scale 1
truth[0].directions, truth[0].active     # (T, 3) in the array's axes and (T,), every 10 ms
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.activity import ACTIVITY_S, activity
from app.robots.simulated.acoustics.auralization import AcousticSpace, Auralizer, Emission, OneRoom
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS, BaffledMicrophones
from app.robots.simulated.acoustics.dry_sound import SampledSound, Samples
from app.robots.simulated.acoustics.room import Shoebox


@dataclass(frozen=True, slots=True, eq=False)
class OfflineSource:
    """One sound of a scene: ``samples`` (N,) float32 at the array's rate, amplitude at 1 m, from ``begin_s`` on.

    ``place`` is a point (m, world) or a function of the time (s) giving one. ``looks``: the mouth's direction (unit
    vector, or a function of the time), ``"listener"`` to look at the array always, None for no direction.
    """

    samples: Samples
    place: ArrayLike | Callable[[float], ArrayLike]
    begin_s: float = 0.0
    gain: float = 1.0
    looks: ArrayLike | Callable[[float], ArrayLike] | Literal["listener"] | None = None
    loop: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class SourceTruth:
    """Ground truth of one source, every 10 ms, at the microphones' time (travel time removed).

    ``times_s`` (T,); ``directions`` (T, 3) unit vectors in the array's axes; ``ranges_m`` (T,); ``active`` (T,) bool:
    whether sound outside the source's own pauses arrives.
    """

    times_s: NDArray[np.float64]
    directions: NDArray[np.float64]
    ranges_m: NDArray[np.float64]
    active: NDArray[np.bool_]


def render_scene(
    sources: Sequence[OfflineSource],
    X_WA: Pose3 | Callable[[float], Pose3],
    room: Shoebox | AcousticSpace | None,
    seconds: float,
    microphones: BaffledMicrophones,
    early_s: float = 0.05,
    noise: float = 0.0,
    seed: int = 1,
) -> tuple[Samples, list[SourceTruth]]:
    """Sound of ``sources`` at an array with its middle at ``X_WA`` (a pose in the world, or a function of the time).

    Images to ``early_s`` after each direct sound (longer is slower), diffuse reverberation after them; ``noise`` is the
    root mean square of white noise at each microphone. Returns samples (C, N) float32, not clipped, and the truth of
    each source. ``room`` None is outdoors.
    """
    surroundings: AcousticSpace = OneRoom(room) if room is None or isinstance(room, Shoebox) else room
    longest_s = max(room.rt60_s) if isinstance(room, Shoebox) else 1.0
    block = 512
    hearing = Auralizer(
        microphones, surroundings, block, early_s, longest_s, refresh_blocks=2, voices=len(sources), seed=seed
    )
    rate = microphones.rate
    pose = X_WA if callable(X_WA) else lambda _: X_WA
    dry = [SampledSound(np.asarray(source.samples, dtype=np.float32), source.loop) for source in sources]
    count = round(seconds * rate)
    out = np.zeros((microphones.p_AM.shape[0], -(-count // block) * block), dtype=np.float32)
    for start in range(0, count, block):
        time_s = (start + block) / rate
        X = pose(time_s)
        emissions = []
        for number, source in enumerate(sources):
            p_W = _at(source.place, time_s)
            looks = _looks(source, p_W, X, time_s)
            emissions.append(
                Emission(
                    f"{number}", dry[number], begin=round(source.begin_s * rate), p_W=p_W, gain=source.gain, looks=looks
                )
            )
        out[:, start : start + block] = hearing.block(emissions, X)
    out = out[:, :count]
    if noise > 0:
        out += noise * np.random.default_rng(seed).standard_normal(out.shape, dtype=np.float32)
    return out, [_truth(source, pose, seconds, rate) for source in sources]


def _truth(source: OfflineSource, pose: Callable[[float], Pose3], seconds: float, rate: int) -> SourceTruth:
    times = np.arange(0.0, seconds, ACTIVITY_S)
    active = activity(np.asarray(source.samples), rate)
    directions, ranges, heard = np.zeros((times.size, 3)), np.zeros(times.size), np.zeros(times.size, dtype=np.bool_)
    for index, time_s in enumerate(times):
        X = pose(float(time_s))
        away = _at(source.place, float(time_s)) - X.translation
        ranges[index] = np.linalg.norm(away)
        directions[index] = (away @ X.rotation) / max(ranges[index], 1e-9)
        at = math.floor((time_s - ranges[index] / SPEED_OF_SOUND_MPS - source.begin_s) / ACTIVITY_S)
        if source.loop and active.size and at >= 0:
            at %= active.size
        heard[index] = 0 <= at < active.size and active[at]
    return SourceTruth(times, directions, ranges, heard)


def _at(place: ArrayLike | Callable[[float], ArrayLike], time_s: float) -> NDArray[np.float64]:
    return np.asarray(place(time_s) if callable(place) else place, dtype=np.float64)


def _looks(source: OfflineSource, p_W: NDArray[np.float64], X_WA: Pose3, time_s: float) -> NDArray[np.float64] | None:
    if source.looks is None:
        return None
    if isinstance(source.looks, str):
        away = X_WA.translation - p_W
        listener: NDArray[np.float64] = away / max(float(np.linalg.norm(away)), 1e-9)
        return listener
    return _at(source.looks, time_s)
