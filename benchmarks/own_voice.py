"""The robot's own voice in its microphones: how much of it is removed, and whether a talker meanwhile is located.

Eight microphones on the corners of a box of 0.2 x 0.3 x 0.4 m, a loudspeaker 0.18 m ahead of their middle, in a room of
6 x 5 x 3 m by image sources. The robot says a sentence of 6 s, then another of 8 s; from 4 s on a person talks, 60
degrees aside, 1.2 to 1.8 m away, with noise 30 dB below. Both are recorded speech, of different people, the echo 6 to
10 dB above the talker. Everything else is drawn from the scene's number. Sound is at 16 kHz.

The same again while the robot drives through the second sentence, at 0.3 m/s: the talker, who stands, is 60 degrees
aside half way through what he says. The room's responses are those of a pose every 4 cm, with a linear crossfade
between.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyroomacoustics as pra
import soundfile
from numpy.typing import NDArray
from scipy.signal import fftconvolve, resample_poly

from app.base.geometry import wrap_angle
from app.messages import SoundSource
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.own_voice import EchoCanceller, OwnVoiceFilter
from app.modules.perception.voices.pipeline import PipelineSettings, VoicePipeline
from app.robots.simulated.acoustics.sound_library import SPEECH
from benchmarks.report import Row, benchmark_main, row
from benchmarks.voice_rooms import BOX

RATE = 16_000
FRAME = 512
ROOM = (6.0, 5.0, 3.0)
BEFORE_S, SPEAKS_S, TALKS_FROM_S = 6.0, 8.0, 4.0
ROBOT = ("kennedy_1", "kennedy_2", "kennedy_3")
TALKERS = ("austen_1", "austen_2", "austen_3")
#: A source within this (degrees) of the talker is the talker; a voice by its probability of being speech.
NEAR_DEG, VOICE = 20.0, 0.5
DRIVES_MPS, HOP_S, MARGIN_M = 0.3, 0.125, 0.4
Sound = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Scene:
    """``played`` (N,), its ``echo`` and the ``talker`` (8, N) with noise; ``azimuths`` of the talker (rad), one every
    ``HOP_S`` of the second sentence."""

    played: Sound
    echo: Sound
    talker: Sound
    azimuths: Sound

    def azimuth(self, time_s: float) -> float:
        """Azimuth (rad) of the talker ``time_s`` after the second sentence began."""
        hop = round(time_s / HOP_S)
        return float(self.azimuths[min(max(hop, 0), len(self.azimuths) - 1)])


@dataclass(frozen=True, slots=True)
class Result:
    """Echo return loss enhancement (dB) over 0.5 to 2 s and 2 to 4 s, for a filter that begins and one that is kept;
    shares of the instants (0 to 1) at which the talker is located, at which a voice is before he talks, and at which a
    voice is elsewhere while both speak."""

    cold_db: tuple[float, float]
    warm_db: tuple[float, float]
    located: float
    own_voices: float
    elsewhere: float
    cpu_ms_per_s: float


def spoken(names: tuple[str, ...], seconds: float, level: float) -> Sound:
    """Recorded speech, one file after the other, ``level`` of its active parts."""
    sound = np.concatenate([soundfile.read(SPEECH / f"{name}.flac")[0] for name in names])
    active = np.abs(sound) > 0.05 * np.abs(sound).max()
    return np.asarray(np.resize(sound / np.sqrt((sound[active] ** 2).mean()) * level, round(seconds * RATE)))


def draw(number: int, rt60_s: float, speed_mps: float = 0.0) -> Scene:
    """Scene ``number``: the sentence before and the one that is judged, through which the robot drives at
    ``speed_mps``, one after the other."""
    rng = np.random.default_rng([2026, number])
    inside = False
    while not inside:
        middle = np.array([*rng.uniform([2.2, 2.0], [3.8, 3.0]), 1.0])
        heading = rng.uniform(-np.pi, np.pi)
        c, s = math.cos(heading), math.sin(heading)
        R_WB = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        aside = math.radians(60) * rng.choice([-1, 1])
        distance = rng.uniform(1.2, 1.8)
        # Half way through what the talker says the robot is where it stands otherwise.
        ahead_m = speed_mps * (np.arange(0.0, SPEAKS_S + HOP_S, HOP_S) - (TALKS_FROM_S + SPEAKS_S) / 2)
        ahead_m = ahead_m[: 1 if speed_mps == 0.0 else None]
        places = middle + ahead_m[:, None] * R_WB[:, 0]
        mouth = middle + R_WB @ [distance * math.cos(aside), distance * math.sin(aside), 0.6]
        ways = np.vstack([places, mouth])[:, :2]
        inside = speed_mps == 0.0 or bool(((ways > MARGIN_M) & (ways < np.array(ROOM[:2]) - MARGIN_M)).all())
    toward = (mouth - places) @ R_WB
    responses = [_responses(rt60_s, place, R_WB, mouth) for place in places]
    length = round((BEFORE_S + SPEAKS_S) * RATE)
    played = spoken(tuple(rng.permutation(ROBOT)), BEFORE_S + SPEAKS_S, 0.1)
    begins = round((BEFORE_S + TALKS_FROM_S) * RATE)
    dry = np.zeros(length)
    dry[begins:] = spoken(tuple(rng.permutation(TALKERS)), SPEAKS_S - TALKS_FROM_S, 0.1)
    echo, talker = (_moving(sound, [each[source] for each in responses]) for source, sound in ((0, played), (1, dry)))
    talker *= np.std(echo) / np.std(talker[:, begins:]) * 10 ** (-rng.uniform(6, 10) / 20)
    talker += rng.normal(0, np.std(talker[:, begins:]) * 10 ** (-30 / 20), talker.shape)
    scale = 0.3 / np.abs(echo + talker).max()
    return Scene(played * scale, echo * scale, talker * scale, np.arctan2(toward[:, 1], toward[:, 0]))


def _responses(rt60_s: float, place: Sound, R_WB: Sound, mouth: Sound) -> tuple[list[Sound], list[Sound]]:
    """The room's responses from the loudspeaker, and from ``mouth``, to each microphone of the robot at ``place``."""
    absorption, order = pra.inverse_sabine(rt60_s, ROOM)
    room = pra.ShoeBox(ROOM, fs=RATE, materials=pra.Material(absorption), max_order=min(order, 17), air_absorption=True)
    room.add_source(place + R_WB @ [0.18, 0.0, 0.05])
    room.add_source(mouth)
    room.add_microphone_array((BOX @ R_WB.T + place).T)
    room.compute_rir()
    loudspeaker, talker = ([room.rir[m][source] for m in range(len(BOX))] for source in (0, 1))
    return loudspeaker, talker


