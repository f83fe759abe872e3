"""What a calibration of microphones results in."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class Verdict(StrEnum):
    """What to do: ``adopt`` the positions, ``keep`` the configured ones, which are confirmed, or ``repeat``."""

    ADOPT = "adopt"
    KEEP = "keep"
    REPEAT = "repeat"


@dataclass(frozen=True, slots=True)
class MicrophoneResult:
    """One channel: ``position`` (m, as configured ones are given), its distance from the configured ``moved_m``, its
    standard deviation; RMS residual (s) of its arrival times; level relative to the median microphone (dB) with its
    standard deviation; noise in dB of full scale. Of a channel with a ``fault`` that leaves no arrival times, position
    and order are the configured ones, and figures are NaN."""

    channel: int
    position: tuple[float, float, float]
    moved_m: float
    deviation_m: float
    residual_s: float
    gain_db: float
    gain_deviation_db: float
    noise_db: float
    fault: str


@dataclass(frozen=True, slots=True)
class ClapResult:
    """One clap: where it came from by the new positions (deg, m; the distance is rough), the RMS residual (s) of its
    arrival times, and whether it was ``used``."""

    at_s: float
    azimuth_deg: float
    elevation_deg: float
    range_m: float
    residual_s: float
    used: bool
    clipped: bool


@dataclass(frozen=True, slots=True)
class Calibration:
    """The result.

    ``order``: for each channel, the number of the configured position that it has; None if as configured.
    ``held_out_before_s``, ``held_out_after_s``: typical error (s) of the arrival times of half the claps by the
    configured positions, and by those found with the other half. ``reasons``: the verdict in words; ``unseen``: what
    sound cannot show of this array, in words.
    """

    microphones: tuple[MicrophoneResult, ...]
    claps: tuple[ClapResult, ...]
    order: tuple[int, ...] | None
    held_out_before_s: float
    held_out_after_s: float
    verdict: Verdict
    reasons: tuple[str, ...]
    unseen: tuple[str, ...]

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions (M, 3) m, one per channel, in the axes and about the middle of the configured ones."""
        return np.array([one.position for one in self.microphones])


class NotEnough(Exception):
    """There is too little to calibrate with; the message says of what."""
