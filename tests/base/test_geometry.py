from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3, azimuth_elevation, unit_vector, wrap_angle

angles = st.floats(-1e4, 1e4)
metres = st.floats(-100, 100)
poses2 = st.builds(Pose2, metres, metres, angles)
vectors = st.tuples(metres, metres, metres)
turns = st.tuples(*[st.floats(-math.pi, math.pi)] * 3)
poses3 = st.builds(Pose3.from_translation_rpy, vectors, turns)
points = arrays(np.float64, (5, 3), elements=st.floats(-50, 50))
cameras = st.builds(CameraModel.from_vertical_fov, st.integers(2, 2000), st.integers(2, 2000), st.floats(0.1, 3.0))


def same2(a: Pose2, b: Pose2) -> bool:
    return (
        math.isclose(a.x, b.x, abs_tol=1e-8)
        and math.isclose(a.y, b.y, abs_tol=1e-8)
        and abs(wrap_angle(a.theta - b.theta)) < 1e-8
    )


def same3(a: Pose3, b: Pose3) -> bool:
    return np.allclose(a.rotation, b.rotation, atol=1e-9) and np.allclose(a.translation, b.translation, atol=1e-7)


# --- angles ---


@given(angles)
def test_a_wrapped_angle_is_the_same_direction_and_in_range(angle: float) -> None:
    wrapped = wrap_angle(angle)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped - angle) == pytest.approx(1, abs=1e-9)
    assert wrap_angle(wrapped) == pytest.approx(wrapped, abs=1e-12) or abs(wrapped) > math.pi - 1e-9


@pytest.mark.parametrize(
    "angle",
    [
        math.nextafter(-math.pi, -10),
        math.nextafter(-3 * math.pi, -10),
        -math.pi - 1e-15,
        math.pi,
        -math.pi,
        3 * math.pi,
    ],
)
def test_the_seam_itself_is_minus_pi_never_pi(angle: float) -> None:
    # Rounding in the remainder can give the modulus itself.
    assert -math.pi <= wrap_angle(angle) < math.pi


# --- the plane ---


@given(poses2, poses2, poses2)
def test_planar_poses_are_a_group(a: Pose2, b: Pose2, c: Pose2) -> None:
    assert same2((a @ b) @ c, a @ (b @ c))
    assert same2(a @ a.inverse(), Pose2())
    assert same2(a.inverse() @ a, Pose2())
    assert same2((a @ b).inverse(), b.inverse() @ a.inverse())
    assert same2(a @ Pose2(), a)


@given(poses2, poses2)
def test_the_plane_agrees_with_space(a: Pose2, b: Pose2) -> None:
    assert same3((a @ b).to_pose3(), a.to_pose3() @ b.to_pose3())


@given(poses2, points)
def test_points_of_the_plane_go_where_poses_do(pose: Pose2, found: np.ndarray) -> None:
    moved = pose.transform(found[:, :2])
    for (x, y), point in zip(moved, found, strict=True):
        at = pose @ Pose2(float(point[0]), float(point[1]))
        assert (at.x, at.y) == pytest.approx((x, y), abs=1e-9)
    assert pose.transform(found[:0, :2]).shape == (0, 2)


@given(poses2, poses2, st.floats(0, 1))
def test_interpolation_goes_from_one_to_the_other_by_the_shorter_arc(a: Pose2, b: Pose2, fraction: float) -> None:
    assert same2(a.interpolate(b, 0), a)
    assert same2(a.interpolate(b, 1), b)
    part = a.interpolate(b, fraction)
    whole_turn = abs(wrap_angle(b.theta - a.theta))
    assert abs(wrap_angle(part.theta - a.theta)) <= whole_turn + 1e-8
    assert math.hypot(part.x - a.x, part.y - a.y) == pytest.approx(
        fraction * math.hypot(b.x - a.x, b.y - a.y), abs=1e-8
    )


def test_a_planar_pose_places_what_lies_ahead_of_it() -> None:
    # One metre ahead of a robot at (2, 1) that looks along +y is (2, 2).
    X_WB = Pose2(2.0, 1.0, math.pi / 2)
    assert same2(X_WB @ Pose2(1.0), Pose2(2.0, 2.0, math.pi / 2))


# --- space ---


@given(poses3, poses3, poses3, points)
def test_poses_in_space_are_a_group_that_acts_on_points(a: Pose3, b: Pose3, c: Pose3, p: np.ndarray) -> None:
    assert same3((a @ b) @ c, a @ (b @ c))
    assert same3(a @ a.inverse(), Pose3.identity())
    assert np.allclose((a @ b).transform(p), a.transform(b.transform(p)), atol=1e-8)
    assert np.allclose(a.inverse().transform(a.transform(p)), p, atol=1e-8)


@given(vectors, turns)
def test_fixed_axis_angles_are_those_of_urdf(translation: tuple[float, ...], rpy: tuple[float, ...]) -> None:
    pose = Pose3.from_translation_rpy(translation, rpy)  # type: ignore[arg-type]
    assert np.allclose(pose.rotation, Rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-12)
    assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose.rotation) == pytest.approx(1)
    assert tuple(pose.translation) == translation


