"""Separation of voices, speech detection, and the latency of the first report: figures.

Rooms and talkers as ``voice_rooms`` draws them (held out from tuning), scored by BSS Eval (``bss_eval``) against what
microphone 0 heard of each talker alone, at 16 kHz. Directions are the true ones, except where tracks are said: then
the whole pipeline runs and its separated sound is scored. The peer is the plainest beam, delay and sum, toward the same
directions. Milliseconds are CPU time of one thread for one second of sound. Speech: judgements (32 ms) above one half,
among those within 30 dB of the loudest of a recording of speech, and among all of one of noise.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import soundfile
from numpy.typing import NDArray
from scipy.signal import resample_poly

from app.base.paths import config_dir
from app.modules.perception.voices.delay_and_sum import DelayAndSum
from app.modules.perception.voices.microphone_array import MicrophoneArray, load_array
from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline
from app.modules.perception.voices.resampling import Resampler
from app.modules.perception.voices.separation import Separator
from app.modules.perception.voices.voice_activity import CHUNK, SPEECH_RATE, VoiceActivityDetector
from benchmarks.report import Row, benchmark_main, row
from benchmarks.voice_rooms import BOX, HELD_OUT, RATE, Scene, cached, recipes
from tests.scenery.bss_eval import Scores, bss_eval

BENCHMARK = "separation"
PEER = "delay and sum"
#: Sound (s) before a talker begins, where the latency until the first report is measured.
QUIET_S = 0.7


def reference_speech() -> Path:
    """The folder of recorded speech; it may not be there."""
    data = os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data"
    return Path(data) / "speech"


def arrays() -> dict[str, MicrophoneArray]:
    """The arrays measured, by name, about their middles."""
    irl1 = load_array(config_dir() / "arrays" / "irl1.yaml")
    return {"0.2 x 0.3 x 0.4 m": MicrophoneArray(BOX), "IRL-1": MicrophoneArray(irl1.offsets)}


def score(scene: Scene, sounds: NDArray[np.float32], skip_s: float = 0.0) -> Scores:
    """``sounds`` (K, N) at 16 kHz against the talkers alone, from ``skip_s`` on."""
    alone = np.stack([resample_poly(sound, 1, RATE // SPEECH_RATE) for sound in scene.alone])
    begin, end = int(skip_s * SPEECH_RATE), min(alone.shape[1], sounds.shape[1])
    return bss_eval(alone[:, begin:end], sounds[:, begin:end])


def separated(scene: Scene, array: MicrophoneArray) -> tuple[NDArray[np.float32], float]:
    """Every talker by himself (K, N), true directions given; and CPU seconds per second."""
    separator = Separator(array, scene.rate)
    blocks = []
    began = time.thread_time()
    for begin in range(0, len(scene.samples) - separator.step + 1, separator.step):
        now = (begin + separator.step) / scene.rate
        sources = [(number, talker.direction(now)) for number, talker in enumerate(scene.talkers)]
        block = scene.samples[begin : begin + separator.step]
        blocks.append(separator.process(block, sources, len(sources)).samples)
    spent = time.thread_time() - began
    return np.concatenate(blocks).T, spent * scene.rate / len(scene.samples)


def summed(scene: Scene, array: MicrophoneArray) -> NDArray[np.float32]:
    """The same by delay and sum."""
    beams = DelayAndSum(array, scene.rate)
    beams.update(scene.samples)
    sounds = [beams.beam(talker.direction(0.0)) for talker in scene.talkers]
    return np.stack([resample_poly(sound, 1, scene.rate // SPEECH_RATE) for sound in sounds])


def tracked(scene: Scene, array: MicrophoneArray) -> tuple[NDArray[np.float32], float]:
    """What the whole pipeline separates, by track (at least as many as there are talkers); and CPU s per s."""
    pipeline = VoicePipeline(array, scene.rate)
    samples = np.round(scene.samples * 32768).astype(np.int16)
    tracks: dict[int, NDArray[np.float32]] = {}
    length = len(samples) * SPEECH_RATE // scene.rate
    spent = 0.0
    for begin in range(0, len(samples) - pipeline.step + 1, pipeline.step):
        began = time.thread_time()
        _, block = pipeline.process(samples[begin : begin + pipeline.step], begin / scene.rate, begin)
        spent += time.thread_time() - began
        if block is None:
            continue
        for column, track in enumerate(block.tracks):
            sound = tracks.setdefault(track, np.zeros(length, np.float32))
            sound[block.first_sample :][: len(block.samples)] = block.samples[:, column] / 32768
    silent = np.random.default_rng(0).normal(0, 1e-6, (len(scene.talkers), length)).astype(np.float32)
    # Of many tracks, those that say most: each talker has one, and an echo says little.
    loudest = sorted(tracks.values(), key=lambda sound: -float(sound @ sound))[: len(scene.talkers) + 1]
    return np.array([*loudest, *silent])[: len(scene.talkers) + 2], spent * scene.rate / len(samples)


def in_rooms(count: int, speech: Path) -> list[Row]:
    """SDR, SIR and CPU in the rooms."""
    rows = []
    cases = ((2, 0.3, 20.0), (2, 0.45, 10.0), (3, 0.3, 20.0))
    for name, array in arrays().items():
        for talkers, rt60_s, snr_db in cases:
            case = f"{name}, {talkers} talkers, RT60 {rt60_s:g} s, {snr_db:g} dB"
            scenes = [cached(r, array.positions, speech) for r in recipes(HELD_OUT, talkers, rt60_s, snr_db, count)]
            ours, cpu = zip(*(separated(scene, array) for scene in scenes), strict=True)
            rows += _scores(case, scenes, ours, [summed(scene, array) for scene in scenes])
            rows.append(row(BENCHMARK, case, "CPU, separation", "ms/s", [1e3 * s for s in cpu]))
        case = f"{name}, 2 talkers by their tracks, RT60 0.3 s, 20 dB"
        scenes = [cached(r, array.positions, speech) for r in recipes(HELD_OUT, 2, 0.3, 20.0, count)]
        found, cpu = zip(*(tracked(scene, array) for scene in scenes), strict=True)
        rows += _scores(case, scenes, found, None, skip_s=1.0)
        rows.append(row(BENCHMARK, case, "CPU, the whole pipeline", "ms/s", [1e3 * s for s in cpu]))
    return rows


def _scores(
    case: str,
    scenes: Sequence[Scene],
    ours: Iterable[NDArray[np.float32]],
    peers: Iterable[NDArray[np.float32]] | None,
    skip_s: float = 0.0,
) -> list[Row]:
    mine = [score(scene, sounds, skip_s) for scene, sounds in zip(scenes, ours, strict=True)]
    theirs = None if peers is None else [score(scene, sounds) for scene, sounds in zip(scenes, peers, strict=True)]
    rows = []
    for metric in ("sdr", "sir"):
        a = [float(getattr(scores, metric).mean()) for scores in mine]
        b = None if theirs is None else [float(getattr(scores, metric).mean()) for scores in theirs]
        # The mean over scenes, as published figures are; a ratio of decibels says nothing.
        peer = None if b is None else float(np.mean(b))
        name = "" if b is None else PEER
        rows.append(Row(BENCHMARK, case, metric.upper(), "dB", float(np.mean(a)), peer, name, None, _spread(a), len(a)))
    return rows


def _spread(values: Sequence[float]) -> float:
    first, middle, third = np.percentile(values, [25, 50, 75])
    return float((third - first) / abs(middle)) if middle else 0.0


def how_soon(count: int, speech: Path) -> list[Row]:
    """Latency from the instant when a talker is first louder than the noise (over 10 ms) to the first message with its
    direction."""
    rows = []
    for rt60_s, snr_db in ((0.3, 20.0), (0.45, 10.0)):
        delays = []
        array = arrays()["IRL-1"]
        for recipe in recipes(HELD_OUT, 1, rt60_s, snr_db, count):
            scene = cached(recipe, array.positions, speech)
            delays.append(1e3 * _delay(scene, array))
        case = f"IRL-1, 1 talker, RT60 {rt60_s:g} s, {snr_db:g} dB"
        rows.append(row(BENCHMARK, case, "onset to first percept, p50", "ms", [float(np.percentile(delays, 50))]))
        rows.append(row(BENCHMARK, case, "onset to first percept, p95", "ms", [float(np.percentile(delays, 95))]))
    return rows


def _delay(scene: Scene, array: MicrophoneArray) -> float:
    """Seconds, computing included; infinite without such a message."""
    rng = np.random.default_rng(1)
    noise = float(np.sqrt(np.mean((scene.samples[:, 0] - scene.alone.sum(0)) ** 2)))
    quiet = rng.normal(0, noise, (int(QUIET_S * scene.rate), len(array)))
    sound = np.round(32768 * np.concatenate([quiet, scene.samples])).astype(np.int16)
    (talker,) = scene.talkers
    frame = scene.rate // 100
    alone = scene.alone[0][: scene.alone.shape[1] // frame * frame].reshape(-1, frame)
    sounded = QUIET_S + float(np.flatnonzero((alone**2).mean(1) > noise**2)[0]) * 0.01
    pipeline = VoicePipeline(array, scene.rate, PipelineSettings(separation=False))
    for begin in range(0, len(sound) - pipeline.step + 1, pipeline.step):
        began = time.thread_time()
        result, _ = pipeline.process(sound[begin : begin + pipeline.step], begin / scene.rate, begin)
        now = (begin + pipeline.step) / scene.rate
        direction = talker.direction(now - QUIET_S)
        if now > sounded and any(np.dot(s.direction, direction) > np.cos(np.radians(20)) for s in result.sources):
            return now - sounded + time.thread_time() - began
    return float("inf")


def of_speech(seconds: float, speech: Path) -> list[Row]:
    """What Silero's network, as it is run here, takes for voices."""
    shares, cpu = [], []
    for path in sorted([*speech.glob("*.wav"), *speech.glob("*.flac")]):
        found, levels, spent = _judged(path, seconds)
        loud = levels > levels.max() - 30
        shares.append(100 * float((found[loud] > 0.5).mean()))
        cpu.append(1e3 * spent)
    rows = [
        row(BENCHMARK, "recorded speech", "taken for voices, median file", "%", shares),
        row(BENCHMARK, "recorded speech", "taken for voices, worst file", "%", [min(shares)]),
        row(BENCHMARK, "recorded speech", "CPU, each source", "ms/s", cpu),
    ]
    for path in sorted((speech / "noise").glob("*.wav")):
        found, _, _ = _judged(path, 10 * seconds)
        rows.append(row(BENCHMARK, path.stem, "taken for voices", "%", [100 * float((found > 0.5).mean())]))
    return rows


