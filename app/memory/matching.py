"""How well a pattern fits a category: the functions of EM-ART's layers. Pure.

Source: F. Leconte, F. Ferland, F. Michaud, *Design and integration of a spatio-temporal memory with emotional
influences to categorize and recall the experiences of an autonomous mobile robot*, Autonomous Robots (2015),
doi 10.1007/s10514-015-9496-2; fusion ART after A.-H. Tan, G. A. Carpenter, S. Grossberg (2007). Norms are Euclidean, as
in its program.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

KeyT = TypeVar("KeyT", bound=Hashable)

#: Of the choice function: keeps its denominator above 0.
ALPHA: Final = 0.01
#: Rounding: a match this much below the vigilance is no worse.
ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Fit:
    """How a category fits an input on one channel: its ``match`` M and its ``choice`` T, each in [0, 1]."""

    match: float
    choice: float

    def resonates(self, vigilance: float, relevance: float = 1.0) -> bool:
        """Whether T > 0, or the channel is irrelevant, and M is at least ``vigilance`` times ``relevance``."""
        return (self.choice > 0 or relevance == 0) and self.match >= vigilance * relevance - ROUNDING


_SAME: Final = Fit(1.0, 1.0)


def complement_fit(given: Mapping[str, float], weights: Mapping[str, float], absent: int = 0) -> Fit:
    """The fit of ``weights`` to the activations ``given``, both in [0, 1] by item, with complement coding.

    Each item has two nodes, a and 1 - a; an item that either mapping leaves out is 0 there. M = ||min(I, W)|| / ||I||.
    ``absent``: so many further items are known that are in neither, and count as found absent in both, as published.
    Where there is nothing at all, two empty patterns are the same.
    """
    common = whole = category = float(absent)
    for item in given.keys() | weights.keys():
        a, w = given.get(item, 0.0), weights.get(item, 0.0)
        common += min(a, w) ** 2 + min(1 - a, 1 - w) ** 2
        whole += a**2 + (1 - a) ** 2
        category += w**2 + (1 - w) ** 2
    if whole == 0:
        return _SAME
    return Fit(math.sqrt(common / whole), math.sqrt(common) / (ALPHA + math.sqrt(category)))


def plain_fit(given: Mapping[KeyT, float], weights: Mapping[KeyT, float]) -> Fit:
    """As :func:`complement_fit` without complements: what has not happened yet does not count against an episode.

    Nothing fits where nothing is given.
    """
    common = math.sqrt(sum(min(a, weights.get(key, 0.0)) ** 2 for key, a in given.items()))
    whole = math.sqrt(sum(a**2 for a in given.values()))
    category = math.sqrt(sum(w**2 for w in weights.values()))
    return Fit(common / whole if whole > 0 else 0.0, common / (ALPHA + category))


def learned(
    weights: Mapping[KeyT, float], given: Mapping[KeyT, float], rate: float, negligible: float
) -> dict[KeyT, float]:
    """``weights`` after learning ``given`` at ``rate`` in [0, 1]: w ← rate · a + (1 - rate) · w, those below
    ``negligible`` left out."""
    after = {}
    for key in sorted(weights.keys() | given.keys(), key=str):
        a, w = given.get(key, 0.0), weights.get(key, 0.0)
        value = w if a == w else rate * a + (1 - rate) * w
        if value >= negligible:
            after[key] = min(value, 1.0)
    return after


def rate_before(rate: float, emotion: float | None) -> float:
    """The learning rate with which a category learns at this intensity of emotion (0 to 1; None: unknown, no effect):
    L - L/4 · (0.5 - E), within [0.1, 1]. What moves the robot is learned faster."""
    return rate if emotion is None else _within(rate - 0.25 * rate * (0.5 - emotion), 0.1, 1.0)


def rate_after(rate: float, emotion: float | None) -> float:
    """The learning rate that a category keeps once it was made, or has learned: L + 3L/8 · (0.5 - E), within [0.1, 1].
    What moved the robot is harder to overwrite."""
    return rate if emotion is None else _within(rate + 0.375 * rate * (0.5 - emotion), 0.1, 1.0)


def episode_vigilance(vigilance: float, emotion: float | None, weights: Mapping[int, float]) -> float:
    """The vigilance of an episode that has these positive ``weights``, once it was made, or has learned:
    V - V/5 · (E - 0.5), at least 0.45 and the smallest weight, at most 0.85. What moved the robot is recalled sooner.
    """
    moved = vigilance if emotion is None else vigilance - 0.2 * vigilance * (emotion - 0.5)
    return min(max(moved, 0.45, min(weights.values(), default=0.0)), 0.85)


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
