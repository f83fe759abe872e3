"""Data of devices as messages: unread sound is reported as missing."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.devices import streams
from app.robots.devices.config import SoundInputConfig
from app.robots.devices.streams import AudioFrames


class Microphone:
    """A live sound card in place of a real one."""

    live = True
    rate, channels = 16000, 1
    gap = False

    def read(self, count: int) -> NDArray[np.int16]:
        return np.zeros((count, 1), np.int16)

    def skip(self) -> None: ...

    def close(self) -> None: ...


@pytest.fixture
def microphone(monkeypatch: pytest.MonkeyPatch) -> Microphone:
    made = Microphone()
    monkeypatch.setattr(streams, "open_sound", lambda _: made)
    return made


@pytest.mark.parametrize("how", ["on time", "overrun", "skipped"])
def test_lost_samples_are_reported_by_number(microphone: Microphone, how: str) -> None:
    now = 10.0
    ear = AudioFrames(SoundInputConfig(rate=16000, frame_samples=160), Pose3.identity(), lambda: now).open()
    first = ear.read()
    assert first is not None
    assert first.first_sample == 0
    if how == "skipped":
        ear.skip()
    microphone.gap = how == "overrun"
    now = 10.05
    second = ear.read()
    assert second is not None
    assert second.first_sample == (160 if how == "on time" else 160 + 640)
    assert second.stamp == pytest.approx(10.04)
    microphone.gap = False
    now = 10.06
    third = ear.read()
    assert third is not None
    assert third.first_sample == second.first_sample + 160
