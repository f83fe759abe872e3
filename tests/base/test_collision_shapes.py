"""Distances from collision shapes, and the shapes of a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.base.collision_shapes import CollisionShape, load_collision_shapes
from app.base.errors import ConfigError
from app.base.geometry import Pose3

URDF = Path(__file__).parents[2] / "config" / "robots" / "irl1_tr.urdf"
HERE = Pose3.identity()
SHAPES = [
    CollisionShape("a", "box", HERE, np.array([0.1, 0.2, 0.3])),
    CollisionShape("a", "cylinder", HERE, np.array([0.2, 0.2, 0.1])),
    CollisionShape("a", "cylinder", HERE, np.array([0.05, 0.05, 0.3])),
    CollisionShape("a", "sphere", HERE, np.array([0.2, 0.2, 0.2])),
]


def inside(shape: CollisionShape, points: np.ndarray) -> np.ndarray:
    if shape.kind == "box":
        return np.asarray((np.abs(points) <= shape.half).all(axis=1))
    if shape.kind == "sphere":
        return np.asarray(np.linalg.norm(points, axis=1) <= shape.half[0])
    return np.asarray((np.hypot(points[:, 0], points[:, 1]) <= shape.half[0]) & (np.abs(points[:, 2]) <= shape.half[2]))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_the_distance_is_that_of_the_nearest_point_inside(shape: CollisionShape) -> None:
    random = np.random.default_rng(4)
    cloud = random.uniform(-0.35, 0.35, (60000, 3))
    cloud = cloud[inside(shape, cloud)]
    for point in random.uniform(-0.6, 0.6, (40, 3)):
        nearest = np.linalg.norm(cloud - point, axis=1).min()
        distance = float(shape.distance(point[None])[0])
        assert distance <= nearest + 1e-12
        assert distance == pytest.approx(nearest, abs=0.05)
        assert (distance == 0.0) == bool(inside(shape, point[None])[0])


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_the_capsule_covers_the_shape(shape: CollisionShape) -> None:
    cloud = np.random.default_rng(5).uniform(-0.35, 0.35, (20000, 3))
    cloud = cloud[inside(shape, cloud)]
    begin, end, radius = shape.capsule()
    along = end - begin
    share = np.clip((cloud - begin) @ along / max(along @ along, 1e-12), 0, 1)
    flat = shape.kind == "cylinder" and shape.half[0] > shape.half[2]
    beside = np.linalg.norm(cloud - begin - share[:, None] * along, axis=1).max()
    assert beside <= radius * (2**0.5 if flat else 1) + 1e-12


def test_the_files_shapes_are_read_with_their_links_and_places() -> None:
    shapes = load_collision_shapes(URDF)
    torso = next(shape for shape in shapes if shape.link == "torso_link")
    assert (torso.kind, torso.half.tolist(), torso.X_LS.translation.tolist()) == ("box", [0.1, 0.14, 0.35], [0, 0, 0.2])
    wheel = next(shape for shape in shapes if shape.link == "left_wheel_link")
    np.testing.assert_allclose(np.abs(wheel.X_LS.rotation[:, 2]), [0, 1, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('<mesh filename="a.stl"/>', "a collision shape of a is neither"),
        ('<box size="1 2"/>', "is no URDF"),
        ('<sphere radius="wide"/>', "is no URDF"),
    ],
)
def test_other_shapes_are_refused_in_words(tmp_path: Path, text: str, problem: str) -> None:
    path = tmp_path / "body.urdf"
    path.write_text(f'<robot><link name="a"><collision><geometry>{text}</geometry></collision></link></robot>')
    with pytest.raises(ConfigError, match=problem):
        load_collision_shapes(path)
    with pytest.raises(ConfigError, match="cannot be read"):
        load_collision_shapes(tmp_path / "none.urdf")
