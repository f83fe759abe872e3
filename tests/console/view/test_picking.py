"""What a point of a view shows: rays that go where the camera says, and the first thing that each meets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.console.view.picking import FARTHEST_M, Boxes, Kind, Pickable, Ray, distances, picked, ray_through
from app.console.view.viewpoints import Anchors, Shot, shot
from app.console.view.voxels import VOXEL_M
from app.messages import Landmark
from tests.console.view.projection import projected

NONE = (np.zeros((0, 3)), np.zeros((0, 3)))
SHOTS = st.builds(
    Shot,
    st.tuples(*[st.floats(-5, 5)] * 3),
    azimuth=st.floats(-math.pi, math.pi),
    elevation=st.floats(-1.5, 1.5),
    distance=st.floats(0.1, 20),
    fov=st.floats(0.3, 2.0),
)
POSES = st.builds(Pose2, st.floats(-20, 20), st.floats(-20, 20), st.floats(-math.pi, math.pi))
COORDINATES = st.floats(-4, 4)


def poster(x: float, y: float, z: float, number: int = 1) -> Landmark:
    return Landmark(f"poster {number}", (x, y, z), 0.02, 5, 0.0, 1.0, id=number)


def world(
    *posters: Landmark,
    walls: tuple[NDArray[np.float64], NDArray[np.float64]] = NONE,
    voxels: object = (),
    **poses: Pose2,
) -> Pickable:
    seen = np.array(voxels, np.float64).reshape(-1, 3)
    return Pickable(posters, poses.get("X_OP", Pose2()), walls, poses.get("X_OM", Pose2()), seen)


def wall_ahead(x: float) -> Boxes:
    """Low, across the way."""
    return np.array([[x, -1.0, 0.0]]), np.array([[x + 0.1, 1.0, 0.4]])


def surface(x: float) -> NDArray[np.float64]:
    """Voxels of a high surface across the way, with as many gaps as voxels."""
    across, up = np.meshgrid(np.arange(-20, 20), np.arange(0, 30))
    kept = (across + up) % 2 == 0
    cells = np.stack([np.full(kept.sum(), math.floor(x / VOXEL_M)), across[kept], up[kept]], axis=1)
    return (cells + 0.5) * VOXEL_M


def toward(p: tuple[float, float, float], eye: tuple[float, float, float] = (0.0, 0.0, 1.2)) -> Ray:
    way = np.array(p) - eye
    return Ray(np.array(eye), way / np.linalg.norm(way))


@given(SHOTS, st.floats(0.4, 3), st.floats(0, 1), st.floats(0, 1), st.floats(0.5, 30))
def test_a_ray_is_seen_where_it_was_asked_for(camera: Shot, aspect: float, u: float, v: float, away: float) -> None:
    ray = ray_through(camera, aspect, u, v)
    assert np.linalg.norm(ray.direction) == pytest.approx(1.0)
    assert projected(camera, aspect, ray.at(away)) == (pytest.approx(u, abs=1e-6), pytest.approx(v, abs=1e-6))


@given(POSES, SHOTS, st.floats(0, 30))
def test_a_ray_s_points_are_the_same_in_every_frame(X_AB: Pose2, camera: Shot, away: float) -> None:
    ray = ray_through(camera, 1.5, 0.3, 0.8)
    np.testing.assert_allclose(ray.in_frame(X_AB).at(away), X_AB.to_pose3().transform(ray.at(away)[None])[0], atol=1e-9)


@given(
    st.tuples(*[COORDINATES] * 3),
    st.tuples(*[COORDINATES] * 3),
    st.tuples(*[COORDINATES] * 3),
    st.tuples(*[st.floats(0.05, 2)] * 3),
)
def test_a_box_is_entered_at_its_surface_or_missed_all_along(
    eye: tuple[float, ...], to: tuple[float, ...], corner: tuple[float, ...], size: tuple[float, ...]
) -> None:
    way = np.array(to) - eye
    assume(np.linalg.norm(way) > 1e-3)
    ray = Ray(np.array(eye), way / np.linalg.norm(way))
    low, high = np.array([corner]), np.array([corner]) + size
    (distance,) = distances(ray, (low, high))
    # Far enough for every box there is, in steps of a few centimetres.
    along = ray.origin + np.linspace(0.0, 25.0, 1001)[:, None] * ray.direction
    inside = np.all((along > low + 1e-6) & (along < high - 1e-6), axis=1)
    if math.isinf(distance):
        assert not inside.any()
        return
    assert not inside[: math.floor(distance / 0.025)].any()
    entered = ray.at(distance)
    assert (low - 1e-6 <= entered).all()
    assert (entered <= high + 1e-6).all()
    on_side = np.isclose(entered, low, atol=1e-6) | np.isclose(entered, high, atol=1e-6)
    assert on_side.any() or distance == 0.0


@pytest.mark.parametrize(("y", "distance"), [(0.0, 2.0), (1.0, 2.0), (1.01, math.inf)])
def test_a_ray_along_a_box_s_sides_meets_it_between_them(y: float, distance: float) -> None:
    ray = Ray(np.array([0.0, y, 0.2]), np.array([1.0, 0.0, 0.0]))
    assert distances(ray, wall_ahead(2.0)).tolist() == [distance]


@pytest.mark.parametrize(
    ("there", "at", "kind", "p"),
    [
        (world(), (3.0, 1.0, 0.0), "floor", (3.0, 1.0, 0.0)),
        (world(), (1.0, 0.0, 1.2), "nothing", None),
        (world(), (1.0, 0.0, 1.7), "nothing", None),
        (world(), (FARTHEST_M, 0.0, 0.0), "nothing", None),
        (world(walls=wall_ahead(2.0)), (3.0, 0.0, 0.0), "wall", (2.0, 0.0, 0.4)),
        (world(walls=wall_ahead(4.0)), (3.0, 0.0, 0.0), "floor", (3.0, 0.0, 0.0)),
        (world(walls=wall_ahead(2.0), voxels=surface(1.5)), (3.0, 0.0, 0.0), "seen", (1.475, 0.0, 0.61)),
        (world(voxels=surface(1.5)), (1.5, 0.3, 1.0), "seen", (1.475, 0.295, 1.003)),
        (world(voxels=[[2.0, 0.0, 0.025]]), (2.0, 0.0, 0.025), "floor", (2.04, 0.0, 0.0)),
        (world(poster(3.0, 0.0, 1.3)), (3.0, 0.05, 1.25), "poster", (3.0, 0.0, 1.3)),
        (world(poster(3.0, 0.0, 1.3), voxels=surface(3.0)), (3.0, 0.0, 1.3), "poster", (3.0, 0.0, 1.3)),
        (world(poster(3.0, 0.0, 1.3), voxels=surface(1.0)), (3.0, 0.0, 1.3), "seen", (0.975, 0.0, 1.2325)),
        (world(poster(8.0, 0.0, 1.3)), (8.0, 0.0, 1.5), "poster", (8.0, 0.0, 1.3)),  # a little beside it
        (world(poster(8.0, 0.0, 1.3)), (8.0, 0.0, 1.6), "nothing", None),
        (world(poster(3.0, 0.2, 1.3, 1), poster(3.0, -0.2, 1.3, 2)), (3.0, -0.1, 1.3), "poster", (3.0, -0.2, 1.3)),
        (world(poster(3.0, 0.0, 1.3, 1), poster(2.0, 0.0, 1.3, 2)), (2.0, 0.0, 1.3), "poster", (2.0, 0.0, 1.3)),
    ],
)
def test_the_first_thing_on_the_ray_is_picked(
    there: Pickable, at: tuple[float, float, float], kind: Kind, p: tuple[float, float, float] | None
) -> None:
    found = picked(toward(at), there)
    assert (found.kind, found.p) == (kind, p if p is None else pytest.approx(p, abs=0.03))
    assert (found.poster is not None) == (kind == "poster")


def test_posters_and_walls_are_picked_where_the_map_lies() -> None:
    X_OM = Pose2(1.0, 0.0, math.pi / 2)
    there = world(poster(0.0, -2.0, 1.3), X_OP=X_OM, X_OM=X_OM)
    found = picked(toward((3.0, 0.0, 1.3)), there)
    assert (found.kind, found.p) == ("poster", pytest.approx((3.0, 0.0, 1.3)))
    assert found.on_map(X_OM).p == pytest.approx((0.0, -2.0, 1.3))
    assert found.on_map(X_OM).frame == "map"
    wall = world(walls=(np.array([[-1.0, -1.1, 0.0]]), np.array([[1.0, -1.0, 0.4]])), X_OM=X_OM)
    assert picked(toward((3.0, 0.0, 0.0)), wall).p == pytest.approx((2.0, 0.0, 0.4))
    nothing = picked(toward((0.0, 0.0, 5.0)), there)
    assert nothing.on_map(X_OM) == nothing


@given(POSES, st.floats(0.5, 6), st.floats(-2, 2), st.floats(0.3, 2.5), st.floats(0.3, 2.5))
def test_every_viewpoint_picks_the_poster_that_it_has_there(
    robot: Pose2, ahead: float, left: float, height: float, aspect: float
) -> None:
    p = robot.to_pose3().transform(np.array([[ahead, left, height]]))[0]
    for viewpoint in ("behind", "aligned", "top"):
        camera = shot(viewpoint, Anchors(robot))
        u, v = projected(camera, aspect, np.array([ahead, left, height]))
        x, y, z = p
        found = picked(ray_through(camera, aspect, u, v).in_frame(robot), world(poster(x, y, z)))
        assert found.p == pytest.approx(tuple(p))


@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(0.1, 8))
def test_the_floor_is_picked_as_far_as_it_counts(x: float, y: float, height: float) -> None:
    eye = (0.0, 0.0, height)
    found = picked(toward((x, y, 0.0), eye), world())
    away = math.hypot(x, y, height)
    assume(abs(away - FARTHEST_M) > 1e-6)
    assert found.kind == ("floor" if away < FARTHEST_M else "nothing")
    if found.p is not None:
        assert found.p == pytest.approx((x, y, 0.0), abs=1e-6)
