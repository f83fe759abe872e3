"""The manner in which a text is spoken: how fast and how high."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Manner:
    """``rate`` of speaking and ``pitch`` of the voice, both over 0, as multiples of the engine's own. An engine that
    cannot change one of them leaves it as it is."""

    rate: float = 1.0
    pitch: float = 1.0

    def __post_init__(self) -> None:
        for name in ("rate", "pitch"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"the {name} of speaking is a number over 0, not {value!r}")


USUAL: Final = Manner()
"""The engine's own."""
