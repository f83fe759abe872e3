"""How far what is believed of old places may be wrong: the shortest way to them through the graph, by its drift."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from app.modules.perception.slam.types import Edge, Keyframe, Submap

#: What a loop's edge is worth in metres driven.
_LOOP_M = 0.5


#: The ways are looked for anew after so many keyframes: until then, all are as much longer as was driven.
_ANEW_KEYFRAMES = 4


class DriftGraph:
    """Submaps as nodes, joined where they share keyframes and where loops are closed; lengths in metres driven."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Submaps or edges have changed but for new ones at the end: look at all of them again."""
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
        """A new submap; of those that share keyframes with it, it hangs on the oldest of each."""
        along = [keyframes[k].travelled_m for k in members]
        # A keyframe of long ago, on which mapping went on, is no part of the way.
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
    # Of edges between the same two, the shortest: a sparse matrix would add them up.
    order = np.lexsort((lengths, columns, rows))
    rows, columns, lengths = rows[order], columns[order], lengths[order]
    fresh = np.r_[True, (np.diff(rows) != 0) | (np.diff(columns) != 0)]
    graph = csr_array((lengths[fresh], (rows[fresh], columns[fresh])), shape=(here + 1, here + 1))
    return np.asarray(dijkstra(graph, directed=False, indices=here), dtype=np.float64)[:here]
