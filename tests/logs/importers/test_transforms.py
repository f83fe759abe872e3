"""The tree of frames: chains, interpolation, and the end of what is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose3
from app.logs.importers.transforms import StampedTransform, Transforms

ANGLES = st.floats(-3.0, 3.0)
POSES = st.builds(
    lambda t, r: Pose3.from_translation_rpy(t, r),
    st.tuples(*[st.floats(-5.0, 5.0)] * 3),
    st.tuples(ANGLES, st.floats(-1.5, 1.5), ANGLES),
)


def placed(stamp: float, pose: Pose3) -> StampedTransform:
    w, x, y, z = pose.quaternion_wxyz()
    a, b, c = (float(value) for value in pose.translation)
    return StampedTransform(stamp, (a, b, c), (x, y, z, w))


def turned(q: tuple[float, float, float, float], stamp: float = 0.0) -> StampedTransform:
    return StampedTransform(stamp, (0.0, 0.0, 0.0), q)


def same(one: Pose3 | None, other: Pose3, tolerance: float = 1e-9) -> None:
    assert one is not None
    np.testing.assert_allclose(one.rotation, other.rotation, atol=tolerance)
    np.testing.assert_allclose(one.translation, other.translation, atol=tolerance)


@given(POSES, POSES, POSES)
def test_a_chain_is_the_product_of_its_poses_both_ways(X_AB: Pose3, X_BC: Pose3, X_AD: Pose3) -> None:
    tree = Transforms()
    tree.add("a", "b", placed(0.0, X_AB), static=True)
    tree.add("b", "c", placed(0.0, X_BC), static=True)
    tree.add("a", "d", placed(0.0, X_AD), static=True)
    same(tree.lookup("a", "c", 5.0), X_AB @ X_BC)
    same(tree.lookup("c", "a", 5.0), (X_AB @ X_BC).inverse())
    same(tree.lookup("d", "c", 5.0), X_AD.inverse() @ X_AB @ X_BC)
    same(tree.lookup("c", "c", 5.0), Pose3.identity())


@given(st.floats(0.0, 1.0), st.floats(-3.0, 3.0), st.floats(-1.5, 1.5))
def test_a_turn_between_two_stamps_is_a_part_of_it(fraction: float, begin: float, turn: float) -> None:
    tree = Transforms()
    for stamp, angle in ((10.0, begin), (10.5, begin + turn)):
        tree.add(
            "a", "b", placed(stamp, Pose3.from_translation_rpy((stamp, 0.0, 0.0), (0.0, 0.0, angle))), static=False
        )
    found = tree.lookup("a", "b", 10.0 + 0.5 * fraction)
    truth = Pose3.from_translation_rpy((10.0 + 0.5 * fraction, 0.0, 0.0), (0.0, 0.0, begin + turn * fraction))
    same(found, truth, 1e-6)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: sum(v * v for v in q) > 1e-3), st.floats(0.1, 3.0))
def test_any_quaternion_but_zero_is_a_rotation_whatever_its_length(
    q: tuple[float, float, float, float], scale: float
) -> None:
    R = turned(q).pose().rotation
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(R) == pytest.approx(1.0)
    x, y, z, w = (value * scale for value in q)
    np.testing.assert_allclose(turned((x, y, z, w)).pose().rotation, R, atol=1e-9)


def test_slerp_takes_the_shorter_way() -> None:
    half = math.sqrt(0.5)
    other = turned((0.0, 0.0, -half, -half), stamp=1.0)  # a quarter turn, said with the other sign
    between = turned((0.0, 0.0, 0.0, 1.0)).between(other, 0.5).pose()
    np.testing.assert_allclose(between.rotation @ [1, 0, 0], [half, half, 0], atol=1e-9)


def test_what_moves_is_known_only_as_far_as_it_was_said() -> None:
    tree = Transforms(tolerance_s=0.5)
    tree.add("a", "b", placed(10.0, Pose3.identity()), static=False)
    assert tree.lookup("a", "b", 10.4) is not None
    assert tree.lookup("a", "b", 9.6) is not None
    assert tree.lookup("a", "b", 10.6) is None
    assert tree.lookup("a", "nobody", 10.0) is None
    assert tree.connected("a", "b")
    assert not tree.connected("a", "nobody")


def test_late_transforms_take_their_place_and_old_ones_are_forgotten() -> None:
    tree = Transforms(span_s=10.0)
    for stamp in (0.0, 0.2, 0.1, 0.1):
        tree.add("a", "b", placed(stamp, Pose3.from_translation_rpy((stamp, 0.0, 0.0))), static=False)
    same(tree.lookup("a", "b", 0.15), Pose3.from_translation_rpy((0.15, 0.0, 0.0)))
    for i in range(1, 2000):
        tree.add("a", "b", placed(0.2 + 0.05 * i, Pose3.identity()), static=False)
    assert tree.lookup("a", "b", 0.15) is None
    assert tree.lookup("a", "b", 95.0) is not None


def test_static_transforms_can_be_kept_alone() -> None:
    tree = Transforms()
    tree.add("base", "laser", placed(0.0, Pose3.identity()), static=True)
    tree.add("odom", "base", placed(0.0, Pose3.identity()), static=False)
    tree.add("odom", "laser", placed(0.0, Pose3.from_translation_rpy((1.0, 0.0, 0.0))), static=True)
    assert tree.path("laser", "odom") == ("laser",)
    assert tree.standing().frames() == {"odom", "laser"}


def test_a_tree_that_bites_its_tail_is_walked_once() -> None:
    tree = Transforms()
    tree.add("a", "b", placed(0.0, Pose3.identity()), static=True)
    tree.add("b", "a", placed(0.0, Pose3.identity()), static=True)
    assert tree.lookup("a", "c", 0.0) is None
    assert tree.path("a", "c") == ()
