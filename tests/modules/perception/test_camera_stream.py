from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from app.base.geometry import CameraModel, Pose3
from app.messages import EncodedImage, Image
from app.modules.perception.camera_stream import encode_jpeg
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench

CAMERA = CameraModel(64, 48, 60.0, 60.0, 31.5, 23.5)


def scene() -> Image:
    """Left half red, right half blue."""
    color = np.zeros((48, 64, 3), np.uint8)
    color[:, :32, 0] = 200
    color[:, 32:, 2] = 200
    return Image(3.0, "kinect_optical_frame", color, None, CAMERA, Pose3.identity())


def decoded(jpeg: bytes) -> Any:
    return cv2.cvtColor(np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)), cv2.COLOR_BGR2RGB)


def test_colours_survive() -> None:
    jpeg, width, height = encode_jpeg(scene().color, 95)
    picture = decoded(jpeg)
    assert (width, height) == (64, 48)
    assert picture.shape == (48, 64, 3)
    np.testing.assert_allclose(picture[24, 10], (200, 0, 0), atol=12)
    np.testing.assert_allclose(picture[24, 54], (0, 0, 200), atol=12)


@pytest.mark.parametrize(("width", "expected"), [(32, (32, 24)), (64, (64, 48)), (1000, (64, 48)), (20, (20, 15))])
def test_reduced_but_never_enlarged(width: int, expected: tuple[int, int]) -> None:
    jpeg, w, h = encode_jpeg(scene().color, 80, width)
    assert (w, h) == expected
    assert decoded(jpeg).shape == (expected[1], expected[0], 3)


def test_the_module_encodes_each_image_with_the_desires_quality() -> None:
    noise = np.random.default_rng(1).integers(0, 255, (48, 64, 3)).astype(np.uint8)

    async def main() -> None:
        b = Bench(
            "app.modules.perception.camera_stream:CameraStream",
            inputs={"images": Image},
            outputs={"pictures": EncodedImage},
        )
        async with b:
            pictures = b.listen("pictures")
            sizes = []
            for quality in (30, 80, 95):
                b.slot.configure({"jpeg_quality": quality, "max_points": 1000})
                b.feed("images", Image(4.0, "kinect_optical_frame", noise, None, CAMERA, Pose3.identity()))
                picture = await pictures.receive()
                assert (picture.stamp, picture.frame) == (4.0, "kinect_optical_frame")
                assert (picture.width, picture.height) == (64, 48)
                sizes.append(len(picture.jpeg))
            assert sizes == sorted(set(sizes)), "better quality, more bytes"
            assert b.slot.context.meter.cpu_ns > 0

    run_virtual(main())
