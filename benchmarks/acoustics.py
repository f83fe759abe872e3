"""Cost of the simulated microphones: ``python -m benchmarks.acoustics [--quick] [--json] [--out FILE]``.

CPU of one thread, in % of a core, to give eight channels of 48 kHz in real time: no sound at all, one to three talkers
in a reverberant room, standing and walking while the robot drives and turns, with and without the torso between the
microphones. The longest frames show whether one (10.7 ms) can be late. Offline: seconds of scene rendered in a second.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable

import numpy as np

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.auralization import Auralizer, Emission, OneRoom
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.dry_sound import SampledSound
from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene
from app.robots.simulated.acoustics.room import Shoebox
from app.robots.simulated.acoustics.sound_library import ClipLibrary
from app.robots.stream_config import MicrophonesConfig
from benchmarks.report import Row, benchmark_main, row

RATE, BLOCK = 48000, 512
ROOM = Shoebox((0.0, 0.0, 0.0), (11.6, 6.8, 2.7), (0.55, 0.44))
CLIPS = ("question", "story", "answer")


def live(talkers: int, moving: bool, shadow: bool, seconds: float) -> tuple[float, float]:
    """CPU in % of a core, and the longest frame (ms of CPU)."""
    library = ClipLibrary(RATE, -32.0)
    array = _array(shadow)
    hearing = Auralizer(array, OneRoom(ROOM), late_s=0.6)
    hearing.prepare((ROOM,))
    clips = [SampledSound(library.get(name).samples, loop=True) for name in CLIPS[:talkers]]
    spent = []
    for number in range(round(seconds * RATE / BLOCK)):
        t = number * BLOCK / RATE * moving
        X_WA = Pose3.from_translation_rpy((3.0 + 0.3 * t % 5, 3.0, 1.1), (0.0, 0.0, 0.5 * t))
        emissions = [
            Emission(
                f"{n}", clip, 0, np.array([6.0 + math.sin(t + n), 1.5 + 1.5 * n, 1.6]), looks=np.array([-1.0, 0, 0])
            )
            for n, clip in enumerate(clips)
        ]
        began = time.thread_time()
        hearing.block(emissions, X_WA)
        spent.append(time.thread_time() - began)
    warm = np.array(spent[20:])
    return float(100 * warm.sum() / (warm.size * BLOCK / RATE)), float(1e3 * np.percentile(warm, 99))


def offline(seconds: float) -> float:
    """Seconds of a scene of two walking talkers rendered in one second of CPU."""
    library = ClipLibrary(RATE, -32.0)

    def walker(number: int) -> Callable[[float], tuple[float, float, float]]:
        return lambda t: (5.0 + 0.5 * t, 1.5 + 2.0 * number, 1.6)

    sources = [
        OfflineSource(library.get(name).samples, walker(n), looks="listener", loop=True)
        for n, name in enumerate(CLIPS[:2])
    ]
    began = time.thread_time()
    render_scene(sources, Pose3.from_translation_rpy((3.0, 3.0, 1.1)), ROOM, seconds, _array(shadow=True))
    return seconds / (time.thread_time() - began)


def _array(shadow: bool) -> BaffledMicrophones:
    positions = np.array(MicrophonesConfig().positions)
    return BaffledMicrophones(positions - positions.mean(axis=0), RATE, shadow)


def measure(quick: bool) -> list[Row]:
    """All figures, as rows."""
    rounds, seconds = (1, 4.0) if quick else (5, 20.0)
    rows = []
    for talkers, moving, shadow in (
        (0, False, True),
        (1, True, True),
        (3, False, True),
        (3, True, True),
        (3, True, False),
    ):
        cpu, longest = zip(*(live(talkers, moving, shadow, seconds) for _ in range(rounds)), strict=True)
        name = f"{talkers} talkers{', all moving' if moving else ''}{'' if shadow else ', no torso'}"
        rows += [
            row("acoustics", name, "CPU", "% of a core", cpu),
            row("acoustics", name, "99 of 100 frames within", "ms", longest),
        ]
    rows.append(
        row(
            "acoustics",
            "offline, 2 walking talkers",
            "rendered in one second of CPU",
            "s",
            [offline(seconds) for _ in range(rounds)],
        )
    )
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
