"""The loudspeaker's thread, with a loudspeaker that fails."""

from __future__ import annotations

import logging
import threading

import numpy as np
import pytest
from numpy.typing import NDArray

from app.messages import Audio
from app.robots.devices import player
from app.robots.devices.config import SpeakerConfig
from app.robots.devices.image_inputs import InputUnavailable
from app.robots.devices.player import Player

WAIT_S = 5.0


class LoudspeakerStream:
    """Fails the first time it is given sound, as one that is unplugged; all that were made are ``known``."""

    known: list[LoudspeakerStream]
    played: threading.Event

    def __init__(self, config: SpeakerConfig, rate: int) -> None:
        self.rate = rate
        self.closed = threading.Event()
        self.known.append(self)

    def write(self, samples: NDArray[np.int16]) -> None:
        if len(self.known) == 1:
            raise InputUnavailable("the loudspeaker takes no more sound")
        self.played.set()

    def close(self) -> None:
        self.closed.set()


@pytest.fixture
def speakers(monkeypatch: pytest.MonkeyPatch) -> list[LoudspeakerStream]:
    made: list[LoudspeakerStream] = []
    monkeypatch.setattr(LoudspeakerStream, "known", made, raising=False)
    monkeypatch.setattr(LoudspeakerStream, "played", threading.Event(), raising=False)
    monkeypatch.setattr(player, "LoudspeakerStream", LoudspeakerStream)
    monkeypatch.setattr(player, "RETRY_S", 0.0)
    return made


def frame(rate: int) -> Audio:
    return Audio(0.0, "operator", np.zeros((160, 1), np.int16), rate, 0, np.zeros((0, 3)))


def test_a_loudspeaker_that_comes_back_is_heard_again(
    speakers: list[LoudspeakerStream], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    playing = Player(SpeakerConfig())
    playing.start()
    playing.play(frame(16000))
    playing.play(frame(16000))
    while not LoudspeakerStream.played.wait(0.01):
        playing.play(frame(16000))
    assert speakers[0].closed.is_set()
    assert caplog.text.count("takes no more sound") == 1
    playing.play(frame(48000))
    assert speakers[1].closed.wait(WAIT_S), "one for another rate takes its place"
    playing.stop()
