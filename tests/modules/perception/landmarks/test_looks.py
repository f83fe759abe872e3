from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.messages import Image
from app.modules.perception.landmarks.looks import should_show
from tests.modules.perception.rendering import X_BC, facing, kinect_image

HERE = Pose2()


def empty_wall(x: float = 1.5) -> Image:
    """A picture of a wall at ``x`` without a code: one is drawn and painted over."""
    image = kinect_image(0.0, HERE, {"door": facing(x, 0.0, 1.3)})
    return replace(image, color=np.full_like(image.color, 160))


def shows(image: Image, x: float = 1.5, y: float = 0.0, heading: float = math.pi) -> bool:
    return should_show(image, X_BC, np.array([x, y, 1.3]), heading)


def test_a_look_from_near_at_a_free_lit_wall_should_show_it() -> None:
    assert shows(empty_wall())


@pytest.mark.parametrize(
    ("x", "y", "heading"),
    [
        pytest.param(2.3, 0.0, math.pi, id="too far"),
        pytest.param(1.5, 0.0, math.pi - 0.6, id="aslant"),
        pytest.param(1.5, 0.0, 0.0, id="from behind"),
        pytest.param(1.5, 0.85, math.pi, id="not wholly in the picture"),
        pytest.param(-1.5, 0.0, 0.0, id="behind the robot"),
    ],
)
def test_other_looks_say_nothing(x: float, y: float, heading: float) -> None:
    image = empty_wall(max(x, 1.5))
    assert not shows(image, x, y, heading)


def test_what_stands_before_it_darkness_and_missing_depth_say_nothing() -> None:
    image = empty_wall()
    assert image.depth is not None
    near = image.depth.copy()
    near[:, : near.shape[1] // 2 + 20] = 900
    assert not shows(replace(image, depth=near)), "a person stands before it"
    assert not shows(replace(image, color=np.full_like(image.color, 20)))
    assert not shows(replace(image, depth=np.zeros_like(image.depth)))
    assert not shows(replace(image, depth=None))
    far = np.where(image.depth > 0, image.depth + 800, 0).astype(np.uint16)
    assert shows(replace(image, depth=far)), "the board that it hung on is gone, too"
