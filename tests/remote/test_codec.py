"""Messages over the link: what comes back, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app import messages
from app.base.geometry import CameraModel, FisheyeModel, Pose2, Pose3
from app.messages import Image, Odometry
from app.remote.codec import BadPayload, Codec, difference, shape_of, travels

STAMP = 1795477318.4555814
PINHOLE = CameraModel.from_vertical_fov(64, 48, 0.75)
FISHEYE = FisheyeModel.from_fov(64, 48, math.pi, math.pi)


def picture(*, depth: bool = True, camera: CameraModel | FisheyeModel = PINHOLE) -> Image:
    """A picture of a gradient, which JPEG keeps well."""
    v, u = np.mgrid[0:48, 0:64]
    color = np.stack((4 * u, 5 * v, 2 * (u + v)), axis=-1).astype(np.uint8)
    millimetres = (1000 + 13 * u + 7 * v).astype(np.uint16) if depth else None
    return Image(STAMP, "a_frame", color, millimetres, camera, Pose3(np.eye(3), np.array((0.1, -0.2, 1.3))))


@pytest.mark.parametrize("camera", [PINHOLE, FISHEYE])
@pytest.mark.parametrize("depth", [True, False])
def test_all_of_an_image_but_its_colours_comes_back_exactly(camera: CameraModel | FisheyeModel, depth: bool) -> None:
    image = picture(depth=depth, camera=camera)
    codec = Codec(Image, 90)
    back = codec.decode(codec.encode(image))
    assert (back.stamp, back.frame, back.camera) == (image.stamp, image.frame, camera)
    np.testing.assert_array_equal(back.X_BC.translation, image.X_BC.translation)
    if depth:
        np.testing.assert_array_equal(back.depth, image.depth)
    else:
        assert back.depth is None
    assert np.abs(back.color.astype(int) - image.color).mean() < 4
    assert not back.color.flags.writeable


def test_raw_colours_come_back_exactly() -> None:
    codec = Codec(Image, None)
    np.testing.assert_array_equal(codec.decode(codec.encode(picture())).color, picture().color)


@given(st.floats(1e9, 2.1e9))
def test_the_stamp_comes_back_to_the_last_bit(stamp: float) -> None:
    codec = Codec(Odometry)
    odometry = Odometry(stamp, Pose2(1.0, -2.0, 0.5), 0.3, -0.1)
    assert codec.decode(codec.encode(odometry)) == odometry


def test_every_message_of_a_channel_travels() -> None:
    classes: list[Any] = [getattr(messages, name) for name in messages.__all__]
    stamped: list[Any] = [cls for cls in classes if dataclasses.is_dataclass(cls) and hasattr(cls, "stamp")]
    assert stamped
    assert {cls.__name__: why for cls in stamped if (why := travels(cls))} == {}


@given(st.data())
def test_damaged_bytes_are_refused_and_nothing_else_happens(data: st.DataObject) -> None:
    codec = Codec(Image, 90)
    whole = bytearray(codec.encode(picture()))
    at = data.draw(st.integers(0, 300))
    whole[at : at + 4] = data.draw(st.binary(min_size=0, max_size=8))
    try:
        back = codec.decode(bytes(whole))
    except BadPayload:
        return
    assert back.color.shape[2] == 3


@pytest.mark.parametrize("data", [b"", b"1234567", bytes(8), bytes(40)])
def test_too_few_bytes_are_refused(data: bytes) -> None:
    for kind in (Image, Odometry):
        with pytest.raises(BadPayload):
            Codec(kind).decode(data)


def test_depth_that_unpacks_to_more_than_its_pixels_is_refused() -> None:
    codec = Codec(Image, None)
    small = picture()
    assert small.depth is not None
    huge = dataclasses.replace(small, depth=np.zeros((4000, 4000), np.uint16))
    with pytest.raises(BadPayload, match="depth is not that of 64 x 48"):
        codec.decode(codec.encode(huge))


def test_a_difference_of_shapes_is_named(tmp_path: Path) -> None:
    here = shape_of(Odometry)
    assert difference(here, dict(here)) == ""
    assert difference(here, {**here, "Pose2.x": "int"}) == "Pose2.x is float here and int there"
    assert difference(here, {k: v for k, v in here.items() if k != "Pose2.y"}) == "there is no Pose2.y there"
    assert difference(here, {**here, "Odometry.slip": "float"}) == "there is no Odometry.slip here"
