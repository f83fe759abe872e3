"""How well a perception can work under the conditions at hand, as a confidence for attention."""

from __future__ import annotations

import math
from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

from app.messages import Confidence, Image
from app.modules.perception.luma import LUMA_STEP, mean_luma
from app.runtime.ports import Output

#: Mean luma (0 to 1) of a picture in which nothing is found, and from which on all is.
BLACK, LIGHT = 0.02, 0.12
#: Level (dB of full scale) of steady noise beside which voices are located as well as ever, and in which they drown.
QUIET_DB, DROWNING_DB = -35.0, -15.0
#: Share of a scan's rays that return something, which is enough to match it, and at which it cannot be.
ENOUGH, FEW = 0.5, 0.1
#: A confidence is said so often (s).
_EVERY_S: Final = 0.5


def light_confidence(luma: float) -> float:
    """Of looking for faces or codes in a picture of mean ``luma`` (0 to 1)."""
    return _ramp(luma, BLACK, LIGHT)


def quiet_confidence(level_db: float) -> float:
    """Of locating voices beside steady noise of ``level_db`` (dB of full scale)."""
    return _ramp(level_db, DROWNING_DB, QUIET_DB)


def returns_confidence(ranges: NDArray[np.float32], range_min: float) -> float:
    """Of matching a scan of these ``ranges`` (m): a dazzled laser gives too near ones, none, or NaN."""
    if not len(ranges):
        return 0.0
    return _ramp(float(np.mean(np.isfinite(ranges) & (ranges >= range_min))), FEW, ENOUGH)


class SteadyNoise:
    """The level of what is heard all the time: the least of the last ``seconds``, for voices pause."""

    def __init__(self, seconds: float = 3.0, piece_s: float = 0.1) -> None:
        self._piece_s = piece_s
        self._power, self._length_s = 0.0, 0.0
        self._levels: deque[float] = deque(maxlen=round(seconds / piece_s))

    def hear(self, samples: NDArray[np.int16], rate: int) -> float | None:
        """The level (dB of full scale) with ``samples`` (N, C) of ``rate`` Hz; None before there were enough."""
        if len(samples):
            self._power += float(np.mean(np.square(samples[:, 0].astype(np.float32) / 32768))) * len(samples) / rate
            self._length_s += len(samples) / rate
        if self._length_s >= self._piece_s:
            self._levels.append(10 * math.log10(self._power / self._length_s + 1e-12))
            self._power, self._length_s = 0.0, 0.0
        return min(self._levels) if len(self._levels) == self._levels.maxlen else None


class ConfidenceReporter:
    """Says on ``output`` twice a second how well the module works."""

    def __init__(self, output: Output[Confidence]) -> None:
        self._output = output
        self._said = -math.inf

    def due(self, stamp: float) -> bool:
        """Whether it is time to say it again; also after time jumped back."""
        return not 0 <= stamp - self._said < _EVERY_S

    def say(self, stamp: float, value: float, reason: str) -> None:
        """It works as well as ``value`` (0 to 1); ``reason`` why it is less than 1."""
        self._said = stamp
        self._output.publish(Confidence(stamp, round(value, 3), reason if value < 1 else ""))


class LightReporter:
    """Says on ``output`` how well the module works by the light in its cameras' pictures."""

    def __init__(self, output: Output[Confidence]) -> None:
        self._reporter = ConfidenceReporter(output)
        self._light: dict[str, float] = {}

    def look(self, image: Image) -> None:
        """Note how bright ``image`` is, and say it if it is time; 0.1 ms twice a second."""
        if image.frame in self._light and not self._reporter.due(image.stamp):
            return
        self._light[image.frame] = light_confidence(mean_luma(image.color, LUMA_STEP))
        if self._reporter.due(image.stamp):
            value = sum(self._light.values()) / len(self._light)
            self._reporter.say(image.stamp, value, "the picture is dark")


def _ramp(value: float, none: float, full: float) -> float:
    """0 at ``none``, 1 at ``full`` and beyond, linear between."""
    return min(1.0, max(0.0, (value - none) / (full - none)))
