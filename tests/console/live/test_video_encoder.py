"""JPEGs as VP9: what a decoder makes of them again."""

from __future__ import annotations

import sys

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from app.console.live.picture_budget import Form
from app.console.live.video_encoder import NoEncoder, VideoEncoder, VideoPicture, can_encode


def scene(step: int, width: int = 640, height: int = 480) -> NDArray[np.uint8]:
    """A view (H, W, 3) BGR of blue sky over green, with a red box that moves right by 4 px each ``step``."""
    pixels = np.zeros((height, width, 3), np.uint8)
    pixels[: height // 2] = (200, 120, 40)
    pixels[height // 2 :] = (60, 140, 70)
    left = 40 + 4 * step
    pixels[height // 3 : height // 2, left : left + width // 5] = (30, 30, 190)
    return pixels


def jpeg_of(pixels: NDArray[np.uint8]) -> bytes:
    """``pixels`` as a JPEG of quality 90."""
    return cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].tobytes()


class Player:
    """Decodes VP9, picture by picture."""

    def __init__(self) -> None:
        self._decoder = av.VideoCodecContext.create("vp9", "r")

    def shown(self, picture: VideoPicture | None) -> NDArray[np.uint8]:
        """What ``picture`` shows: (H, W, 3) BGR."""
        assert picture is not None
        (frame,) = self._decoder.decode(av.Packet(picture.data))
        assert (frame.width, frame.height) == (picture.width, picture.height)
        # As a player does: by what the stream says of its colours.
        assert (frame.colorspace, frame.color_range) == (6, 1)
        return np.asarray(frame.to_ndarray(format="bgr24"), np.uint8)


def error(shown: NDArray[np.uint8], pixels: NDArray[np.uint8]) -> float:
    """How far colours are off: the mean over all pixels and channels (0 to 255)."""
    height, width = shown.shape[:2]
    small = cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA)
    return float(np.abs(shown.astype(float) - small).mean())


@pytest.mark.parametrize("form", [Form(None, bits=0.17), Form(320, bits=0.17), Form(160, bits=0.16)])
def test_each_picture_comes_out_at_once_and_as_it_was(form: Form) -> None:
    encoder, player = VideoEncoder(), Player()
    for step in range(20):
        pixels = scene(step)
        picture = encoder.encode(jpeg_of(pixels), form)
        assert picture is not None
        assert picture.key == (step == 0)
        assert picture.width == (form.width or 640)
        assert error(player.shown(picture), pixels) < 6


def test_video_takes_a_fraction_of_the_bytes() -> None:
    encoder = VideoEncoder()
    noise = np.random.default_rng(2).integers(0, 40, (480, 700, 3), np.uint8)
    as_they_come = as_video = 0
    for step in range(30):
        # A camera that turns: all of the picture moves.
        jpeg = jpeg_of(np.ascontiguousarray(scene(0) + noise[:, 2 * step : 2 * step + 640]))
        picture = encoder.encode(jpeg, Form(640, bits=0.12))
        assert picture is not None
        as_they_come += len(jpeg)
        as_video += len(picture.data)
    assert as_video < 0.2 * as_they_come


def test_it_begins_afresh_where_asked_and_at_another_size_or_rate() -> None:
    encoder = VideoEncoder()
    forms = [Form(640, bits=0.17)] * 3 + [Form(640, bits=0.12), Form(320, bits=0.12), Form(320, bits=0.12)]
    keys = []
    for step, form in enumerate(forms):
        picture = encoder.encode(jpeg_of(scene(step)), form, afresh=step == 2)
        assert picture is not None
        keys.append(picture.key)
        if picture.key:
            # Nothing of before is needed.
            assert error(Player().shown(picture), scene(step)) < 12
    assert keys == [True, False, True, True, True, False]


def test_pictures_are_never_enlarged_and_have_even_sides() -> None:
    encoder = VideoEncoder()
    picture = encoder.encode(jpeg_of(scene(0, 101, 77)), Form(320, bits=0.2))
    assert picture is not None
    assert (picture.width, picture.height) == (100, 76)


def test_a_damaged_jpeg_is_passed_over() -> None:
    encoder, player = VideoEncoder(), Player()
    player.shown(encoder.encode(jpeg_of(scene(0)), Form(320, bits=0.17)))
    assert encoder.encode(b"no JPEG", Form(320, bits=0.17)) is None
    assert error(player.shown(encoder.encode(jpeg_of(scene(1)), Form(320, bits=0.17))), scene(1)) < 6


def test_a_grey_jpeg_is_grey(monkeypatch: pytest.MonkeyPatch) -> None:
    grey = np.full((120, 160), 180, np.uint8)
    shown = Player().shown(VideoEncoder().encode(cv2.imencode(".jpg", grey)[1].tobytes(), Form(160, bits=0.2)))
    assert np.abs(shown.astype(int) - 180).max() < 6


def test_without_pyav_there_is_no_encoder(monkeypatch: pytest.MonkeyPatch) -> None:
    assert can_encode()
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(NoEncoder, match="PyAV cannot be loaded"):
        VideoEncoder()


def test_a_pyav_without_libvpx_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(av, "codecs_available", {"libx264"})
    with pytest.raises(NoEncoder, match="no libvpx-vp9"):
        VideoEncoder()
