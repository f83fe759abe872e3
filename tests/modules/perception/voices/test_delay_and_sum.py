"""Delay and sum: every direction can be heard, with and without a body between the microphones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.modules.perception.voices.delay_and_sum import DelayAndSum
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.voices.steering_vectors import arrivals

CORNERS = np.array([[x, y, z] for z in (0.46, 0.25) for x in (0.085, -0.085) for y in (0.11, -0.11)])
RATE = 48_000
RANGE_M = 1.8
DIRECTIONS = [
    np.array([math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation)])
    for azimuth in np.linspace(-math.pi, math.pi, 16, endpoint=False)
    for elevation in (-1.2, -0.5, 0.0, 0.5, 1.2)
]


@pytest.mark.parametrize("body_m", [0.0, 0.1, 0.17, 0.3])
def test_what_comes_from_anywhere_adds_up_to_itself(body_m: float) -> None:
    array = MicrophoneArray(CORNERS, body_m=body_m)
    beams = DelayAndSum(array, RATE, RANGE_M)
    for direction in DIRECTIONS:
        late = np.rint(arrivals(array.offsets, direction[None], RANGE_M, body_m)[0] * RATE).astype(int)
        click = np.zeros((2048, len(array)), np.float32)
        click[1000 + late, np.arange(len(array))] = 1
        beams.reset()
        beams.update(click)
        heard = beams.beam(direction)
        assert heard.shape == (2048,)
        assert heard.argmax() == 1000 + beams.latency
        assert heard.max() == pytest.approx(1.0)
