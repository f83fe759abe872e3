"""Drift bound: uncertainty of the relative pose of old submaps, by the shortest path through the pose graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from app.modules.perception.slam.types import Edge, Keyframe, Submap

#: Length of a loop's edge, in metres driven.
_LOOP_M = 0.5


#: Keyframes between recomputations; until then all lengths grow by the distance driven.
_ANEW_KEYFRAMES = 4


class DriftGraph:
    """Submaps as nodes, connected where they share keyframes and where loops are closed; lengths in metres driven."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Recompute from all submaps and edges: they changed otherwise than by additions at the end."""
        self._submaps = 0
        self._edges = 0
        self._node_of: dict[int, int] = {}
        self._middle_m: list[float] = []
        self._steps: list[tuple[int, int, float]] = []
        self._loops: list[tuple[int, int]] = []
        self._known: tuple[int, float, NDArray[np.float64]] | None = None

    def away_m(
        self, submaps: Sequence[Submap], keyframes: Mapping[int, Keyframe], edges: Sequence[Edge], id: int
    ) -> NDArray[np.float64]:
        """(S,) metres to each submap from keyframe ``id``, which is newer than all of them."""
        now_m = keyframes[id].travelled_m
        if self._known is not None and self._submaps == len(submaps) and id - self._known[0] < _ANEW_KEYFRAMES:
            return self._known[2] + (now_m - self._known[1])
        for node in range(self._submaps, len(submaps)):
            self._add(node, submaps[node].keyframes, keyframes)
        self._submaps = len(submaps)
        self._loops += [(edge.a, edge.b) for edge in edges[self._edges :] if edge.loop]
        self._edges = len(edges)
        here = len(submaps)
        steps = list(self._steps)
        if submaps:
            steps.append((here - 1, here, abs(now_m - self._middle_m[here - 1])))
        for a, b in self._loops:
            first, second = self._node_of.get(a, here), self._node_of.get(b, here)
            if first != second:
                since = sum(now_m - keyframes[k].travelled_m for k, node in ((a, first), (b, second)) if node == here)
                steps.append((first, second, _LOOP_M + max(since, 0.0)))
        self._known = id, now_m, _shortest(steps, here)
        return self._known[2]

    def _add(self, node: int, members: Sequence[int], keyframes: Mapping[int, Keyframe]) -> None:
        """Add a submap; it is connected to the oldest submap with which it shares each keyframe."""
        along = [keyframes[k].travelled_m for k in members]
        # An old keyframe on which mapping resumed is no part of the path.
        length = along[-1] - along[1 if len(along) > 1 and members[1] != members[0] + 1 else 0]
        self._middle_m.append(along[-1] - 0.5 * length)
        joined = {self._node_of[k] for k in members if k in self._node_of}
        self._steps.extend((other, node, 0.5 * length + 1e-3) for other in joined)
        for k in members:
            self._node_of.setdefault(k, node)


def _shortest(steps: Sequence[tuple[int, int, float]], here: int) -> NDArray[np.float64]:
    if not steps:
        return np.full(here, np.inf)
    first, second, length = zip(*steps, strict=True)
    rows, columns = np.array(first), np.array(second)
    lengths = np.array(length, dtype=np.float64)
    # The shortest edge between two nodes counts: a sparse matrix would add them up.
    order = np.lexsort((lengths, columns, rows))
    rows, columns, lengths = rows[order], columns[order], lengths[order]
    fresh = np.r_[True, (np.diff(rows) != 0) | (np.diff(columns) != 0)]
    graph = csr_array((lengths[fresh], (rows[fresh], columns[fresh])), shape=(here + 1, here + 1))
    return np.asarray(dijkstra(graph, directed=False, indices=here), dtype=np.float64)[:here]
