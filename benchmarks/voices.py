"""Where voices are: recall, error, false tracks, latency and CPU of localization and tracking, beside a plain method.

Rooms with people talking as ``voice_rooms`` draws them, held out from tuning: other speakers, other rooms, other seeds
(7000 and on, walking 8000 and on; with fewer microphones and behind the torso 2000 and on, looked at before).
Scored as in ``voice_scoring``. Shown for the array that ODAS's and ManyEars' figures were taken with,
and for IRL-1's; then IRL-1's with fewer microphones, and with the torso between them. CPU is of one thread, per cent
of a core. The plain method hears the same sound in the same run.
"""

# ruff: noqa: E402

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

# Before numpy is there: its threads would share the work, and hide it.
for _library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_library, "1")

import numpy as np

from app.base.paths import config_dir
from app.modules.perception.voices.microphone_array import MicrophoneArray, load_array
from benchmarks.report import Row, benchmark_main, row
from benchmarks.voice_rooms import BOX, HELD_OUT, Cast, Recipe, Scene, cached, recipes
from benchmarks.voice_scoring import Located, Score, in_space, ours, plain, score, to_line
from benchmarks.voice_shadow import shadowed

BENCHMARK = "voices"
PEER = "plain SRP-PHAT"
#: Talkers, RT60 (s), SNR (dB), walking; scenes when measured in full and roughly.
KINDS = (
    (1, 0.3, 20.0, False, 4, 2),
    (1, 0.6, 20.0, False, 7, 0),
    (1, 0.45, 10.0, False, 4, 0),
    (2, 0.3, 20.0, False, 4, 2),
    (2, 0.45, 10.0, False, 4, 1),
    (3, 0.3, 20.0, False, 4, 0),
    (3, 0.45, 10.0, False, 4, 2),
    (2, 0.3, 20.0, True, 2, 0),
)
#: First seeds of those held out, of people who stand and who walk.
FIRST, FIRST_WALKING = 7000, 8000
LONG_S = 1.0


def reference_speech() -> Path:
    """The folder of recorded speech; it may not be there."""
    data = os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data"
    return Path(data) / "speech"


def arrays() -> dict[str, MicrophoneArray]:
    """The arrays measured, by name, about their middles."""
    irl1 = load_array(config_dir() / "arrays" / "irl1.yaml")
    return {"0.2 x 0.3 x 0.4 m": MicrophoneArray(BOX), "IRL-1": MicrophoneArray(irl1.offsets)}


def scored(
    recipe_list: Sequence[Recipe],
    array: MicrophoneArray,
    hear: Callable[[Recipe], Scene],
    method: Callable[[Scene, MicrophoneArray], tuple[Located, float]],
) -> list[Score]:
    """Every scene's score. Microphones on a line are asked only for what they can know."""
    angle = to_line(array.extents[1][0]) if array.dimensions == 1 else in_space
    scores = []
    for recipe in recipe_list:
        scene = hear(recipe)
        located, cpu_percent = method(scene, array)
        scores.append(score(scene, located, cpu_percent, angle))
    return scores


def rows_of(case: str, mine: Sequence[Score], other: Sequence[Score] | None, peer: str = PEER) -> list[Row]:
    """The rows of one case."""

    def pooled(figure: Callable[[Sequence[Score]], float]) -> tuple[list[float], list[float] | None]:
        return [figure(mine)], None if other is None else [figure(other)]

    def recall(scores: Sequence[Score]) -> float:
        return 100 * sum(s.found for s in scores) / max(1, sum(s.asked for s in scores))

    def error(scores: Sequence[Score]) -> float:
        errors = np.concatenate([s.errors_deg for s in scores])
        return float(errors.mean()) if len(errors) else float("nan")

    def false_tracks(scores: Sequence[Score]) -> float:
        return float(sum(seconds > LONG_S for s in scores for seconds in s.false_s))

    case = f"{case}, {len(mine)} scene{'s' * (len(mine) > 1)}"
    return [
        row(BENCHMARK, case, "recall", "%", *pooled(recall), peer),
        row(BENCHMARK, case, "mean error", "deg", *pooled(error), peer),
        row(BENCHMARK, case, "false tracks > 1 s", "", *pooled(false_tracks), peer),
    ]


