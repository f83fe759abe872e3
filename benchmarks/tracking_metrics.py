"""How well tracks are those of the true objects: CLEAR MOT and IDF1.

Bernardin and Stiefelhagen, *Evaluating Multiple Object Tracking Performance: The CLEAR MOT Metrics*, 2008; Ristani et
al., *Performance Measures and a Data Set for Multi-Target, Multi-Camera Tracking*, 2016. A hypothesis may have no
identity (unsure): it finds an object, but is nobody's, which IDF1 counts as wrong and no swap.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A track ``at`` (m), and the identity it has."""

    track: int
    identity: int | None
    at: Point


@dataclass(frozen=True, slots=True)
class Frame:
    """One instant: the ``truth`` by name, the ``found``, and by name true objects that need not be found (``ignored``).

    What is found of an ignored object is not another's.
    """

    truth: Mapping[str, Point]
    found: Sequence[Hypothesis]
    ignored: Mapping[str, Point] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Scores:
    """``mota`` and ``idf1`` up to 1; ``motp_m`` the mean distance of pairs; counts of ``misses``, ``false`` hypotheses
    and ``swaps`` of identity; ``identities`` given to true objects; ``unsure``: share of pairs without an identity;
    ``objects``: how often a true object was to be found."""

    mota: float
    idf1: float
    motp_m: float
    misses: int
    false: int
    swaps: int
    identities: int
    unsure: float
    objects: int


def score(frames: Iterable[Frame], within_m: float) -> Scores:
    """The scores of ``frames``; a hypothesis farther than ``within_m`` is another's."""
    last: dict[str, int] = {}
    tracks: dict[str, int] = {}
    misses = false = swaps = objects = found = unsure = 0
    distances: list[float] = []
    together: Counter[tuple[str, int]] = Counter()
    identities: set[int] = set()
    for frame in frames:
        everything, alone = matched(frame, tracks, within_m)
        pairs = {name: each for name, each in everything.items() if name in frame.truth}
        objects += len(frame.truth)
        misses += len(frame.truth) - len(pairs)
        false += alone
        found += len(pairs) + alone
        tracks = {name: each.track for name, each in everything.items()}
        for name, each in pairs.items():
            distances.append(math.dist(frame.truth[name], each.at))
            if each.identity is None:
                unsure += 1
                continue
            identities.add(each.identity)
            together[name, each.identity] += 1
            swaps += last.get(name, each.identity) != each.identity
            last[name] = each.identity
    right = _most_together(together)
    return Scores(
        mota=1 - (misses + false + swaps) / max(objects, 1),
        idf1=2 * right / max(objects + found, 1),
        motp_m=float(np.mean(distances)) if distances else math.nan,
        misses=misses,
        false=false,
        swaps=swaps,
        identities=len(identities),
        unsure=unsure / max(len(distances), 1),
        objects=objects,
    )


def matched(frame: Frame, before: Mapping[str, int], within_m: float) -> tuple[dict[str, Hypothesis], int]:
    """The hypothesis of each true object, the ignored too, and how many hypotheses are none's.

    Pairs of the frame ``before`` (tracks by name) stay while they are near enough; the others are matched at the least
    distance together.
    """
    by_track = {each.track: each for each in frame.found}
    truth = {**frame.ignored, **frame.truth}
    pairs: dict[str, Hypothesis] = {}
    for name, track in before.items():
        if name in truth and track in by_track and math.dist(truth[name], by_track[track].at) <= within_m:
            pairs[name] = by_track.pop(track)
    names = [name for name in truth if name not in pairs]
    rest = list(by_track.values())
    if names and rest:
        apart = np.array([[math.dist(truth[name], each.at) for each in rest] for name in names])
        rows, columns = linear_sum_assignment(np.where(apart <= within_m, apart, 1e6))
        for row, column in zip(rows, columns, strict=True):
            if apart[row, column] <= within_m:
                pairs[names[row]] = rest[column]
    taken = {each.track for each in pairs.values()}
    left = [each for each in rest if each.track not in taken]
    alone = [each for each in left if all(math.dist(each.at, at) > within_m for at in frame.ignored.values())]
    return pairs, len(alone)


def _most_together(together: Counter[tuple[str, int]]) -> int:
    """How often objects have their identity, each object one and each identity of one object, at the best."""
    names = sorted({name for name, _ in together})
    identities = sorted({identity for _, identity in together})
    if not names:
        return 0
    table = np.array([[together[name, identity] for identity in identities] for name in names])
    rows, columns = linear_sum_assignment(-table)
    return int(table[rows, columns].sum())
