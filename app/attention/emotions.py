"""Emotions from how desires fare: what is desired and exploited, and what is desired and neglected. Pure.

The first HBBA's module of emotions (``HBBA/emotion_generator`` of francoisferland/HBBA, described in thesis 2.2.2 after
Raïevsky and Michaud 2008) has for each emotion an intensity from 0 to 1. Each second every desired class adds what a
table says of it, one figure while it is exploited and another while it is not; and every two seconds the intensity
decays by 0.002. The figures in :data:`PUBLISHED` are its. Two things differ here:

- Time is continuous: figures are rates per second, the solution is exact, and so independent of how time is divided.
- The classes' sum is bounded, where the original bounds after each class, so that their order matters.

What an emotion comes from is known, too: a gain counts for its class, a loss lessens all shares alike.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, get_args

from app.attention.desires import Desire, strongest_first
from app.messages import Desires, Emotion

EMOTIONS: Final[tuple[Emotion, ...]] = get_args(Emotion)

DECAY_PER_S: Final = 0.001
"""Of the original: 0.002 in 2 s (its parameter ``decay``)."""


@dataclass(frozen=True, slots=True)
class Effects:
    """Change of emotions per second that a desired class makes ``exploited``, and ``neglected``; of an emotion that is
    not named, none."""

    exploited: Mapping[Emotion, float] = field(default_factory=dict)
    neglected: Mapping[Emotion, float] = field(default_factory=dict)


PUBLISHED: Final[Mapping[str, Effects]] = MappingProxyType(
    {
        "GoTo": Effects({"joy": 0.01, "anger": -0.01}, {"joy": -0.05, "anger": 0.05}),
        "Wander": Effects({"joy": -0.002, "anger": 0.002}, {"joy": -0.008, "anger": 0.008}),
        "Teleoperation": Effects({"joy": 0.02, "anger": -0.04}, {}),
    }
)
"""The table that the original ships: GoTo and not_GoTo, Wander and not_Wander, Teleop and not_Teleop (whose figures are
0). It has none of sadness and fear."""

Shares = Mapping[str, float]
"""Of one emotion: its intensity, in parts by the class that they come from. Their sum is the intensity, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Fates:
    """The desired classes whose strongest desire is ``exploited``, and ``neglected``: all others that are desired and
    not inhibited."""

    exploited: frozenset[str] = frozenset()
    neglected: frozenset[str] = frozenset()


def strongest(desires: Iterable[Desire]) -> dict[str, Desire]:
    """The strongest desire of each class, as the Intention Workspace chooses it."""
    found: dict[str, Desire] = {}
    for desire in desires:
        rival = found.get(desire.cls)
        if rival is None or strongest_first(desire) <= strongest_first(rival):
            found[desire.cls] = desire
    return found


def fates(message: Desires) -> Fates:
    """How the desires of ``message`` fare."""
    exploited = frozenset(message.exploited)
    wanted = {cls: desire.id for cls, desire in strongest(message.desires).items() if desire.utility > 0}
    served = frozenset(cls for cls, id_ in wanted.items() if id_ in exploited)
    return Fates(served, frozenset(wanted) - served)


class EmotionDynamics:
    """Intensities of the emotions, by what they come from."""

    def __init__(self, effects: Mapping[str, Effects] = PUBLISHED, decay_per_s: float = DECAY_PER_S) -> None:
        """``effects`` by desire class. Raises ValueError for a decay outside [0, 1]."""
        if not 0 <= decay_per_s <= 1:
            raise ValueError(f"the decay per second is from 0 to 1, not {decay_per_s!r}")
        self._effects = effects
        self._decay_per_s = decay_per_s
        self._shares: dict[Emotion, dict[str, float]] = {emotion: {} for emotion in EMOTIONS}

    @property
    def shares(self) -> Mapping[Emotion, Shares]:
        """By emotion, what it comes from; never negative, and at most 1 in sum."""
        return self._shares

    def intensity(self, emotion: Emotion) -> float:
        """From 0 to 1."""
        return min(1.0, math.fsum(self._shares[emotion].values()))

    def advance(self, elapsed_s: float, how: Fates) -> None:
        """``elapsed_s`` (s, at least 0) go by while desires fare so."""
        for emotion in EMOTIONS:
            rates = [(cls, effect) for cls in self._effects if (effect := self._rate(cls, emotion, how))]
            gains = {cls: rate for cls, rate in rates if rate > 0}
            loss = self._decay_per_s - math.fsum(rate for _, rate in rates if rate < 0)
            self._shares[emotion] = advanced(self._shares[emotion], gains, loss, elapsed_s)

    def _rate(self, cls: str, emotion: Emotion, how: Fates) -> float:
        if cls in how.exploited:
            return self._effects[cls].exploited.get(emotion, 0.0)
        if cls in how.neglected:
            return self._effects[cls].neglected.get(emotion, 0.0)
        return 0.0


def advanced(shares: Shares, gains: Mapping[str, float], loss: float, elapsed_s: float) -> dict[str, float]:
    """The shares of one emotion after ``elapsed_s`` (s) with ``gains`` per second (over 0) by class, and a ``loss`` per
    second (at least 0) of all.

    The intensity E is a straight line, bounded to [0, 1]. With the gains' sum G, a class's part p of E obeys
    p' = (g - G p) / E, whose solution is exponential in ∫ G / E dt: so two steps give what one gives.
    """
    gain = math.fsum(gains.values())
    net = gain - loss
    now = min(1.0, math.fsum(shares.values()))
    if now <= 0:
        now = 0.0
        if net <= 0:
            return {}
    rises_s = (1.0 - now) / net if net > 0 else math.inf
    falls_s = now / -net if net < 0 else math.inf
    if elapsed_s >= falls_s:
        return {}
    within_s = min(elapsed_s, rises_s)
    then = 1.0 if elapsed_s >= rises_s else min(1.0, now + net * within_s)
    # How much of what there was counts still: exp(-∫ G / E dt), E below its bound, and at it.
    if now == 0:
        kept = 0.0
    elif abs(net) * within_s < 1e-12 * now:
        kept = math.exp(-gain * within_s / now)
    else:
        kept = math.exp(-gain / net * math.log1p(net * within_s / now))
    if elapsed_s > rises_s:
        kept *= math.exp(-gain * (elapsed_s - rises_s))
    parts = {cls: share / now * kept for cls, share in shares.items()} if now > 0 else {}
    if gain > 0:
        for cls, each in gains.items():
            parts[cls] = parts.get(cls, 0.0) + each / gain * (1.0 - kept)
    return {cls: part * then for cls, part in parts.items() if part * then > 0}


def sources(shares: Shares, most: int, least: float = 0.001) -> tuple[tuple[str, float], ...]:
    """The classes that an emotion comes from, the greatest share first: at most ``most``, each of ``least`` or more."""
    greatest: Collection[tuple[str, float]] = sorted(shares.items(), key=lambda each: (-each[1], each[0]))
    return tuple((cls, share) for cls, share in greatest if share >= least)[:most]
