from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2, Pose3
from app.messages import Image, Odometry, PointCloud
from app.modules.perception.point_cloud import colored_cloud
from app.modules.perception.pose_at import PoseAt
from app.runtime.clock import VirtualClock, run_virtual
from tests.modules.fakes import Bench, drain

CAMERA = CameraModel.from_vertical_fov(640, 480, math.radians(43))
#: A camera 1.3 m up, looking forward and 20 degrees down: optical x right, y down, z forward.
LOOKING = Pose3.from_translation_rpy((0.1, 0.0, 1.3), (-math.pi / 2 - math.radians(20), 0.0, -math.pi / 2))


def image(stamp: float, depth: NDArray[np.uint16] | None, X_BC: Pose3 = LOOKING, camera: CameraModel = CAMERA) -> Image:
    v, u = np.mgrid[: camera.height, : camera.width]
    color = np.stack((u % 256, v % 256, np.full_like(u, 7)), axis=-1).astype(np.uint8)
    return Image(stamp, "kinect_optical_frame", color, depth, camera, X_BC)


def floor_depth(camera: CameraModel, X_BC: Pose3) -> NDArray[np.uint16]:
    """Depth (mm) of the plane z = 0 of base_link, 0 where it is not seen within 5 m."""
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = camera.back_project(np.stack((u, v), -1).astype(float), np.ones(u.shape))
    down = (rays @ X_BC.rotation.T)[..., 2]
    with np.errstate(divide="ignore"):
        z = np.where(down < 0, -X_BC.translation[2] / down, np.inf)
    return np.where(z < 5.0, np.round(z * 1000), 0).astype(np.uint16)


def test_the_floor_comes_out_flat_at_zero_in_base_link() -> None:
    points, colors = colored_cloud(image(0.0, floor_depth(CAMERA, LOOKING)), 19_200)
    assert points.dtype == np.float32
    assert colors.dtype == np.uint8
    assert 3_000 < len(points) <= 19_200
    assert np.abs(points[:, 2]).max() < 0.002
    assert points[:, 0].min() > 0.5, "in front of the robot"
    assert abs(points[:, 1].mean()) < 0.01, "as far left as right"


def test_a_point_has_its_own_pixels_colour_and_place() -> None:
    depth = np.zeros((480, 640), np.uint16)
    depth[100, 300] = 2000
    points, colors = colored_cloud(image(0.0, depth, Pose3.identity()), 640 * 480)
    expected = CAMERA.back_project(np.array([[300.0, 100.0]]), np.array([2.0]))
    np.testing.assert_allclose(points, expected, atol=1e-5)
    assert colors.tolist() == [[300 % 256, 100, 7]]


@given(st.integers(4, 90), st.integers(4, 90), st.integers(1, 10_000), st.integers(0, 2**32 - 1))
def test_never_more_points_than_asked_nor_points_without_depth(
    width: int, height: int, max_points: int, seed: int
) -> None:
    camera = CameraModel(width, height, 50.0, 50.0, width / 2, height / 2)
    depth = np.random.default_rng(seed).integers(0, 3, (height, width)).astype(np.uint16) * np.uint16(900)
    points, colors = colored_cloud(image(0.0, depth, Pose3.identity(), camera), max_points)
    assert len(points) == len(colors) <= max_points
    assert (points[:, 2] > 0).all()
    if max_points >= width * height:
        assert len(points) == np.count_nonzero(depth)


def test_an_image_without_depth_is_refused_in_words() -> None:
    with pytest.raises(ValueError, match="kinect_optical_frame gives no depth"):
        colored_cloud(image(0.0, None), 100)


def bench(**options: Any) -> Bench:
    return Bench(
        "app.modules.perception.point_cloud_builder:PointCloudBuilder",
        inputs={"images": Image, "odometry": Odometry},
        outputs={"clouds": PointCloud},
        **options,
    )


def odometry(stamp: float) -> Odometry:
    """The robot drives along x at 1 m/s from stamp 0."""
    return Odometry(stamp, Pose2(stamp, 0.0, 0.0), 1.0, 0.0)


def test_a_cloud_waits_for_the_pose_of_its_own_instant() -> None:
    depth = floor_depth(CAMERA, LOOKING)

    async def main() -> None:
        async with bench() as b:
            clouds = b.listen("clouds")
            now = b.clock.now()
            b.feed("odometry", odometry(now - 0.02))
            b.feed("images", image(now, depth))
            await b.clock.sleep(0.2)
            assert drain(clouds) == [], "the newest pose is not the pose at the stamp"
            b.feed("odometry", odometry(now - 0.01))
            b.feed("odometry", odometry(now + 0.01))
            cloud = await clouds.receive()
            assert cloud.stamp == now
            assert cloud.X_OB.x == pytest.approx(now)
            assert not cloud.points.flags.writeable
            assert not cloud.colors.flags.writeable

    run_virtual(main())


def test_a_cloud_whose_pose_never_comes_is_dropped_and_said_once(caplog: pytest.LogCaptureFixture) -> None:
    depth = floor_depth(CAMERA, LOOKING)

    async def main() -> None:
        async with bench() as b:
            clouds = b.listen("clouds")
            for _ in range(3):
                b.feed("images", image(b.clock.now(), depth))
                await b.clock.sleep(1.0)
            assert drain(clouds) == []
            stamp = b.clock.now()
            b.feed("odometry", odometry(stamp - 0.01))
            b.feed("odometry", odometry(stamp))
            b.feed("images", image(stamp, depth))
            assert (await clouds.receive()).stamp == stamp

    run_virtual(main())
    assert len([r for r in caplog.records if "clouds are dropped" in r.message]) == 1


def test_the_desire_says_how_many_points() -> None:
    depth = floor_depth(CAMERA, LOOKING)

    async def main() -> None:
        async with bench() as b:
            clouds = b.listen("clouds")
            b.feed("odometry", odometry(b.clock.now()))
            b.feed("odometry", odometry(b.clock.now() + 5))
            counts = []
            for parameters in ({}, {"max_points": 1000, "jpeg_quality": 50}, {"max_points": 76_800}):
                b.slot.configure(parameters)
                b.feed("images", image(b.clock.now(), depth))
                counts.append(len((await clouds.receive()).points))
            assert counts[1] <= 1000 < counts[0] <= 19_200 < counts[2] <= 76_800

    run_virtual(main())


def test_a_stamp_older_than_all_odometry_has_no_pose() -> None:
    async def main() -> None:
        poses = PoseAt(VirtualClock())
        poses.add(odometry(5.0))
        assert await poses.at(4.9) is None
        assert await poses.at(5.0) == Pose2(5.0, 0.0, 0.0)

    run_virtual(main())
