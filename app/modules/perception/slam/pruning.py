"""Pruning: removal of old keyframes that show the same as newer ones, so that repeated passes do not grow the map.

Each square metre keeps a fixed number of the newest keyframes of each quarter of headings, whatever the uptime, so the
size of a map is bounded by the area. Edges of removed keyframes are passed to a neighbour (``pose_graph.without``).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2
from app.modules.perception.slam.pose_graph import surest, without
from app.modules.perception.slam.types import Edge, Submap

#: Least number of keyframes of a submap: fewer cannot be recognized.
_LEAST_KEYFRAMES = 4


@dataclass(frozen=True, slots=True, eq=False)
class Pruned:
    """The graph without ``removed``. ``replaced``: for each of these, another keyframe and its pose in it. ``changed``:
    ids of submaps that lost keyframes."""

    removed: tuple[int, ...]
    replaced: Mapping[int, tuple[int, Pose2]]
    edges: tuple[Edge, ...]
    submaps: tuple[Submap, ...]
    changed: frozenset[int]


def redundant(poses: Mapping[int, Pose2], kept: Collection[int], per_m2: int, sectors: int) -> list[int]:
    """Ids to remove, so that no square metre has more than ``per_m2`` keyframes of a sector; none of ``kept``."""
    if not poses:
        return []
    ids = np.fromiter(poses, dtype=np.int64)
    at = np.array([(p.x, p.y, p.theta) for p in poses.values()])
    sector = np.floor(at[:, 2] % math.tau / math.tau * sectors)
    hypotheses = np.column_stack((np.floor(at[:, :2]), sector)).astype(np.int64)
    _, place, counts = np.unique(hypotheses, axis=0, return_inverse=True, return_counts=True)
    place = place.reshape(-1)
    removed: list[int] = []
    for full in np.flatnonzero(counts > per_m2):
        old = [id for id in ids[place == full].tolist() if id not in kept]
        removed += sorted(old)[: int(counts[full]) - per_m2]
    return sorted(removed)


def pruned(removed: Sequence[int], edges: Sequence[Edge], submaps: Sequence[Submap]) -> Pruned:
    """The graph of ``edges`` and ``submaps`` without ``removed``; a removed keyframe without any edge stays."""
    gone: list[int] = []
    replaced: dict[int, tuple[int, Pose2]] = {}
    left = list(edges)
    for id in removed:
        hub = surest(left, id)
        if hub is None:
            continue
        replaced[id] = hub.b, hub.X_ab.inverse()
        left = without(left, id)
        gone.append(id)
    lost = set(gone)
    changed = {submap.id for submap in submaps if lost.intersection(submap.keyframes)}
    rest = (Submap(s.id, tuple(k for k in s.keyframes if k not in lost)) if s.id in changed else s for s in submaps)
    whole = tuple(s for s in rest if s.id not in changed or len(s.keyframes) >= _LEAST_KEYFRAMES)
    return Pruned(tuple(gone), replaced, tuple(left), whole, frozenset(changed))
