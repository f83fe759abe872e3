"""The pose graph: all keyframes where all edges together want them; robust against loops that are none."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.information import Information, chained, matrices, seen_from, variance_m2
from app.modules.perception.slam.relations import between
from app.modules.perception.slam.types import Edge

#: From so many standard deviations on, a loop's weight falls with its error (Cauchy's estimator).
_SOFT_SIGMAS = 3.0
#: ... and, while the graph is first pulled together, from so many.
_PULLED_SIGMAS = 30.0
#: The first keyframe stays where it is.
_ANCHOR_SIGMAS = (1e-4, 1e-4, 1e-5)


@dataclass(frozen=True, slots=True, eq=False)
class GraphArrays:
    """A graph as arrays, which another process can be given.

    ``poses`` (N, 3) float64 x, y, theta; of edge e, ``ends`` (E, 2) int64 rows of ``poses``, ``measured`` (E, 3) pose
    of the second in the first, ``information`` (E, 6) and ``loops`` (E,) bool as in :class:`Edge`. ``fresh``
    (E,) bool: loops that no correction has judged yet.
    """

    poses: NDArray[np.float64]
    ends: NDArray[np.int64]
    measured: NDArray[np.float64]
    information: NDArray[np.float64]
    loops: NDArray[np.bool_]
    fresh: NDArray[np.bool_]


#: What corrects a graph: its poses (N, 3), the first unmoved.
Optimize = Callable[[GraphArrays], NDArray[np.float64]]


def graph_arrays(poses: Mapping[int, Pose2], edges: Sequence[Edge], judged: int = -1) -> GraphArrays:
    """``poses`` by id, in their order, and the ``edges`` between them; loops up to keyframe ``judged`` are old."""
    rows = {id: row for row, id in enumerate(poses)}
    return GraphArrays(
        poses=np.array([(p.x, p.y, p.theta) for p in poses.values()], dtype=np.float64).reshape(-1, 3),
        ends=np.array([(rows[e.a], rows[e.b]) for e in edges], dtype=np.int64).reshape(-1, 2),
        measured=np.array([(e.X_ab.x, e.X_ab.y, e.X_ab.theta) for e in edges], dtype=np.float64).reshape(-1, 3),
        information=np.array([e.information for e in edges], dtype=np.float64).reshape(-1, 6),
        loops=np.array([e.loop for e in edges], dtype=np.bool_),
        fresh=np.array([e.loop and max(e.a, e.b) > judged for e in edges], dtype=np.bool_),
    )


def optimized(graph: GraphArrays) -> NDArray[np.float64]:
    """The poses (N, 3) that fit the edges best, by GTSAM's Levenberg-Marquardt.

    A long loop that closes is far off at first: where one is, its edges are believed farther at first, so that they
    pull, and judged then. It holds the interpreter's lock meanwhile: a robot that is driving calls it in another
    process.
    """
    poses = graph.poses
    if _farthest_sigmas(graph) > _PULLED_SIGMAS:
        poses = _solved(graph, poses, _PULLED_SIGMAS)
    return _solved(graph, poses, _SOFT_SIGMAS)


def _farthest_sigmas(graph: GraphArrays) -> float:
    """How many standard deviations the worst fresh loop is off."""
    loops = graph.fresh
    if not loops.any():
        return 0.0
    found = between(graph.poses[graph.ends[loops, 0]], graph.poses[graph.ends[loops, 1]])
    off = between(graph.measured[loops], found)
    squares = np.einsum("ei,eij,ej->e", off, matrices(graph.information[loops]), off)
    return float(np.sqrt(squares.max()))


def uncertainties(graph: GraphArrays) -> NDArray[np.float64]:
    """(N,) standard deviations (m) of where each pose is, whatever the direction, seen from the first: by all edges.

    Drift is in it: what is not known of the way to a pose adds up, and a loop takes it away. All infinite where edges
    say so little of some pose that it cannot be computed.
    """
    import gtsam

    factors, values = _problem(graph, graph.poses, _SOFT_SIGMAS)
    try:
        marginals = gtsam.Marginals(factors, values)
        variances = [np.trace(marginals.marginalCovariance(row)[:2, :2]) for row in range(len(graph.poses))]
    except (RuntimeError, IndexError):  # GTSAM: no solution; a pose that no edge holds
        return np.full(len(graph.poses), np.inf)
    return np.sqrt(np.array(variances, dtype=np.float64))


def _solved(graph: GraphArrays, poses: NDArray[np.float64], soft_sigmas: float) -> NDArray[np.float64]:
    import gtsam

    factors, values = _problem(graph, poses, soft_sigmas)
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setMaxIterations(8)
    parameters.setRelativeErrorTol(1e-4)
    parameters.setAbsoluteErrorTol(1e-4)
    result = gtsam.LevenbergMarquardtOptimizer(factors, values, parameters).optimize()
    # In the order of the keys, which is that of the rows.
    return np.asarray(gtsam.utilities.extractPose2(result), dtype=np.float64)


def _problem(graph: GraphArrays, poses: NDArray[np.float64], soft_sigmas: float) -> tuple[Any, Any]:
    """GTSAM's factors and values."""
    import gtsam

    noise = gtsam.noiseModel
    factors = gtsam.NonlinearFactorGraph()
    values = gtsam.Values()
    for row, pose in enumerate(poses):
        values.insert(row, gtsam.Pose2(*pose))
    anchor = noise.Diagonal.Sigmas(np.array(_ANCHOR_SIGMAS))
    factors.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*graph.poses[0]), anchor))
    soft = noise.mEstimator.Cauchy.Create(soft_sigmas)
    # GTSAM wants the root R of information, R^T R.
    roots = np.linalg.cholesky(matrices(graph.information)).transpose(0, 2, 1)
    ends, measured, loops = graph.ends.tolist(), graph.measured.tolist(), graph.loops.tolist()
    for (a, b), X_ab, root, loop in zip(ends, measured, roots, loops, strict=True):
        sure = noise.Gaussian.SqrtInformation(root, False)
        model = noise.Robust.Create(soft, sure) if loop else sure
        factors.add(gtsam.BetweenFactorPose2(a, b, gtsam.Pose2(*X_ab), model))
    return factors, values


