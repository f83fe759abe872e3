"""The emotions of the robot, as memory takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Emotions:
    """Intensities, each in [0, 1]."""

    joy: float = 0.0
    anger: float = 0.0
    sadness: float = 0.0
    fear: float = 0.0

    @property
    def greatest(self) -> float:
        """The greatest of them, which modulates learning and recall."""
        return min(max(self.joy, self.anger, self.sadness, self.fear, 0.0), 1.0)

    @property
    def items(self) -> Mapping[str, float]:
        """The emotions that are felt at all, by name, in tenths."""
        return {name: tenths for name, value in asdict(self).items() if (tenths := round(min(value, 1.0), 1)) > 0}
