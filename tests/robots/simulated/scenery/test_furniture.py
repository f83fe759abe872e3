"""Furniture: every kind is on the floor and keeps, roughly, to its size."""

from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose3
from app.robots.simulated.scenery.furniture import KINDS, Part, furnish

SIZE = (0.9, 0.6, 1.4)


def corners(part: Part) -> np.ndarray:
    """The eight corners of the box around a part, in the piece's frame."""
    half = np.array(part.size) / 2
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return np.asarray(Pose3.from_translation_rpy(part.at, part.rpy).transform(signs * half))


@pytest.mark.parametrize("kind", KINDS)
def test_a_piece_stands_on_the_floor_and_keeps_to_its_size(kind: str) -> None:
    parts = furnish(kind, SIZE, None, np.random.default_rng(1), frozenset())
    assert parts
    points = np.concatenate([corners(part) for part in parts])
    assert points[:, 2].min() >= -0.02
    low, high = points.min(axis=0), points.max(axis=0)
    assert (high - low > 0.1).any()
    assert np.abs(points[:, 0]).max() <= SIZE[0] * 0.8
    assert points[:, 2].max() <= max(SIZE[2] + 0.45, 1.7)
    for part in parts:
        assert all(size > 0 for size in part.size)
        if not isinstance(part.material, str):
            assert all(0 <= c <= 1 for c in part.material)


def test_chance_gives_variety_and_the_same_seed_the_same_piece() -> None:
    def shelf(seed: int) -> list[Part]:
        return furnish("shelf", None, None, np.random.default_rng(seed), frozenset({"oak"}))

    assert shelf(1) == shelf(1)
    assert shelf(1) != shelf(2)


def test_a_material_the_world_lacks_becomes_a_colour_and_a_named_one_is_used() -> None:
    rng = np.random.default_rng(0)
    assert not isinstance(furnish("box", None, None, rng, frozenset())[0].material, str)
    assert furnish("box", None, None, rng, frozenset({"cardboard"}))[0].material == "cardboard"
    assert furnish("box", None, "steel", rng, frozenset())[0].material == "steel"
