"""Desires that led to the accomplishment of an episode, and what of them is desired where it is recognized. Pure."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from app.memory.matching import learned
from app.messages import Desire

#: Intensities change in such steps: each change is a problem to solve.
STEP: Final = 0.5
#: A deed that led to less than this share of accomplishments is no longer known.
_NEGLIGIBLE: Final = 0.01
#: Digits of the number of a desire's parameters.
_DIGITS: Final = 6


def key_of(cls: str, params: Mapping[str, Any]) -> str:
    """Which desire one of ``cls`` is: the class, with a number made of its words, if it has any.

    Numbers among ``params`` do not count: the way to a place differs each time. The words themselves are not in it.
    """
    words = {name: value for name, value in params.items() if isinstance(value, str) and value}
    if not words:
        return cls
    text = json.dumps(words, sort_keys=True)
    return f"{cls}#{hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]}"


@dataclass(frozen=True, slots=True)
class Deed:
    """A desire that was at work in an episode: its class, its parameters, and ``weight`` in [0, 1], the share of the
    last times in which the episode was accomplished with it."""

    key: str
    cls: str
    params: Mapping[str, Any]
    weight: float


def learned_deeds(
    before: Iterable[Deed], used: Mapping[str, Desire], rate: float, *, accomplished: bool
) -> tuple[Deed, ...]:
    """The deeds of an episode that ended now; ``used``, by key, led to its end if it was ``accomplished``.

    Weights are learned as those of EM-ART: one that was not used, or was in vain, is the weaker.
    """
    known = {deed.key: deed for deed in before}
    given = dict.fromkeys(used, 1.0) if accomplished else {}
    weights = learned({key: deed.weight for key, deed in known.items()}, given, rate, _NEGLIGIBLE)
    return tuple(
        Deed(key, used[key].cls, used[key].params, weight)
        if key in used
        else Deed(key, known[key].cls, known[key].params, weight)
        for key, weight in weights.items()
    )


@dataclass(frozen=True, slots=True)
class Bounds:
    """How far memory may go: ``most``, the greatest intensity of a desire that none else has; ``boost``: by how much a
    desire of others may be more intense; ``least``: the least weight of a deed; ``count``: so many at most; ``scale``:
    the end of the scale of intensities."""

    most: float
    boost: float
    least: float
    count: int
    scale: float


@dataclass(frozen=True, slots=True)
class Raise:
    """A desire that memory adds: as ``deed``, with ``intensity`` and ``utility``, and why, in words."""

    deed: Deed
    intensity: float
    utility: float
    why: str


def raised(
    episode: int, deeds: Iterable[Deed], others: Collection[Desire], classes: Collection[str], bounds: Bounds
) -> tuple[Raise, ...]:
    """What memory desires while ``episode`` is recognized, the weightiest first.

    ``others``: all desires but memory's own; ``classes``: those that it may desire. A desire of others for the same is
    raised by up to ``boost``. Where others desire something else of the class, inhibit it, or desire it as security,
    which a desire of memory's would hide, memory leaves the class alone.
    """
    best: dict[str, Raise] = {}
    for deed in sorted(deeds, key=lambda each: (-each.weight, each.key)):
        if deed.weight < bounds.least or deed.cls not in classes or deed.cls in best:
            continue
        same_class = [desire for desire in others if desire.cls == deed.cls]
        if any(each.security or each.utility <= 0 or key_of(each.cls, each.params) != deed.key for each in same_class):
            continue
        strongest = max(same_class, key=lambda desire: desire.intensity, default=None)
        if strongest is None:
            intensity, utility = _step(bounds.most * deed.weight), 1.0
        else:
            intensity = min(bounds.scale, strongest.intensity + _step(bounds.boost * deed.weight))
            utility = strongest.utility
        if intensity > (0.0 if strongest is None else strongest.intensity):
            why = f"episode {episode} was accomplished with it in {deed.weight:.0%} of the last times"
            best[deed.cls] = Raise(deed, intensity, utility, why)
    return tuple(best.values())[: bounds.count]


def _step(intensity: float) -> float:
    return math.floor(intensity / STEP + 1e-9) * STEP
