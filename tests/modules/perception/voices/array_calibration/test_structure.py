"""Structure from arrival times: positions up to what sound shows, and orders of channels."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.array_calibration.structure import (
    affine_structure,
    aligned,
    directions,
    likely_orders,
    order_misfit,
)
from tests.modules.perception.voices.array_calibration.clap_sounds import CORNERS, CROSS, around, ways


def far(count: int, seed: int, level: bool = False) -> NDArray[np.float64]:
    """Places a kilometre away."""
    return 1000 * around(count, seed, level)


def turned(seed: int) -> NDArray[np.float64]:
    """An orthogonal matrix (3, 3): a rotation, or one and a mirror."""
    return np.asarray(np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0])


def distances(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.linalg.norm(positions[:, None] - positions[None], axis=2))


@settings(deadline=None, max_examples=40)
@given(st.integers(4, 12), st.integers(0, 10_000))
def test_structure_is_found_up_to_turn_and_mirror(count: int, seed: int) -> None:
    placed = np.random.default_rng(seed).uniform(-0.2, 0.2, (count, 3))
    found = affine_structure(ways(far(14, seed), placed))
    extents = np.linalg.svd(placed - placed.mean(axis=0), compute_uv=False)
    if found is None:  # nearly flat
        assert extents[2] < 0.25 * extents[0]
        return
    np.testing.assert_allclose(aligned(found, placed, mirror=True), placed, atol=2e-3 * extents[0] / extents[2])


def test_what_does_not_determine_the_structure_gives_none() -> None:
    assert affine_structure(ways(far(14, 1), CROSS)) is None
    assert affine_structure(ways(far(7, 1), CORNERS)) is None
    # All on one cone: at one elevation.
    cone = far(14, 1)
    cone[:, 2] = 0.5 * np.linalg.norm(cone[:, :2], axis=1)
    assert affine_structure(ways(cone, CORNERS)) is None


def test_a_plane_is_found_with_sounds_of_one_height() -> None:
    sources = far(14, 2)
    sources[:, 2] = 0
    placed = CROSS + np.random.default_rng(0).normal(0, 0.003, CROSS.shape) * (1, 1, 0)
    found = affine_structure(ways(sources, placed), 2)
    assert found is not None
    np.testing.assert_allclose(aligned(found, placed, mirror=True), placed, atol=1e-5)


@given(st.integers(3, 10), st.integers(0, 1000), st.integers(0, 1000))
def test_aligning_undoes_turns_and_leaves_mirrors(count: int, seed: int, turn: int) -> None:
    placed = np.random.default_rng(seed).uniform(-1, 1, (count, 3))
    rotation = turned(turn)
    moved = placed @ rotation + (3, -2, 1)
    np.testing.assert_allclose(aligned(moved, placed, mirror=True), placed, atol=1e-9)
    if np.linalg.det(rotation) > 0:
        np.testing.assert_allclose(aligned(moved, placed), placed, atol=1e-9)
    elif count > 3:  # three points are their own mirror image
        assert np.abs(aligned(moved, placed) - placed).max() > 1e-3


@given(st.integers(0, 1000))
def test_directions_are_those_of_the_sources(seed: int) -> None:
    sources = far(5, seed)
    unit = sources / np.linalg.norm(sources, axis=1, keepdims=True)
    np.testing.assert_allclose(directions(ways(sources, CORNERS), CORNERS), unit, atol=1e-3)
    visible = unit * (1, 1, 0)
    np.testing.assert_allclose(directions(ways(sources, CROSS), CROSS), visible, atol=1e-3)


@pytest.mark.parametrize(
    ("configured", "level"), [(CORNERS, False), (CROSS, True), (np.vstack([CORNERS * 0.6, CORNERS[:5] + 0.03]), False)]
)
def test_the_order_is_found_up_to_what_keeps_distances(configured: NDArray[np.float64], level: bool) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        # Within a stretch of the plane, arrays of four in it are one another.
        off = rng.normal(0, 0.004, configured.shape) * (0.3 * np.array([1, 1, 0]) if level else 1)
        order = rng.permutation(len(configured))
        heard = ways(around(14, seed, level), (configured + off)[order])
        likely = np.array(likely_orders(heard, configured, 24))
        misfits = order_misfit(heard, configured, likely)
        assert (np.diff(misfits) >= 0).all()
        # Claps are near, positions are not quite as configured: another order may seem a little better.
        assert misfits[0] <= order_misfit(heard, configured, order[None])[0] + 1e-12
        assert any(np.allclose(distances(configured[one]), distances(configured[order])) for one in likely)


def test_the_misfit_does_not_depend_on_how_the_array_is_turned() -> None:
    heard = ways(around(12, 3), CORNERS)
    orders = np.array(list(itertools.permutations(range(8)))[::997])
    misfits = order_misfit(heard, CORNERS, orders)
    np.testing.assert_allclose(order_misfit(heard, CORNERS @ turned(1), orders), misfits, atol=1e-9)
    assert misfits.argmin() == 0