def in_rooms(quick: bool, cast: Cast, speech: Path) -> list[Row]:
    """Both arrays in all rooms, CPU and latency."""
    rows: list[Row] = []
    for name, array in arrays().items():
        all_mine: list[Score] = []
        all_others: list[Score] = []
        latencies: list[float] = []
        for talkers, rt60_s, snr_db, walking, many, few in KINDS:
            count = few if quick else many
            if not count or (quick and name != "IRL-1"):
                continue

            def hear(recipe: Recipe, array: MicrophoneArray = array) -> Scene:
                return cached(recipe, array.positions, speech)

            drawn = recipes(cast, talkers, rt60_s, snr_db, count, walking, FIRST_WALKING if walking else FIRST)
            mine, others = scored(drawn, array, hear, ours), scored(drawn, array, hear, plain)
            who = f"{talkers} talker{'s' * (talkers > 1)}{' walking' * walking}"
            rows += rows_of(f"{name}, {who}, RT60 {rt60_s:g} s, {snr_db:g} dB", mine, others)
            all_mine += mine
            all_others += others
            if talkers == 1:
                latencies += [seconds for s in mine for seconds in s.latencies_s]
        if all_mine:
            cpu, peer = ([s.cpu_percent for s in scores] for scores in (all_mine, all_others))
            rows.append(row(BENCHMARK, f"{name}, all", "CPU", "%", cpu, peer, PEER))
            for share in (50, 95, 100):
                value = 1e3 * float(np.percentile(latencies, share))
                rows.append(row(BENCHMARK, f"{name}, one talker", f"onset to track p{share}", "ms", [value]))
    return rows


def fewer_microphones(quick: bool, cast: Cast, speech: Path) -> list[Row]:
    """IRL-1's strategies."""
    whole = arrays()["IRL-1"]
    rows = []
    for count in (2, 4, 8):
        array = whole.subset(count)

        def hear(recipe: Recipe) -> Scene:
            return cached(recipe, whole.positions, speech)

        cpu: list[float] = []
        for talkers in (1, 2):
            drawn = recipes(cast, talkers, 0.3, 20.0, 1 if quick else 4)
            mine = scored(drawn, array, hear, ours)
            case = f"IRL-1, {count} microphones{' (their angle)' if count == 2 else ''}, {talkers} talker"
            rows += rows_of(f"{case}{'s' * (talkers > 1)}, RT60 0.3 s, 20 dB", mine, None, "")
            cpu += [s.cpu_percent for s in mine]
        rows.append(row(BENCHMARK, f"IRL-1, {count} microphones", "CPU", "%", cpu))
    return rows


def behind_the_torso(quick: bool, cast: Cast, speech: Path) -> list[Row]:
    """The same scenes through free air and around the torso; and around it, heard as if through free air."""
    array = arrays()["IRL-1"]
    rounded = MicrophoneArray(array.positions, body_m=float(np.linalg.norm(array.offsets[0])))

    def straight(scene: Scene, array: MicrophoneArray) -> tuple[Located, float]:
        return ours(scene, MicrophoneArray(array.positions, array.channels))

    rows = []
    for talkers in (2,) if quick else (1, 2, 3):
        drawn = recipes(cast, talkers, 0.45, 20.0, 1 if quick else 4)
        for torso in (False, True):

            def hear(recipe: Recipe, torso: bool = torso) -> Scene:
                return shadowed(recipe, array.positions, speech, torso)

            mine = scored(drawn, rounded if torso else array, hear, ours)
            naive = scored(drawn, array, hear, straight)
            case = f"IRL-1, {'torso' if torso else 'no torso'}, {talkers} talker{'s' * (talkers > 1)}"
            rows += rows_of(f"{case}, RT60 0.45 s, 20 dB", mine, naive, "straight waves")
    return rows


def measure(quick: bool) -> list[Row]:
    """All of it."""
    speech = reference_speech()
    if not speech.is_dir():
        raise SystemExit(f"no recorded speech in {speech}; HBBA_REFERENCE_DATA names the folder of reference data")
    rows = in_rooms(quick, HELD_OUT, speech)
    rows += fewer_microphones(quick, HELD_OUT, speech)
    return rows + behind_the_torso(quick, HELD_OUT, speech)


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
