"""Point clouds: read back by a reader of the format's own rules, and where a camera model says they are."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose2, Pose3
from app.log_tools.export.exporter import Wish, export
from app.logs.log import Logged
from app.messages import Image, LaserScan, PointCloud
from tests.log_tools.export.fakes import MemoryLog

BEGIN = 1_790_000_000.5


def read_pcd(path: Path) -> tuple[dict[str, str], NDArray[np.void]]:
    """Header and points of a binary PCD, by the field names, sizes and types that the header gives."""
    data = path.read_bytes()
    head, body = data[: data.index(b"DATA binary\n")], data[data.index(b"DATA binary\n") + 12 :]
    lines = [line.split(" ", 1) for line in head.decode("ascii").splitlines() if not line.startswith("#")]
    header = dict(lines)
    kinds = {"F": "f", "U": "u", "I": "i"}
    columns = zip(header["FIELDS"].split(), header["TYPE"].split(), header["SIZE"].split(), strict=True)
    points = np.frombuffer(body, [(name, f"<{kinds[kind]}{size}") for name, kind, size in columns])
    assert len(points) == int(header["POINTS"]) == int(header["WIDTH"]) * int(header["HEIGHT"])
    return header, points


def only(message: PointCloud | LaserScan | Image, folder: Path) -> NDArray[np.void]:
    export(MemoryLog([Logged(BEGIN, "seen", message)]), Wish("pcd", folder))
    (file,) = (folder / "seen-points").iterdir()
    assert file.name == "1790000000.500000.pcd"
    header, points = read_pcd(file)
    assert header["VERSION"] == "0.7"
    assert header["VIEWPOINT"] == "0 0 0 1 0 0 0"
    return points


def xyz(points: NDArray[np.void]) -> NDArray[np.float64]:
    return np.stack([points[name] for name in "xyz"], axis=-1).astype(np.float64)


def rgb(points: NDArray[np.void]) -> NDArray[np.uint32]:
    bits = np.ascontiguousarray(points["rgb"]).view(np.uint32)
    return np.stack([(bits >> shift) & 255 for shift in (16, 8, 0)], axis=-1)


def test_a_cloud_keeps_points_and_colours(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    points = rng.normal(0, 3, (500, 3)).astype(np.float32)
    colors = rng.integers(0, 256, (500, 3), np.uint8)
    got = only(PointCloud(BEGIN, points, colors, Pose2()), tmp_path)
    np.testing.assert_array_equal(xyz(got), points)
    np.testing.assert_array_equal(rgb(got), colors)


def test_a_depth_image_is_where_its_camera_says(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    camera = CameraModel(32, 24, 30.0, 31.0, 15.5, 11.0)
    depth = rng.integers(500, 5000, (24, 32)).astype(np.uint16)
    depth[rng.random(depth.shape) < 0.3] = 0
    color = rng.integers(0, 256, (24, 32, 3), np.uint8)
    pose = Pose3.from_translation_rpy((0.1, -0.2, 1.2), (0.2, 0.3, -0.4))
    got = only(Image(BEGIN, "camera", color, depth, camera, pose), tmp_path)
    assert len(got) == np.count_nonzero(depth)
    # Back through the camera: every point falls on its own pixel, with its depth and colour.
    back = pose.inverse().transform(xyz(got))
    pixels = np.rint(camera.project(back)).astype(int)
    np.testing.assert_allclose(back[:, 2], depth[pixels[:, 1], pixels[:, 0]] / 1000, atol=1e-4)
    np.testing.assert_array_equal(rgb(got), color[pixels[:, 1], pixels[:, 0]])
    assert len({tuple(pixel) for pixel in pixels.tolist()}) == len(got)


def test_a_scan_has_the_points_that_were_met(tmp_path: Path) -> None:
    ranges = np.array([1.0, np.inf, 2.0, 0.01, 40.0], np.float32)
    pose = Pose3.from_translation_rpy((0.5, 0.0, 0.3), (0, 0, math.pi))
    scan = LaserScan(BEGIN, "laser", ranges, ranges * 2, 0.0, math.pi / 4, 0.06, 30.0, 0.02, pose)
    got = only(scan, tmp_path)
    np.testing.assert_allclose(xyz(got), [[-0.5, 0, 0.3], [0.5, -2, 0.3]], atol=1e-6)
    np.testing.assert_array_equal(got["intensity"], [2.0, 4.0])


def test_images_without_depth_are_said_to_have_no_points(tmp_path: Path) -> None:
    camera = CameraModel(4, 2, 1.0, 1.0, 0.0, 0.0)
    image = Image(BEGIN, "camera", np.zeros((2, 4, 3), np.uint8), None, camera, Pose3.identity())
    (line,) = export(MemoryLog([Logged(BEGIN, "view", image)]), Wish("pcd", tmp_path)).lines()
    assert "its 1 images have no depth" in line
    assert list(tmp_path.iterdir()) == []
