from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.landmarks.sightings import Fused, Sightings, fused, joined, moved, sighting
from tests.modules.perception.landmarks.graphs import turned

FloatArray = NDArray[np.float64]
SEEDS = st.integers(0, 2**32 - 1)
POSES = st.builds(Pose2, st.floats(-20, 20), st.floats(-20, 20), st.floats(-3.1, 3.1))


def pose_rows(count: int, rng: np.random.Generator) -> FloatArray:
    return np.column_stack((rng.uniform(-5, 5, (count, 2)), rng.uniform(-3, 3, count)))


def some(anchors: list[int], rng: np.random.Generator) -> list[Sightings]:
    """One sighting for each of ``anchors``: of about the same place on the map, whatever its keyframe."""
    made = []
    for anchor in anchors:
        root = rng.normal(0, 0.05, (3, 3))
        covariance = root @ root.T + 1e-4 * np.eye(3)
        made.append(sighting(anchor, rng.uniform(-2, 2, 3), covariance, rng.normal(0.5, 0.3), rng.uniform(0.03, 0.2)))
    return made


def all_of(sightings: list[Sightings]) -> Sightings:
    first, *others = sightings
    for other in others:
        first = joined(first, other)
    return first


def assert_same(one: Fused, other: Fused) -> None:
    np.testing.assert_allclose(one.p, other.p, atol=1e-6)
    np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-4, atol=1e-9)
    assert one.heading is not None
    assert other.heading is not None
    assert turned(one.heading, other.heading) < 1e-6


@given(st.lists(st.integers(0, 3), min_size=1, max_size=8), SEEDS)
def test_the_order_of_sightings_does_not_matter(anchors: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    sightings = some(anchors, rng)
    one = all_of(sightings)
    other = all_of([sightings[row] for row in rng.permutation(len(sightings))])
    assert one.anchors.tolist() == other.anchors.tolist() == sorted(set(anchors))
    poses = pose_rows(len(one.anchors), rng)
    assert_same(fused(one, poses, 0.02, 0.03), fused(other, poses, 0.02, 0.03))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=8), POSES, SEEDS)
def test_a_rigid_move_of_the_keyframes_moves_the_landmark_rigidly(anchors: list[int], by: Pose2, seed: int) -> None:
    rng = np.random.default_rng(seed)
    sightings = all_of(some(anchors, rng))
    poses = pose_rows(len(sightings.anchors), rng)
    before = fused(sightings, poses, 0.02, 0.03)
    moved_poses = np.array([(X.x, X.y, X.theta) for X in (by @ Pose2(*row) for row in poses.tolist())])
    after = fused(sightings, moved_poses, 0.02, 0.03)
    np.testing.assert_allclose(after.p, [*by.transform(before.p[:2]), before.p[2]], atol=1e-6)
    np.testing.assert_allclose(np.trace(after.covariance), np.trace(before.covariance), rtol=1e-6)
    assert before.heading is not None
    assert after.heading is not None
    assert turned(after.heading, before.heading + by.theta) < 1e-6
    assert after.heading_sigma == before.heading_sigma or math.isclose(
        after.heading_sigma or 0.0, before.heading_sigma or 0.0, rel_tol=1e-6
    )


@given(st.lists(st.integers(0, 5), min_size=1, max_size=8), SEEDS)
def test_pruning_a_keyframe_loses_nothing(anchors: list[int], seed: int) -> None:
    """A row alone on its keyframe is the same sighting in the frame of another; the landmark stays where it is."""
    rng = np.random.default_rng(seed)
    sightings = all_of(some(anchors, rng))
    poses = pose_rows(len(sightings.anchors), rng)
    before = fused(sightings, poses, 1e-5, 1e-5)
    # The first keyframe is joined to one that has no sighting yet, anywhere.
    into = Pose2(*pose_rows(1, rng)[0].tolist())
    X_IK = into.inverse() @ Pose2(*poses[0].tolist())
    rows = sightings.anchors == sightings.anchors[0]
    after = moved(sightings, rows, np.array([99]), np.array([[X_IK.x, X_IK.y, X_IK.theta]]))
    assert after.anchors.tolist() == [*sightings.anchors[1:].tolist(), 99]
    assert_same(fused(after, np.vstack((poses[1:], [[into.x, into.y, into.theta]])), 1e-5, 1e-5), before)


@given(SEEDS)
def test_rows_joined_by_pruning_keep_their_information(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sightings = all_of(some([0, 1], rng))
    X = Pose2(*pose_rows(1, rng)[0].tolist())
    after = moved(sightings, sightings.anchors == 0, np.array([1]), np.array([[X.x, X.y, X.theta]]))
    assert after.anchors.tolist() == [1]
    np.testing.assert_allclose(
        np.trace(after.information[0]), np.trace(sightings.information[0]) + np.trace(sightings.information[1])
    )


def test_many_sightings_from_one_place_share_its_error() -> None:
    same = all_of([sighting(0, np.array([1.0, 0.0, 1.2]), 0.05**2 * np.eye(3), 3.0, 0.1)] * 200)
    at = fused(same, np.zeros((1, 3)), 0.02, 0.03)
    assert math.isclose(float(np.sqrt(np.trace(at.covariance) / 3)), 0.02, rel_tol=0.02)
    assert at.heading_sigma is not None
    assert 0.03 <= at.heading_sigma < 0.035


def test_contradicting_places_are_less_sure_than_each_alone() -> None:
    apart = joined(
        sighting(0, np.array([1.0, 0.0, 1.2]), 0.03**2 * np.eye(3)),
        sighting(1, np.array([1.4, 0.0, 1.2]), 0.03**2 * np.eye(3)),
    )
    at = fused(apart, np.zeros((2, 3)), 0.02, 0.03)
    assert float(np.sqrt(np.trace(at.covariance) / 3)) > 0.06
    assert at.p[0] == 1.2
    assert at.heading is None


def test_headings_are_averaged_across_the_half_turn() -> None:
    both = joined(
        sighting(0, np.zeros(3), np.eye(3), math.pi - 0.1, 0.1), sighting(0, np.zeros(3), np.eye(3), 0.1 - math.pi, 0.1)
    )
    at = fused(both, np.zeros((1, 3)), 0.02, 0.03)
    assert at.heading is not None
    assert turned(at.heading, math.pi) < 1e-9
