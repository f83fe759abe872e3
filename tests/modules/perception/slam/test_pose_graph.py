"""The graph is corrected, wrong loops are not believed, and what is removed leaves its measurements behind."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.information import diagonal
from app.modules.perception.slam.pose_graph import graph_arrays, optimized, uncertainties, without
from app.modules.perception.slam.pruning import pruned, redundant
from app.modules.perception.slam.types import Edge, Submap

SURE = diagonal(1e4, 1e4, 1e5)


def circle(count: int = 40) -> list[Pose2]:
    return [Pose2(5 * math.sin(a), 5 - 5 * math.cos(a), a) for a in np.linspace(0, 2 * math.pi, count, endpoint=False)]


def chain(true: list[Pose2], bend: float) -> tuple[dict[int, Pose2], list[Edge]]:
    """Odometry around ``true`` that turns ``bend`` (rad) too much at each step."""
    steps = [a.inverse() @ b @ Pose2(0, 0, bend) for a, b in pairwise(true)]
    poses = {0: true[0]}
    for k, step in enumerate(steps):
        poses[k + 1] = poses[k] @ step
    return poses, [Edge(k, k + 1, step, SURE, loop=False) for k, step in enumerate(steps)]


def worst(found: np.ndarray, true: list[Pose2]) -> float:
    return max(math.dist(row[:2], (p.x, p.y)) for row, p in zip(found, true, strict=True))


def test_a_loop_straightens_what_odometry_bent() -> None:
    true = circle()
    poses, edges = chain(true, 0.004)
    assert worst(np.array([(p.x, p.y, p.theta) for p in poses.values()]), true) > 0.5
    loop = Edge(0, 39, true[0].inverse() @ true[39], SURE, loop=True)
    assert worst(optimized(graph_arrays(poses, [*edges, loop])), true) < 0.2


def test_one_false_loop_among_true_ones_does_little() -> None:
    true = circle()
    poses, edges = chain(true, 0.002)
    loops = [Edge(k, 39 - k, true[k].inverse() @ true[39 - k], SURE, loop=True) for k in range(6)]
    false = Edge(10, 30, Pose2(0.0, 0.0, 0.0), SURE, loop=True)
    good = optimized(graph_arrays(poses, [*edges, *loops]))
    assert worst(optimized(graph_arrays(poses, [*edges, *loops, false])), true) < worst(good, true) + 0.1
    believed = Edge(10, 30, Pose2(0.0, 0.0, 0.0), SURE, loop=False)
    assert worst(optimized(graph_arrays(poses, [*edges, *loops, believed])), true) > 1.0


@given(removed=st.sets(st.integers(1, 38), min_size=1, max_size=20))
@settings(max_examples=15, deadline=None)
def test_the_rest_stays_where_it_was_when_keyframes_are_removed(removed: set[int]) -> None:
    true = circle()
    poses, edges = chain(true, 0.0)
    left = edges
    for id in removed:
        left = without(left, id)
    rest = {id: pose for id, pose in poses.items() if id not in removed}
    assert {id for edge in left for id in (edge.a, edge.b)} <= set(rest)
    shaken = {id: Pose2(p.x + 0.1 * (id % 3), p.y, p.theta) if id else p for id, p in rest.items()}
    assert worst(optimized(graph_arrays(shaken, left)), list(rest.values())) < 0.01


def test_a_place_passed_for_ever_is_joined_no_more_often() -> None:
    edges = [Edge(0, 1, Pose2(1.0, 0.0, 0.0), SURE, loop=False)]
    for id in range(2, 60):
        edges += [Edge(0, id, Pose2(0.5, 0.0, 0.0), SURE, loop=True), Edge(1, id, Pose2(-0.5, 0.0, 0.0), SURE, True)]
        edges = without(edges, id)
    assert edges == [Edge(0, 1, Pose2(1.0, 0.0, 0.0), SURE, loop=False)]


def test_a_surer_way_round_replaces_what_joins_two() -> None:
    weak = Edge(0, 1, Pose2(1.2, 0.0, 0.0), diagonal(1.0, 1.0, 1.0), loop=True)
    round_about = [Edge(0, 2, Pose2(0.5, 0.0, 0.0), SURE, False), Edge(2, 1, Pose2(0.5, 0.0, 0.0), SURE, False)]
    (left,) = without([weak, *round_about], 2)
    assert {left.a, left.b} == {0, 1}
    assert abs(left.X_ab.x) == 1.0


def test_a_correction_goes_along_the_corridor_where_there_is_room_for_it() -> None:
    """Ten steps, each unsure along its own heading alone; the way turns off in its middle."""
    true = [Pose2(min(k, 5), max(0, k - 5), 0.0 if k < 5 else math.pi / 2) for k in range(11)]
    edges = [
        Edge(k, k + 1, a.inverse() @ b, diagonal(1e2, 1e6, 1e8), loop=False) for k, (a, b) in enumerate(pairwise(true))
    ]
    # The corner's own step is along x of the map, and along minus y of the keyframe it ends in.
    edges[4] = Edge(4, 5, edges[4].X_ab, diagonal(1e6, 1e2, 1e8), loop=False)
    poses = dict(enumerate(true))
    off = Edge(0, 10, true[10] @ Pose2(0.0, -0.5, 0.0), diagonal(1e6, 1e6, 1e8), loop=True)
    found = optimized(graph_arrays(poses, [*edges, off]))
    assert np.allclose(found[10, :2], (5.5, 5.0), atol=0.02)
    assert np.allclose(np.diff(found[:6, 0]), 1.1, atol=0.01)  # where it went along x it is longer, each step as much
    assert np.allclose(np.diff(found[5:, 0]), 0.0, atol=0.01)  # and where it went along y it stays straight


def test_the_oldest_of_what_shows_the_same_goes() -> None:
    poses = {id: Pose2(0.5, 0.5, 0.1) for id in range(30)} | {99: Pose2(5.5, 0.5, 0.1)}
    assert redundant(poses, {3}, per_m2=10, sectors=4) == [*range(3), *range(4, 21)]
    assert redundant({id: Pose2(0.5, 0.5, 0.1 + id * math.pi / 2) for id in range(40)}, set(), 10, 4) == []


def test_what_was_pruned_is_found_again() -> None:
    true = circle()
    poses, edges = chain(true, 0.0)
    submaps = [Submap(7, tuple(range(10))), Submap(8, tuple(range(8, 20)))]
    cut = pruned([3, 4, 5, 6, 7, 8, 9], edges, submaps)
    assert [submap.keyframes for submap in cut.submaps] == [tuple(range(10, 20))]
    assert cut.changed == {7, 8}
    for id in cut.removed:
        chain_, at = Pose2(), id
        while at in cut.replaced:
            at, X_ab = cut.replaced[at]
            chain_ = X_ab @ chain_
        found = poses[at] @ chain_
        assert math.dist((found.x, found.y), (true[id].x, true[id].y)) < 1e-6


def test_how_surely_a_pose_is_known_falls_along_the_way_and_rises_with_a_loop() -> None:
    true = circle()
    poses, edges = chain(true, 0.0)
    open_end = uncertainties(graph_arrays(poses, edges))
    assert (np.diff(open_end) > 0.0).all()
    assert open_end[0] < 0.001
    loop = Edge(0, 39, true[0].inverse() @ true[39], SURE, loop=True)
    closed = uncertainties(graph_arrays(poses, [*edges, loop]))
    assert closed[39] < 0.2 * open_end[39]
    assert (closed[1:] < open_end[1:]).all()


def test_where_no_edge_holds_a_pose_nothing_is_known() -> None:
    poses, edges = chain(circle(3), 0.0)
    assert np.isinf(uncertainties(graph_arrays(poses, edges[:1]))).all()
