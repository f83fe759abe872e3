"""WordRecognizer: answers, what is unsure, talk, the robot's own voice; and real words in a real room."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Any, TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import resample_poly

from app.attention.desires import InvalidDesire
from app.base.geometry import Pose3
from app.messages import Audio, HeardWords
from app.modules.perception.word_recognizer import LISTEN_FOR_WORDS, phrases_of
from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.simulated.acoustics.offline_rendering import OfflineSource, render_scene
from app.robots.simulated.acoustics.room import Shoebox
from app.runtime.clock import run_virtual
from app.speech.espeak import Espeak
from app.speech.recognition import Recognition, RecognitionError
from app.speech.recognition_process import RecognitionProcess
from tests.modules.fakes import Bench, drain
from tests.modules.perception.voices.sounds import CORNERS, RATE, as_int16, heard, toward
from tests.modules.perception.words.test_utterance_listener import noisy, quiet, speech

T = TypeVar("T")
P_BM = CORNERS + np.array([0.0, 0.0, 0.4])


class FakeRecognizer:
    """In place of the recognizer's process: gives ``found`` for every utterance."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, found: Recognition | Exception | None) -> None:
        self.found = found
        #: Length (s) and phrases of each utterance.
        self.asked: list[tuple[float, tuple[str, ...]]] = []
        monkeypatch.setattr(RecognitionProcess, "recognize", lambda _, *arguments: self.recognize(*arguments))

    def recognize(self, samples: NDArray[np.int16], phrases: Sequence[str], language: str) -> Recognition | None:
        if isinstance(self.found, Exception):
            raise self.found
        if not len(samples):
            return None
        self.asked.append((len(samples) / 16_000, tuple(phrases)))
        return self.found


def listening(script: Callable[[Bench], Awaitable[T]], **settings: Any) -> T:
    async def main() -> T:
        bench = Bench(
            "app.modules.perception.word_recognizer:WordRecognizer",
            inputs={"audio": Audio, "played": Audio},
            outputs={"words": HeardWords},
            settings=settings,
        )
        async with bench:
            return await script(bench)

    return run_virtual(main())


async def play(bench: Bench, sound: NDArray[np.float32], own: NDArray[np.float32] | None = None) -> None:
    """Feed the microphones with ``sound`` (N, 8), and the loudspeaker's frames where ``own`` (N,) is not silent."""
    samples, size = as_int16(sound), 512
    for at in range(0, len(samples) - size + 1, size):
        if own is not None and own[at : at + size].any():
            frame = as_int16(own[at : at + size])[:, None]
            bench.feed("played", Audio(at / RATE, "loudspeaker", frame, RATE, at, np.zeros((0, 3))))
        bench.feed("audio", Audio(at / RATE, "microphones", samples[at : at + size], RATE, at, P_BM))
        await bench.settle()


def one_word(azimuth_deg: float = 60.0) -> NDArray[np.float32]:
    """An utterance of 0.8 s after a second of noise."""
    return noisy(heard(np.concatenate([quiet(1.0), speech(0.6, 0.8), quiet(1.2)]), toward(azimuth_deg)))


@pytest.mark.slow
def test_an_answer_has_its_word_time_and_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = FakeRecognizer(monkeypatch, Recognition("no", 0.95))
    sound = one_word()

    async def script(bench: Bench) -> list[HeardWords]:
        words = bench.listen("words")
        await play(bench, sound)
        return drain(words)

    (found,) = listening(script)
    assert (found.text, found.unsure, found.likeliest, found.confidence) == ("no", False, "no", 0.95)
    assert (found.words, found.language) == (("yes", "no"), "en")
    assert 0.7 < found.stamp < 1.4
    assert np.dot(found.direction, toward(60)) > np.cos(np.radians(8))
    ((seconds, phrases),) = fake.asked
    assert 0.5 < seconds < 1.6
    assert phrases == ("yes", "no")