@given(st.one_of(turns, st.sampled_from([(math.pi, 0, 0), (0, math.pi, 0), (0, 0, math.pi), (0, 0, 0)])))
def test_the_quaternion_is_the_same_rotation(rpy: tuple[float, float, float]) -> None:
    pose = Pose3.from_translation_rpy((0, 0, 0), rpy)
    w, x, y, z = pose.quaternion_wxyz()
    assert w >= 0
    assert math.hypot(w, x, y, z) == pytest.approx(1)
    assert np.allclose(Rotation.from_quat((x, y, z, w)).as_matrix(), pose.rotation, atol=1e-7)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_points_keep_their_precision_and_shape(dtype: type[np.floating]) -> None:
    pose = Pose3.from_translation_rpy((1, 2, 3), (0, 0, math.pi / 2))
    cloud = np.ones((4, 6, 3), dtype=dtype)
    moved = pose.transform(cloud)
    assert moved.dtype == dtype
    assert moved.shape == cloud.shape
    assert np.allclose(moved[2, 3], (0, 3, 4), atol=1e-6)


# --- cameras ---


@given(cameras, arrays(np.float64, (7, 2), elements=st.floats(0, 2000)), st.floats(0.1, 50))
def test_back_projection_undoes_projection(camera: CameraModel, pixels: np.ndarray, depth: float) -> None:
    points = camera.back_project(pixels, np.full(7, depth))
    assert np.allclose(points[:, 2], depth)
    assert np.allclose(camera.project(points), pixels, atol=1e-6)


@given(cameras, st.floats(0.1, 3.0))
def test_the_field_of_view_reaches_from_edge_to_edge(camera: CameraModel, depth: float) -> None:
    # Pixel centres: the edges of the image lie half a pixel beyond the outermost ones.
    edges = np.array([[camera.cx, -0.5], [camera.cx, camera.height - 0.5]])
    top, bottom = camera.back_project(edges, np.full(2, depth))
    assert top[1] == pytest.approx(-bottom[1])
    assert math.atan2(bottom[1], depth) == pytest.approx(math.atan2(0.5 * camera.height, camera.fy))


def test_the_kinect_sees_57_by_43_degrees() -> None:
    camera = CameraModel.from_vertical_fov(640, 480, math.radians(43))
    assert 2 * math.degrees(math.atan(320 / camera.fx)) == pytest.approx(55.4, abs=0.1)
    assert 2 * math.degrees(math.atan(240 / camera.fy)) == pytest.approx(43)


def test_what_is_not_in_front_has_no_pixel() -> None:
    camera = CameraModel.from_vertical_fov(640, 480, 0.75)
    pixels = camera.project(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 1.0, -1.0]]))
    assert pixels[0] == pytest.approx((319.5, 239.5))
    assert np.isnan(pixels[1:]).all()


fisheyes = st.builds(
    FisheyeModel.from_fov, st.integers(16, 2000), st.integers(16, 2000), st.floats(0.5, 3.1), st.floats(0.5, 3.1)
)


@given(fisheyes, st.floats(0, 0.999), st.floats(-math.pi, math.pi), st.floats(0.1, 50))
def test_a_fisheye_sees_again_what_it_projected(camera: FisheyeModel, part: float, phi: float, distance: float) -> None:
    theta = part * camera.theta_max
    ray = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])
    pixel = camera.project(distance * ray)
    assert np.allclose(camera.rays(pixel), ray, atol=1e-9)
    assert np.allclose(camera.back_project(pixel, np.array(distance)), distance * ray, atol=1e-7)
    assert np.allclose(camera.project(camera.rays(pixel)), pixel, atol=1e-6)


@given(fisheyes)
def test_a_fisheye_is_blind_beyond_its_widest_angle(camera: FisheyeModel) -> None:
    theta = camera.theta_max + 0.01
    beyond = np.array([math.sin(theta), 0.0, math.cos(theta)])
    assert np.isnan(camera.project(np.stack([beyond, np.zeros(3), [0.0, 0.0, -1.0]]))).all()
    assert np.isnan(camera.rays(np.array([camera.cx + 1.01 * camera.theta_max * camera.fx, camera.cy]))).all()


def test_the_panoramic_camera_fills_its_sensor_with_the_hemisphere_in_front() -> None:
    camera = FisheyeModel.from_fov(1024, 768, math.pi, math.pi)
    right, down, ahead = (camera.project(np.array(p)) for p in ([1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]))
    assert np.allclose(right, [1023.5, 383.5])
    assert np.allclose(down, [511.5, 767.5])
    assert np.allclose(ahead, [511.5, 383.5])


@given(cameras, arrays(np.float64, (7, 2), elements=st.floats(0, 2000)))
def test_rays_point_where_the_pixels_look(camera: CameraModel, pixels: np.ndarray) -> None:
    rays = camera.rays(pixels)
    assert np.allclose(np.linalg.norm(rays, axis=-1), 1.0)
    assert np.allclose(camera.project(rays), pixels, atol=1e-6)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(0.1, 10))
def test_a_direction_and_its_angles_are_each_others_inverse(azimuth: float, elevation: float, length: float) -> None:
    assert azimuth_elevation(length * unit_vector(azimuth, elevation)) == pytest.approx((azimuth, elevation))


def test_angles_of_a_direction_are_positive_to_the_left_and_up() -> None:
    assert unit_vector(math.pi / 2, 0.0) == pytest.approx((0.0, 1.0, 0.0))
    assert unit_vector(0.0, math.pi / 2) == pytest.approx((0.0, 0.0, 1.0))
