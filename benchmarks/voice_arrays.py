"""How often a wrong array is noticed by what it hears, and a right one wrongly doubted: figures of ``array_check``.

Rooms with people talking in them (``voice_rooms``; seeds 30000 and on for the talkers of tuning in rooms of any size,
31000 and on for those held out, one scene of each kind and seed), heard at once by a box of eight microphones, by
IRL-1's eight and by four on a cross of 64 mm. Each array hears each scene as it is, and in each wrong way: with
channels in another order, or with positions of another scale. A rotation or mirror image of the array itself is no
wrong way: its distances are right.
"""

# ruff: noqa: E402

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

# Before numpy is there: its threads would share the work, and hide it.
for _library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_library, "1")

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.array_check import LEAST_MOMENTS
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline
from benchmarks.report import Row, benchmark_main, row
from benchmarks.voice_rooms import BOX, HELD_OUT, TUNING_WIDE, Recipe, Scene, cached, recipes
from benchmarks.voices import arrays, reference_speech

BENCHMARK = "voice_arrays"
#: RT60 (s) and SNR (dB), each with one, two and three talkers.
ROOMS = ((0.3, 20.0), (0.45, 10.0), (0.6, 5.0))
SEEDS = 4
#: A ReSpeaker's circle of four, 64 mm across.
CROSS = 0.032 * np.array([(1.0, 0, 0), (0, 1.0, 0), (-1.0, 0, 0), (0, -1.0, 0)])

Positions = NDArray[np.float64]
#: Positions (M, 3) of a wrongly described array; the seed chooses among mistakes of one kind.
Mistake = Callable[[Positions, int], Positions]


def _swapped(placed: Positions, seed: int) -> Positions:
    first, second = np.random.default_rng(seed).choice(len(placed), 2, replace=False)
    wrong = placed.copy()
    wrong[[first, second]] = placed[[second, first]]
    return wrong


def _shuffled(placed: Positions, seed: int) -> Positions:
    return placed[np.random.default_rng(seed).permutation(len(placed))]


MISTAKES: dict[str, Mistake] = {
    "right": lambda placed, seed: placed,
    "two swapped": _swapped,
    "shifted by one": lambda placed, seed: np.roll(placed, 1, axis=0),
    "any order": _shuffled,
    "twice the size": lambda placed, seed: 2 * placed,
    "half the size": lambda placed, seed: placed / 2,
}


def keeps_distances(placed: Positions, wrong: Positions) -> bool:
    """Whether ``wrong`` is ``placed`` turned or mirrored, which sound cannot show."""

    def distances(positions: Positions) -> NDArray[np.float64]:
        return np.asarray(np.linalg.norm(positions[:, None] - positions[None], axis=2))

    return bool(np.allclose(distances(placed), distances(wrong), atol=1e-6))


def kinds(seeds: int) -> Iterator[Recipe]:
    """The scenes; of people who walk, one of each cast."""
    for number in range(seeds):
        for cast, first in ((TUNING_WIDE, 30000), (HELD_OUT, 31000)):
            for rt60_s, snr_db in ROOMS:
                for talkers in (1, 2, 3):
                    yield from recipes(cast, talkers, rt60_s, snr_db, 1, first=first + number)
            if not number:
                yield from recipes(cast, 2, 0.3, 20.0, 1, True, first=first)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What is left of an ``ArrayCheck``, which holds large tables."""

    moments: int
    share: float
    failed: bool


def check(scene: Scene, columns: slice, positions: Positions) -> Verdict:
    """What the pipeline's check says of ``scene``, heard by the microphones of ``columns`` as if at ``positions``."""
    pipeline = VoicePipeline(MicrophoneArray(positions), scene.rate, PipelineSettings(separation=False, speech=False))
    sound = np.rint(scene.samples[:, columns] * 32768).astype(np.int16)
    for begin in range(0, len(sound) - pipeline.step + 1, pipeline.step):
        pipeline.process(sound[begin : begin + pipeline.step], begin / scene.rate, begin)
    checked = pipeline.array_check
    return Verdict(checked.moments, checked.share, checked.failed)


def heard_by() -> dict[str, tuple[slice, Positions]]:
    """The columns of a scene's sound and the positions of each array."""
    return {
        "0.2 x 0.3 x 0.4 m": (slice(0, 8), BOX),
        "IRL-1": (slice(8, 16), arrays()["IRL-1"].offsets),
        "cross of 64 mm": (slice(16, 20), CROSS),
    }


def measure(quick: bool) -> list[Row]:
    """All of it."""
    speech = reference_speech()
    if not speech.is_dir():
        raise SystemExit(f"no recorded speech in {speech}; HBBA_REFERENCE_DATA names the folder of reference data")
    everywhere = np.concatenate([positions for _, positions in heard_by().values()])
    found: dict[tuple[str, str], list[Verdict]] = {}
    for recipe in kinds(1 if quick else SEEDS):
        scene = cached(recipe, everywhere, speech)
        for name, (columns, placed) in heard_by().items():
            for mistake, wrong in MISTAKES.items():
                positions = wrong(placed, recipe.seed + recipe.talkers)
                if mistake == "right" or not keeps_distances(placed, positions):
                    checked = check(scene, columns, positions)
                    found.setdefault((name, mistake), []).append(checked)
    rows = []
    for (name, mistake), checks in found.items():
        case = f"{name}, {mistake}"
        judged = [one for one in checks if one.moments >= LEAST_MOMENTS]
        rows.append(row(BENCHMARK, case, "scenes", "", [len(checks)]))
        rows.append(row(BENCHMARK, case, "with a verdict", "", [len(judged)]))
        rows.append(row(BENCHMARK, case, "doubted", "", [sum(one.failed for one in checks)]))
        if judged:
            rows.append(row(BENCHMARK, case, "share explained", "%", [100 * one.share for one in judged]))
            extreme = min if mistake == "right" else max
            rows.append(
                row(BENCHMARK, case, "share explained, worst", "%", [100 * extreme(one.share for one in judged)])
            )
    return rows


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
