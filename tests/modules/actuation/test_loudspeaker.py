from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest

from app.link import StreamDescription
from app.messages import Audio, Exploitation
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, FakeLink, drain

MODULE = "app.modules.actuation.loudspeaker:Loudspeaker"


class SpeakingLink(FakeLink):
    """A body that notes what it plays."""

    def __init__(self, *, loudspeaker: bool) -> None:
        super().__init__()
        streams = {**self.description.streams, "loudspeaker": StreamDescription("loudspeaker", Audio, 90.0)}
        self.description = replace(self.description, loudspeaker=loudspeaker, streams=streams)
        self.receivers["loudspeaker"] = []
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


BEHAVIORS = [
    {"input": "voice", "behavior": "Operator", "priority": 2},
    {"input": "say", "behavior": "Say", "priority": 1},
]


def test_the_operator_is_heard_over_the_robots_own_speech() -> None:
    link = SpeakingLink(loudspeaker=True)

    async def script() -> list[str | None]:
        bench = Bench(
            MODULE,
            inputs={"voice": Audio, "say": Audio},
            outputs={"exploitation": Exploitation},
            settings={"behaviors": BEHAVIORS},
            link=link,
        )
        reports = bench.listen("exploitation")
        async with bench:
            bench.feed("say", voice(0))
            await bench.settle()
            bench.feed("voice", voice(100))
            await bench.settle()
            bench.feed("say", voice(1))
            await bench.clock.sleep(0.5)
            bench.feed("say", voice(2))
            await bench.settle()
        heard = [report.behavior for report in drain(reports) if report.group == "voice"]
        return [who for number, who in enumerate(heard) if number == 0 or who != heard[number - 1]]

    assert run_virtual(script()) == [None, "Say", "Operator", None, "Say"]
    assert [audio.first_sample // 320 for audio in link.played] == [0, 100, 2]


def test_what_the_body_plays_is_published_while_it_is_wanted() -> None:
    link = SpeakingLink(loudspeaker=True)

    async def script() -> list[Audio]:
        bench = Bench(MODULE, inputs={"voice": Audio}, outputs={"played": Audio}, link=link)
        async with bench:
            assert not any(link.demands["loudspeaker"])
            played = bench.listen("played")
            await bench.settle()
            link.emit("loudspeaker", voice(7))
            return drain(played)

    assert [audio.first_sample for audio in run_virtual(script())] == [7 * 320]
    assert [rate_hz > 0 for rate_hz in link.demands["loudspeaker"]] == [False, True, False]
