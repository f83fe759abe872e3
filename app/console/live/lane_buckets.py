"""A stretch of the lanes brought down to buckets of time: no sample and no short closing is lost to the eye. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
T = TypeVar("T")


class Buckets(NamedTuple):
    """The values of each bucket; NaN: it has none. ``low <= last <= high``."""

    low: Floats
    high: Floats
    #: The newest value.
    last: Floats


def bucket_starts(stamps: Floats, begin: float, end: float, points: int) -> Indices:
    """The number of the first sample of each bucket, of at most ``points`` buckets.

    ``stamps`` (s) ascend and lie from ``begin`` to ``end``. Where they are no more than ``points``, each is a bucket of
    its own; else the stretch is cut into ``points`` equal ones, and those without a sample are left out.
    """
    if len(stamps) <= points:
        return np.arange(len(stamps))
    places = np.floor((stamps - begin) / (end - begin) * points)
    places = np.minimum(places, points - 1)
    return np.flatnonzero(np.diff(places, prepend=-1.0))


def aggregated(values: Floats, starts: Indices) -> Buckets:
    """``values`` (NaN: none) of the buckets that begin at ``starts``, the first of them at 0."""
    if len(starts) == 0:
        return Buckets(*(np.empty(0),) * 3)
    known = np.where(np.isnan(values), -1, np.arange(len(values)))
    newest = np.maximum.reduceat(known, starts)
    return Buckets(
        np.fmin.reduceat(values, starts),
        np.fmax.reduceat(values, starts),
        np.where(newest < 0, math.nan, values[newest]),
    )


def thinned(
    changes: Iterable[T], bucket: Callable[[T], Hashable], weight: Callable[[T], tuple[float, float]]
) -> Sequence[T]:
    """Of the ``changes`` of each bucket the first that weighs most, and the last: what holds from then on."""
    kept: dict[Hashable, list[T]] = {}
    for change in changes:
        here = kept.setdefault(bucket(change), [change, change])
        if weight(change) > weight(here[0]):
            here[0] = change
        here[1] = change
    return [change for first, last in kept.values() for change in ([first] if first is last else [first, last])]