def surest(edges: Iterable[Edge], id: int) -> Edge | None:
    """The edge that holds keyframe ``id`` best, told from it; None where nothing does."""
    spokes = [_from(edge, id) for edge in edges if id in (edge.a, edge.b)]
    return min(spokes, key=lambda e: (e.loop, variance_m2(e.information), -e.b), default=None)


def without(edges: Iterable[Edge], removed: int) -> list[Edge]:
    """``edges`` that say the same of all keyframes but ``removed``.

    What hung on it hangs, through the surest of its edges, on that one's other end instead: a star, where Kretzschmar
    and Stachniss (2012) make a tree. What is surely joined already is not joined once more: or edges would grow with
    the time that a place is passed, while its keyframes do not.
    """
    kept: list[Edge] = []
    touching: list[Edge] = []
    for edge in edges:
        (touching if removed in (edge.a, edge.b) else kept).append(edge)
    hub = surest(touching, removed)
    if hub is None:
        return kept
    X_hr = hub.X_ab.inverse()
    joined = {edge.b + edge.a - hub.b: edge for edge in kept if hub.b in (edge.a, edge.b)}
    replaced: set[int] = set()
    for spoke in (_from(edge, removed) for edge in touching):
        if spoke.b == hub.b:
            continue
        edge = Edge(hub.b, spoke.b, X_hr @ spoke.X_ab, _chained(hub, spoke), hub.loop or spoke.loop)
        before = joined.get(spoke.b)
        if before is not None and _sureness(before) >= _sureness(edge):
            continue
        if before is not None:
            replaced.add(id(before))
        joined[spoke.b] = edge
        kept.append(edge)
    return [edge for edge in kept if id(edge) not in replaced] if replaced else kept


def _sureness(edge: Edge) -> tuple[bool, float]:
    return not edge.loop, -variance_m2(edge.information)


def _from(edge: Edge, id: int) -> Edge:
    """The same edge, told from its end ``id``."""
    return (
        edge
        if edge.a == id
        else Edge(edge.b, edge.a, edge.X_ab.inverse(), seen_from(edge.information, edge.X_ab), edge.loop)
    )


def _chained(hub: Edge, spoke: Edge) -> Information:
    """Information of the way from the hub over what is removed, which both edges are told from, to the spoke's end."""
    return chained(seen_from(hub.information, hub.X_ab), spoke.information, spoke.X_ab)
