"""What the benchmark of picture coding measures of a picture."""

from __future__ import annotations

import numpy as np
import pytest

from app.console.live.picture_budget import Form
from app.messages import EncodedImage
from benchmarks.picture_coding import as_jpeg, as_vp9, psnr
from tests.console.live.test_video_encoder import jpeg_of, scene


def picture(step: int) -> EncodedImage:
    """The picture ``step`` of a scene in which a box moves."""
    return EncodedImage(float(step), "camera", jpeg_of(scene(step)), 640, 480, None)  # type: ignore[arg-type]


@pytest.mark.parametrize(("measure", "form"), [(as_jpeg, Form(320, 60)), (as_vp9, Form(320, bits=0.17))])
def test_all_pictures_are_made_and_look_as_they_came(measure, form: Form) -> None:  # type: ignore[no-untyped-def]
    cpu_ms, size, decoding_ms, quality = measure([picture(step) for step in range(6)], form)
    assert cpu_ms > 0
    assert decoding_ms > 0
    assert 100 < size < 20_000
    assert quality > 28


def test_psnr_is_of_the_mean_squared_error() -> None:
    flat = np.full((480, 640, 3), 100, np.uint8)
    image = EncodedImage(0.0, "camera", jpeg_of(flat), 640, 480, None)  # type: ignore[arg-type]
    assert psnr(np.full((480, 640, 3), 110, np.uint8), image) == pytest.approx(28.13, abs=0.2)
