"""How long a room sounds on, measured on its impulse responses."""

from __future__ import annotations

import numpy as np

from app.robots.simulated.acoustics.room import Impulses


def reverberation_time(impulses: Impulses, rate: int, from_db: float = -5.0, to_db: float = -35.0) -> float:
    """RT60 (s) of ``impulses`` (M, taps) by Schroeder's backward integration, fitted from ``from_db`` to ``to_db``."""
    energy = np.cumsum(np.sum(impulses.astype(np.float64) ** 2, axis=0)[::-1])[::-1]
    level = 10 * np.log10(np.maximum(energy / energy[0], 1e-12))
    part = np.flatnonzero((level <= from_db) & (level >= to_db))
    slope = np.polyfit(part / rate, level[part], 1)[0]
    return float(-60.0 / slope)