@pytest.mark.slow
def test_what_is_unsure_has_no_text(monkeypatch: pytest.MonkeyPatch) -> None:
    FakeRecognizer(monkeypatch, Recognition("no", 0.6))
    sound = one_word()

    async def script(bench: Bench) -> list[HeardWords]:
        words = bench.listen("words")
        await play(bench, sound)
        return drain(words)

    (found,) = listening(script, sure=0.7)
    assert (found.text, found.unsure, found.likeliest, found.confidence) == ("", True, "no", 0.6)


@pytest.mark.slow
def test_the_robot_does_not_answer_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    fake = FakeRecognizer(monkeypatch, Recognition("yes", 1.0))

    sound = one_word()
    own = np.zeros(len(sound), np.float32)
    own[RATE // 2 : round(1.7 * RATE)] = 0.1

    async def script(bench: Bench) -> list[HeardWords]:
        words = bench.listen("words")
        await play(bench, sound, own)
        return drain(words)

    assert listening(script) == []
    assert fake.asked == []


@pytest.mark.slow
def test_where_words_cannot_be_recognized_all_is_unsure_and_said_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    FakeRecognizer(monkeypatch, RecognitionError("recognizing words needs PocketSphinx"))
    sound = one_word()

    async def script(bench: Bench) -> list[HeardWords]:
        words = bench.listen("words")
        await play(bench, sound)
        return drain(words)

    (found,) = listening(script)
    assert (found.text, found.unsure, found.likeliest, found.confidence) == ("", True, "", 0.0)
    assert len([r for r in caplog.records if "needs PocketSphinx" in r.getMessage()]) == 1


def test_words_are_a_list_with_commas() -> None:
    assert phrases_of(" Yes, no ,yes,, Coffee  room") == ("yes", "no", "coffee room")
    assert LISTEN_FOR_WORDS.validated({"words": "kitchen, l'atelier"})["words"] == "kitchen, l'atelier"


@pytest.mark.parametrize("words", ["", " , ", ",".join("abcdefghijklmnopqrstu"), "yes; no", "a | b"])
def test_other_lists_are_refused(words: str) -> None:
    with pytest.raises(InvalidDesire, match="words: must be"):
        LISTEN_FOR_WORDS.validated({"words": words})


def test_one_microphone_is_too_few(monkeypatch: pytest.MonkeyPatch) -> None:
    FakeRecognizer(monkeypatch, None)

    async def script(bench: Bench) -> str:
        bench.feed("audio", Audio(0.0, "microphones", np.zeros((512, 1), np.int16), RATE, 0, P_BM[:1]))
        await bench.settle()
        return bench.problem

    assert "words cannot be heard with these microphones" in listening(script)


@pytest.mark.slow
@pytest.mark.parametrize(("word", "azimuth_deg"), [("yes", 50.0), ("no", -100.0), ("wait", 160.0)])
def test_a_word_said_in_a_room_is_heard_around_the_torso(word: str, azimuth_deg: float) -> None:
    pytest.importorskip("pocketsphinx")
    pytest.importorskip("espeakng_loader")
    utterance = Espeak("m3").synthesize(word, "en-us")
    said = resample_poly(utterance.samples / 32768.0, 320, 147).astype(np.float32) * 0.2
    away = 1.6 * np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg)), 0.6])
    source = OfflineSource(said, np.array([3.0, 2.5, 1.0]) + away, begin_s=1.2, looks="listener")
    array = BaffledMicrophones(CORNERS, RATE, shadow=True)
    room = Shoebox(corner=(0, 0, 0), size=(6, 5, 3), rt60_s=(0.45, 0.40))
    seconds = 1.2 + len(said) / RATE + 1.0
    sound, _ = render_scene([source], Pose3.from_translation_rpy((3, 2.5, 1.0)), room, seconds, array, noise=0.0005)

    async def script(bench: Bench) -> list[HeardWords]:
        bench.slot.configure({"words": "yes, no, next, again, come, wait"})
        words = bench.listen("words")
        await play(bench, sound.T)
        return drain(words)

    (found,) = listening(script, body_m=0.17)
    assert (found.text, found.unsure) == (word, False), found
    assert np.degrees(np.arccos(np.dot(found.direction, away / np.linalg.norm(away)))) < 15