def _moving(sound: Sound, responses: Sequence[Sequence[Sound]]) -> Sound:
    """``sound`` (N,) at each microphone (8, N), whose responses change every ``HOP_S`` of the second sentence."""
    times = np.arange(len(sound)) / RATE - BEFORE_S
    heard = np.zeros((len(BOX), len(sound)))
    for hop, each in enumerate(responses):
        weight = np.clip(1.0 - np.abs(times / HOP_S - hop), 0.0, 1.0)
        if hop == 0:
            weight[times < 0] = 1.0
        if hop == len(responses) - 1:
            weight[times > hop * HOP_S] = 1.0
        at = np.flatnonzero(weight)
        first, last = at[0], at[-1] + 1
        for m, response in enumerate(each):
            part = fftconvolve(sound[first:last] * weight[first:last], response)[: len(sound) - first]
            heard[m, first : first + len(part)] += part
    return heard


def judge(number: int, rt60_s: float, speed_mps: float = 0.0) -> Result:
    """Scene ``number`` through the filter and the localization."""
    scene = draw(number, rt60_s, speed_mps)
    second = round(BEFORE_S * RATE)
    cold = _enhancement(EchoCanceller(len(BOX), FRAME), scene, second)
    warm_canceller = EchoCanceller(len(BOX), FRAME)
    _enhancement(warm_canceller, scene, 0)
    warm = _enhancement(warm_canceller, scene, second)
    located, own_voices, elsewhere, cpu = _heard(scene)
    return Result(cold, warm, located, own_voices, elsewhere, cpu_ms_per_s=cpu)


def _enhancement(canceller: EchoCanceller, scene: Scene, begin: int) -> tuple[float, float]:
    """Enhancement over 0.5 to 2 s and 2 to 4 s after sample ``begin``, while nobody talks."""
    canceller.forget_past()
    end = begin + round(TALKS_FROM_S * RATE)
    heard = (scene.echo + scene.talker).astype(np.float32)
    rest = [
        canceller.process(scene.played[i : i + FRAME].astype(np.float32), heard[:, i : i + FRAME])
        for i in range(begin, end - FRAME + 1, FRAME)
    ]
    left = np.concatenate(rest, axis=1)
    parts = [(round(a * RATE), round(b * RATE)) for a, b in ((0.5, 2.0), (2.0, 3.9))]
    one, two = (
        10 * math.log10((scene.echo[:, begin + a : begin + b] ** 2).sum() / (left[:, a:b] ** 2).sum()) for a, b in parts
    )
    return one, two


