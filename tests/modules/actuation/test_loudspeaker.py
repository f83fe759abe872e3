from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

from app.messages import Audio
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, FakeLink

MODULE = "app.modules.actuation.loudspeaker:Loudspeaker"


class SpeakingLink(FakeLink):
    """A body that notes what it plays."""

    def __init__(self, *, loudspeaker: bool) -> None:
        super().__init__()
        self.description = replace(self.description, loudspeaker=loudspeaker)
        self.played: list[Audio] = []

    def play(self, audio: Audio) -> None:
        self.played.append(audio)


def voice(number: int) -> Audio:
    return Audio(
        100.0 + 0.02 * number, "operator", np.zeros((320, 1), np.int16), 16_000, 320 * number, np.zeros((0, 3))
    )


async def speak(link: SpeakingLink, count: int) -> Bench:
    bench = Bench(MODULE, inputs={"voice": Audio}, link=link)
    async with bench:
        for number in range(count):
            bench.feed("voice", voice(number))
        await bench.settle()
    return bench


def test_what_is_said_is_played_in_order() -> None:
    link = SpeakingLink(loudspeaker=True)
    run_virtual(speak(link, 5))
    assert [audio.first_sample for audio in link.played] == [0, 320, 640, 960, 1280]


def test_more_than_half_a_second_at_once_is_no_failure() -> None:
    link = SpeakingLink(loudspeaker=True)
    bench = run_virtual(speak(link, 60))
    assert bench.problem == ""
    assert len(link.played) == 50


def test_a_body_without_a_loudspeaker_says_so_once(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING, "hbba.Tested")
    bench = run_virtual(speak(SpeakingLink(loudspeaker=False), 3))
    assert [record.message for record in caplog.records] == ["a test body has no loudspeaker: the voice is not played"]
    assert bench.problem == ""
