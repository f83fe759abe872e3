"""Pose graph optimization: least squares over all edges, robust against false loops."""

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

#: Standard deviations from which a loop's weight falls with its error (Cauchy's estimator).
_SOFT_SIGMAS = 3.0
#: ... the same during the first pass, which pulls the graph together.
_PULLED_SIGMAS = 30.0
#: Prior of the first keyframe, which stays in place.
_ANCHOR_SIGMAS = (1e-4, 1e-4, 1e-5)


@dataclass(frozen=True, slots=True, eq=False)
class GraphArrays:
    """A graph as arrays, for transfer to another process.

    ``poses`` (N, 3) float64 x, y, theta; of edge e: ``ends`` (E, 2) int64 rows of ``poses``, ``measured`` (E, 3) pose
    of the second in the first, ``information`` (E, 6) and ``loops`` (E,) bool as in :class:`Edge`. ``fresh`` (E,) bool:
    loops that are new since the last correction.
    """

    poses: NDArray[np.float64]
    ends: NDArray[np.int64]
    measured: NDArray[np.float64]
    information: NDArray[np.float64]
    loops: NDArray[np.bool_]
    fresh: NDArray[np.bool_]


#: Type of the functions that correct a graph: its poses (N, 3), the first unchanged.
Optimize = Callable[[GraphArrays], NDArray[np.float64]]


def graph_arrays(poses: Mapping[int, Pose2], edges: Sequence[Edge], judged: int = -1) -> GraphArrays:
    """``poses`` by id, in their order, and the ``edges`` between them; loops up to keyframe ``judged`` are not
    fresh."""
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
    """The poses (N, 3) of the least squares solution, by GTSAM's Levenberg-Marquardt.

    A long loop has a large error before it is closed: with such a fresh loop, a first pass uses a wider robust kernel,
    so that the loop can pull, and a second pass the normal one. The call holds the interpreter's lock: use another
    process on a moving robot.
    """
    poses = graph.poses
    if _farthest_sigmas(graph) > _PULLED_SIGMAS:
        poses = _solved(graph, poses, _PULLED_SIGMAS)
    return _solved(graph, poses, _SOFT_SIGMAS)


def _farthest_sigmas(graph: GraphArrays) -> float:
    """Error of the worst fresh loop, in standard deviations."""
    loops = graph.fresh
    if not loops.any():
        return 0.0
    found = between(graph.poses[graph.ends[loops, 0]], graph.poses[graph.ends[loops, 1]])
    off = between(graph.measured[loops], found)
    squares = np.einsum("ei,eij,ej->e", off, matrices(graph.information[loops]), off)
    return float(np.sqrt(squares.max()))


def uncertainties(graph: GraphArrays) -> NDArray[np.float64]:
    """(N,) standard deviations (m) of each position, over all directions, relative to the first, by all edges.

    Drift is included: uncertainty grows along the path and shrinks with loops. All infinite where a pose is too weakly
    constrained for the computation.
    """
    import gtsam

    factors, values = _problem(graph, graph.poses, _SOFT_SIGMAS)
    try:
        marginals = gtsam.Marginals(factors, values)
        variances = [np.trace(marginals.marginalCovariance(row)[:2, :2]) for row in range(len(graph.poses))]
    except (RuntimeError, IndexError):  # GTSAM: no solution, or a pose without an edge
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
    # The keys' order is that of the rows.
    return np.asarray(gtsam.utilities.extractPose2(result), dtype=np.float64)


def _problem(graph: GraphArrays, poses: NDArray[np.float64], soft_sigmas: float) -> tuple[Any, Any]:
    """Factors and values for GTSAM."""
    import gtsam

    noise = gtsam.noiseModel
    factors = gtsam.NonlinearFactorGraph()
    values = gtsam.Values()
    for row, pose in enumerate(poses):
        values.insert(row, gtsam.Pose2(*pose))
    anchor = noise.Diagonal.Sigmas(np.array(_ANCHOR_SIGMAS))
    factors.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(*graph.poses[0]), anchor))
    soft = noise.mEstimator.Cauchy.Create(soft_sigmas)
    # GTSAM takes the square root R of the information, R^T R.
    roots = np.linalg.cholesky(matrices(graph.information)).transpose(0, 2, 1)
    ends, measured, loops = graph.ends.tolist(), graph.measured.tolist(), graph.loops.tolist()
    for (a, b), X_ab, root, loop in zip(ends, measured, roots, loops, strict=True):
        sure = noise.Gaussian.SqrtInformation(root, False)
        model = noise.Robust.Create(soft, sure) if loop else sure
        factors.add(gtsam.BetweenFactorPose2(a, b, gtsam.Pose2(*X_ab), model))
    return factors, values


def surest(edges: Iterable[Edge], id: int) -> Edge | None:
    """The edge of most information at keyframe ``id``, oriented from it; None without edges."""
    spokes = [_from(edge, id) for edge in edges if id in (edge.a, edge.b)]
    return min(spokes, key=lambda e: (e.loop, variance_m2(e.information), -e.b), default=None)


def without(edges: Iterable[Edge], removed: int) -> list[Edge]:
    """Equivalent ``edges`` without the keyframes ``removed`` (marginalization).

    The neighbours of a removed keyframe are connected, through its surest edge, to that edge's other end: a star, in
    place of the Chow-Liu tree of Kretzschmar and Stachniss (2012). An edge that would duplicate a better known
    connection is omitted: the number of edges must not grow with repeated passes while the number of keyframes does
    not.
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
    """The same edge, oriented from its end ``id``."""
    return (
        edge
        if edge.a == id
        else Edge(edge.b, edge.a, edge.X_ab.inverse(), seen_from(edge.information, edge.X_ab), edge.loop)
    )


def _chained(hub: Edge, spoke: Edge) -> Information:
    """Information of the pose of the spoke's end in the hub, via the removed keyframe: both edges are oriented from
    that keyframe, and their covariances add."""
    return chained(seen_from(hub.information, hub.X_ab), spoke.information, spoke.X_ab)