def _judged(path: Path, seconds: float) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Each judgement of a recording, its level (dB), and CPU seconds per second."""
    sound, rate = soundfile.read(path, dtype="float32", always_2d=True)
    sound = Resampler(rate, SPEECH_RATE).process(np.ascontiguousarray(sound.mean(1)))[: int(seconds * SPEECH_RATE)]
    chunks = sound[: len(sound) // CHUNK * CHUNK].reshape(-1, CHUNK)
    detector = VoiceActivityDetector(window=1)
    found = []
    began = time.thread_time()
    for chunk in chunks:
        detector.update({1: chunk})
        found.append(detector.speech(1))
    spent = time.thread_time() - began
    levels = 10 * np.log10((chunks.astype(np.float64) ** 2).mean(1) + 1e-12)
    return np.array(found), levels, spent * SPEECH_RATE / chunks.size


def measure(quick: bool) -> list[Row]:
    """All rows; a few minutes the first time (rooms are kept), in quick under a minute."""
    speech = reference_speech()
    if not speech.is_dir():
        raise SystemExit(f"no recorded speech in {speech}; HBBA_REFERENCE_DATA names the folder of reference data")
    count = 2 if quick else 8
    return in_rooms(count, speech) + how_soon(3 if quick else 20, speech) + of_speech(5.0 if quick else 60.0, speech)


if __name__ == "__main__":
    raise SystemExit(benchmark_main(__doc__, measure))
