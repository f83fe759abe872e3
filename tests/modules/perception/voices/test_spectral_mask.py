"""What is above background and reverberation counts."""

from __future__ import annotations

import numpy as np

from app.modules.perception.voices.spectral_mask import SpectralMask

BINS = 4


def mask() -> SpectralMask:
    return SpectralMask(BINS, hop_s=0.01, tail=0.45, tail_s=0.085, floor=0.01)


def test_sound_above_a_background_counts_and_the_background_does_not() -> None:
    judge = mask()
    quiet = np.full(BINS, 1e-6, np.float32)
    for _ in range(200):
        weights = judge.weigh(quiet)
    np.testing.assert_allclose(weights, 0.01)
    assert judge.settled
    loud = judge.weigh(np.array([1e-6, 1e-3, 1e-3, 1e-3], np.float32))
    assert loud[0] < 0.02
    assert (loud[1:] > 0.95).all()


def test_digital_silence_does_not_count() -> None:
    judge = mask()
    judge.weigh(np.full(BINS, 1e-3, np.float32))
    for _ in range(300):
        weights = judge.weigh(np.zeros(BINS, np.float32))
    np.testing.assert_allclose(weights, 0.01)
