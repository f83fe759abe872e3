"""How well perceptions can work: by light, noise and what the laser gets back."""

from __future__ import annotations

import numpy as np
import pytest

from app.modules.perception.working_conditions import (
    SteadyNoise,
    light_confidence,
    quiet_confidence,
    returns_confidence,
)


def test_dark_pictures_and_loud_rooms_are_worked_in_less_well() -> None:
    assert [light_confidence(luma) for luma in (0, 0.02, 0.07, 0.12, 0.9)] == pytest.approx([0, 0, 0.5, 1, 1])
    assert [quiet_confidence(db) for db in (-80, -35, -25, -15, 0)] == pytest.approx([1, 1, 0.5, 0, 0])


def test_a_dazzled_laser_gets_little_back() -> None:
    ranges = np.full(100, 4.0, np.float32)
    assert returns_confidence(ranges, 0.1) == 1
    ranges[:70] = np.inf
    assert returns_confidence(ranges, 0.1) == pytest.approx(0.5)
    ranges[70:90] = np.nan
    ranges[90:95] = 0.01
    assert returns_confidence(ranges, 0.1) == 0
    assert returns_confidence(ranges[:0], 0.1) == 0


def test_a_voice_that_pauses_is_no_steady_noise() -> None:
    noise = SteadyNoise(seconds=1.0)
    quiet, loud = np.full((480, 2), 33, np.int16), np.full((480, 2), 16384, np.int16)
    levels = [noise.hear(loud if n % 100 < 60 else quiet, 48000) for n in range(200)]
    assert levels[0] is None
    assert levels[-1] == pytest.approx(-60, abs=0.2)
    levels = [noise.hear(loud, 48000) for _ in range(200)]
    assert levels[-1] == pytest.approx(-6, abs=0.1)
