"""The whole way in the simulated lab: from a desire to the microphones, to people's headphones, and not to voices."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from app.attention.desires import Source
from app.base import paths
from app.experiments.world_run import WorldRun, run_in_world
from app.messages import Audio, SoundSources, Speech
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.speech.config import EspeakConfig
from app.speech.manner import USUAL, Manner
from app.speech.utterance import MouthMoment, Utterance
from app.speech.visemes import Viseme

T = TypeVar("T")
RATE = 16_000
SPOKEN_S = 2.0
#: The chain of modules that speak and hear.
MODULES = ("Microphones", "WheelOdometry", "AudioStream", "VoiceLocalizer", "Loudspeaker", "Say")


class Babble:
    """An engine that says any text as the same two seconds of noise with the loudness of syllables."""

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        return Utterance(text, babble(), RATE, duration_s=SPOKEN_S, words=(), mouth=(MouthMoment(0.0, Viseme.OPEN),))


def babble() -> NDArray[np.int16]:
    times = np.arange(round(SPOKEN_S * RATE)) / RATE
    noise = np.random.default_rng(5).normal(size=times.size) * (0.15 + 0.85 * np.sin(2 * np.pi * 2.0 * times) ** 2)
    colored = np.convolve(noise, np.hanning(9) / np.hanning(9).sum(), "same")
    return np.asarray(np.clip(9000 * colored / colored.std() * 0.5, -32768, 32767), np.int16)


@pytest.fixture(autouse=True)
def _engine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EspeakConfig, "make", lambda _: Babble())


def in_the_lab(script: Callable[[WorldRun], Awaitable[T]]) -> T:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    modules = {name: spec for name, spec in configuration.program.modules.items() if name in MODULES}
    configuration = replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    return run_in_world(configuration, body.model_copy(update={"scenario": None}), script, microphones=True)


def desire(run: WorldRun, cls: str, **params: object) -> str:
    return run.system.workspace.add(cls, intensity=8, utility=1, params=params, source=Source("rest", "test")).id


def joined(frames: list[Audio]) -> tuple[int, NDArray[np.float64]]:
    """Samples (N, C) of frames without a gap, full scale 1, and the number of the first."""
    for before, after in pairwise(frames):
        assert after.first_sample == before.first_sample + len(before.samples)
    return frames[0].first_sample, np.concatenate([frame.samples for frame in frames]) / 32768.0


def level_db(sound: NDArray[np.float64]) -> float:
    return float(10 * np.log10(np.mean(sound**2)))


@pytest.mark.slow
def test_a_sentence_is_heard_at_the_robot_from_its_loudspeaker_and_by_people() -> None:
    async def script(run: WorldRun) -> tuple[list[Audio], list[Audio], list[Audio], list[Speech]]:
        found: dict[str, list[Any]] = {name: [] for name in ("microphones", "robot_audio", "played_sound", "speech")}
        channels = run.system.graph.channels
        for name, messages in found.items():
            channels[name].observe(messages.append)
            channels[name].subscribe(f"test.{name}", capacity=1)
        desire(run, "Listen")
        await run.system.clock.sleep(1.0)
        said = desire(run, "Say", text="Hello.")
        await run.system.clock.sleep(SPOKEN_S + 1.0)
        assert said not in {one.id for one in run.system.workspace.desires()}
        return found["microphones"], found["robot_audio"], found["played_sound"], found["speech"]

    microphones, people, played, speech = in_the_lab(script)
    first, sound = joined(microphones)
    first_played, reference = joined(played)
    begin = first_played - first
    assert len(reference) == pytest.approx(SPOKEN_S * 48_000, abs=2000)

    # As loud as it should be: -20 dB at 1 m of full scale, at each microphone's distance.
    p_BS = microphones[0].p_BM.mean(axis=0) + np.array([0.1, 0.0, 0.005])
    heard = sound[begin : begin + len(reference)]
    for number, p in enumerate(microphones[0].p_BM):
        expected_db = level_db(reference) - 20 - 20 * np.log10(np.linalg.norm(p - p_BS))
        assert level_db(heard[:, number]) == pytest.approx(expected_db, abs=2.5)
    assert level_db(sound[: begin - 4800]) < level_db(heard) - 20

    # At its time: the nearest microphones first, each by its distance at the speed of sound.
    for number, p in enumerate(microphones[0].p_BM):
        n = 24_000
        match = fftconvolve(heard[:n, number], reference[: n - 2000, 0][::-1])
        delay = int(np.argmax(np.abs(match))) - (n - 2001)
        assert delay == pytest.approx(np.linalg.norm(p - p_BS) / 343.0 * 48_000, abs=3)

    # It is in the sound for people, and the subtitle lasts as long as the sound.
    _, stream = joined(people)
    assert level_db(stream) > level_db(sound[:, 0]) + 6
    speaking = [s for s in speech if s.state == "speaking"]
    assert {s.text for s in speaking} == {"Hello."}
    ended = next(s.stamp for s in speech if s.state == "silent" and s.stamp > speaking[0].stamp)
    assert ended - speaking[0].stamp == pytest.approx(SPOKEN_S, abs=0.2)


@pytest.mark.slow
def test_the_robots_own_voice_is_nobodys() -> None:
    async def script(run: WorldRun) -> tuple[float, list[SoundSources]]:
        found: list[SoundSources] = []
        channel = run.system.graph.channels["sound_sources"]
        channel.observe(found.append)
        channel.subscribe("test", capacity=1)
        desire(run, "LocateVoices")
        await run.system.clock.sleep(1.0)
        began = run.system.clock.now()
        desire(run, "Say", text="One. Two.")
        await run.system.clock.sleep(2 * SPOKEN_S + 0.5)
        return began, found

    began, sources = in_the_lab(script)
    # The fans are heard before; and the first moments, in which nothing is known of the echo, are discarded.
    meanwhile = [message for message in sources if message.stamp > began + 1.0]
    assert len(meanwhile) > 60
    active = [source for message in meanwhile for source in message.sources if source.active]
    # Without the filter there are three and more at each instant.
    assert len(active) < 0.05 * len(meanwhile)
