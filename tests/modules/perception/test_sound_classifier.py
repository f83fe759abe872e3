"""SoundClassifier: what it hears each quarter of a second, what events are made of it, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from app.messages import Audio, PerceptEvent, SoundClass
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain

RATE = 48_000
P_BM = np.zeros((8, 3))


def bench(**settings: Any) -> Bench:
    return Bench(
        "app.modules.perception.sound_classifier:SoundClassifier",
        inputs={"audio": Audio},
        outputs={"classes": SoundClass},
        settings=settings,
    )


def noise(seconds: float, level: float) -> NDArray[np.int16]:
    return np.random.default_rng(1).normal(0, level, round(seconds * RATE)).astype(np.int16)


def tone(seconds: float, hz: float = 1000.0) -> NDArray[np.int16]:
    times = np.arange(round(seconds * RATE)) / RATE
    return (3000 * np.sin(2 * np.pi * hz * times)).astype(np.int16)


async def play(b: Bench, sound: NDArray[np.int16], *, first: int = 0, rate: int = RATE, size: int = 512) -> None:
    """Feed ``sound`` on the second of two microphones."""
    for at in range(0, len(sound) - size + 1, size):
        samples = np.zeros((size, 2), np.int16)
        samples[:, 1] = sound[at : at + size]
        b.feed("audio", Audio((first + at) / rate, "microphones", samples, rate, first + at, P_BM[:2]))
        await b.settle()


def test_each_quarter_of_a_second_it_says_what_the_last_second_was() -> None:
    async def main() -> None:
        async with bench(microphone=1) as b:
            classes = b.listen("classes")
            await play(b, np.concatenate((noise(2.0, 5.0), tone(3.0), noise(3.0, 1000.0))))
            found = drain(classes)
            names = [message.name for message in found]
            assert names[:4] == ["silence"] * 4
            assert names[9:15] == ["tonal"] * 6
            assert names[-5:] == ["broadband"] * 5
            assert np.diff([message.stamp for message in found]) == pytest.approx(0.25, abs=512 / RATE)
            assert found[0].stamp == pytest.approx(1.0, abs=512 / RATE)
            tonal, white = found[12], found[-1]
            assert (tonal.frame, tonal.centroid_hz) == ("microphones", pytest.approx(1000, abs=25))
            assert tonal.flatness < 0.01 < 0.4 < white.flatness
            assert white.rolloff_hz == pytest.approx(0.2e3 + 0.85 * 7.8e3, rel=0.05)

    run_virtual(main())


@pytest.mark.parametrize("size", [480, 512, 4096])
def test_the_size_of_frames_changes_nothing(size: int) -> None:
    async def main() -> None:
        async with bench(microphone=1) as b:
            classes = b.listen("classes")
            await play(b, tone(4.0), size=size)
            assert {message.name for message in drain(classes)} == {"tonal"}

    run_virtual(main())


def test_after_a_gap_nothing_is_said_of_what_was_before() -> None:
    async def main() -> None:
        async with bench(microphone=1) as b:
            classes = b.listen("classes")
            await play(b, tone(1.5))
            assert {message.name for message in drain(classes)} == {"tonal"}
            await play(b, noise(0.9, 5.0), first=10 * RATE)
            assert drain(classes) == []
            await play(b, noise(0.5, 5.0), first=10 * RATE + round(0.9 * RATE) // 512 * 512)
            assert {message.name for message in drain(classes)} == {"silence"}

    run_virtual(main())


@pytest.mark.parametrize(
    ("settings", "rate", "words"),
    [({"microphone": 2}, RATE, "set `microphone` to 0 … 1"), ({}, 8000, "needs 16000 at least")],
)
def test_what_it_cannot_work_with_is_said(settings: dict[str, int], rate: int, words: str) -> None:
    async def main() -> None:
        async with bench(**settings) as b:
            await play(b, tone(0.1), rate=rate)
            assert words in b.problem

    run_virtual(main())


def test_a_class_appears_and_leaves_as_events() -> None:
    def look(step: int, name: str) -> SoundClass:
        return SoundClass(step / 4, "microphones", name, -30.0, 1000.0, 2000.0, 0.1, 3.0)

    async def main() -> None:
        inputs = {"sound_class": SoundClass}
        async with Bench(
            "app.modules.perception.percept_events:PerceptEvents", inputs=inputs, outputs={"events": PerceptEvent}
        ) as b:
            events = b.listen("events")
            names = ["silence", "voice-like", *["tonal"] * 6, "silence", "tonal", *["silence"] * 5]
            for step, name in enumerate(names):
                b.feed("sound_class", look(step, name))
                await b.settle()
            found = [(event.stamp, event.name, event.subject, event.source) for event in drain(events)]
            assert found == [
                (0.75, "sound.appears", "tonal", "microphones"),
                (2.75, "sound.leaves", "tonal", "microphones"),
            ]

    run_virtual(main())
