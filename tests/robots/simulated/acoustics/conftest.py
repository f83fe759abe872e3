"""The robot's own array, as the tests of sound use it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.robots.simulated.acoustics.diffraction import BaffledMicrophones
from app.robots.stream_config import MicrophonesConfig

RATE = 48000


@pytest.fixture(scope="session")
def positions() -> NDArray[np.float64]:
    """The robot's microphones about their middle (8, 3) m."""
    p = np.array(MicrophonesConfig().positions)
    centred: NDArray[np.float64] = p - p.mean(0)
    return centred


@pytest.fixture(scope="session")
def shaded(positions: NDArray[np.float64]) -> BaffledMicrophones:
    """The array on its torso."""
    return BaffledMicrophones(positions, RATE)


@pytest.fixture(scope="session")
def free(positions: NDArray[np.float64]) -> BaffledMicrophones:
    """The array in the free field."""
    return BaffledMicrophones(positions, RATE, shadow=False)