def _heard(scene: Scene) -> tuple[float, float, float, float]:
    """Shares of instants with the talker located, with a voice before he talks, and with a voice elsewhere while he
    does; the filter's CPU time (ms/s)."""
    own_voice = OwnVoiceFilter(len(BOX), RATE)
    pipeline = VoicePipeline(MicrophoneArray(BOX + np.array([0.0, 0.0, 1.0])), RATE, PipelineSettings(separation=False))
    sound = np.clip(np.rint((scene.echo + scene.talker).T * 32768), -32768, 32767).astype(np.int16)
    played = np.clip(np.rint(scene.played * 32768), -32768, 32767).astype(np.int16)
    waiting = np.zeros((0, len(BOX)), np.int16)
    talks = _active(scene.talker[0])
    located, own_voices, elsewhere = [], [], []
    cpu_s, at = 0.0, 0
    for begin in range(0, len(sound) - FRAME + 1, FRAME):
        frame = begin, played[begin : begin + FRAME]
        before = time.thread_time()
        _, clean = own_voice.process(begin, sound[begin : begin + FRAME], [frame])
        cpu_s += time.thread_time() - before
        waiting = np.concatenate([waiting, clean])
        while len(waiting) >= pipeline.step:
            sources, _ = pipeline.process(waiting[: pipeline.step], at / RATE, at, own_noise=True)
            waiting, at = waiting[pipeline.step :], at + pipeline.step
            active = [source for source in sources.sources if source.active]
            time_s = sources.stamp - BEFORE_S
            if 0 <= time_s < TALKS_FROM_S:
                own_voices.append(any(source.speech >= VOICE for source in active))
            elif time_s > TALKS_FROM_S + 0.5:
                near = [_near(source, scene.azimuth(time_s)) for source in active]
                voices = [source.speech >= VOICE for source in active]
                elsewhere.append(any(voice and not at for voice, at in zip(voices, near, strict=True)))
                if talks[min(int(sources.stamp * RATE), len(talks) - 1)]:
                    located.append(any(near))
    cpu_ms_per_s = 1000 * cpu_s / (len(sound) / RATE)
    return float(np.mean(located)), float(np.mean(own_voices)), float(np.mean(elsewhere)), cpu_ms_per_s


def _cpu_ms_per_s(scene: Scene, times: int) -> float:
    """CPU time (ms/s) of the filter on the scene at ``times`` the rate."""
    own_voice = OwnVoiceFilter(len(BOX), times * RATE)
    sound, played = (
        np.clip(np.rint(resample_poly(part, times, 1, axis=0) * 32768), -32768, 32767).astype(np.int16)
        for part in ((scene.echo + scene.talker).T, scene.played)
    )
    frame = times * FRAME
    before = time.thread_time()
    for begin in range(0, len(sound) - frame + 1, frame):
        own_voice.process(begin, sound[begin : begin + frame], [(begin, played[begin : begin + frame])])
    return 1000 * (time.thread_time() - before) / (len(sound) / (times * RATE))


def _near(source: SoundSource, azimuth: float) -> bool:
    off = math.atan2(source.direction[1], source.direction[0]) - azimuth
    return abs(wrap_angle(off)) < math.radians(NEAR_DEG)


def _active(sound: Sound) -> NDArray[np.bool_]:
    """Whether the talker is louder than a third of his loudest quarter second, within 0.1 s."""
    power = np.convolve(sound**2, np.ones(1600) / 1600, "same")
    return np.asarray(power > 0.1 * np.convolve(sound**2, np.ones(4000) / 4000, "same").max())


def measure(quick: bool) -> list[Row]:
    """The rows of all scenes."""
    scenes = range(4 if quick else 30)
    rows = []
    for rt60_s, speed_mps in ((0.3, 0.0),) if quick else ((0.3, 0.0), (0.45, 0.0), (0.3, DRIVES_MPS)):
        case = f"RT60 {rt60_s} s" + (", driving" if speed_mps else "")
        results = []
        for number in scenes:
            results.append(judge(number, rt60_s, speed_mps))
            print(f"{case}, scene {number}: {results[-1]}", file=sys.stderr, flush=True)
        rows += _rows(case, results)
    first = [draw(number, 0.3) for number in list(scenes)[:4]]
    for times in (1, 3):
        cpu = [_cpu_ms_per_s(scene, times) for scene in first]
        rows.append(row("own voice", f"{times * RATE // 1000} kHz", "CPU of the filter alone", "ms/s", cpu))
    return rows


def _rows(case: str, results: Sequence[Result]) -> list[Row]:
    figures = {
        ("echo removed, 0.5 to 2 s after the first word", "dB"): [r.cold_db[0] for r in results],
        ("echo removed, 2 to 4 s", "dB"): [r.cold_db[1] for r in results],
        ("echo removed in the next sentence, 0.5 to 2 s", "dB"): [r.warm_db[0] for r in results],
        ("echo removed in the next sentence, 2 to 4 s", "dB"): [r.warm_db[1] for r in results],
        ("instants at which the talker is located", "%"): [100 * r.located for r in results],
        ("own voice taken for a voice", "% of instants"): [100 * r.own_voices for r in results],
        ("a voice elsewhere while both speak", "% of instants"): [100 * r.elsewhere for r in results],
        ("CPU of the filter, eight microphones", "ms/s"): [r.cpu_ms_per_s for r in results],
    }
    rows = [row("own voice", case, metric, unit, values) for (metric, unit), values in figures.items()]
    found = 100 * float(np.mean([r.located >= 0.5 for r in results]))
    return [*rows, row("own voice", case, "scenes with the talker located at half of the instants", "%", [found])]


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__ or "", measure))
