from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from app.robots.devices.config import CameraConfig
from app.robots.devices.image_inputs import InputUnavailable, PlaybackTimer, open_pictures
from tests.base.test_image_source import BOMBS
from tests.robots.devices.files import picture_file, video_file


def levels(path: Path, count: int, **more: Any) -> list[int | None]:
    source = open_pictures(CameraConfig(source=str(path), **more))
    try:
        pictures = [source.read() for _ in range(count)]
    finally:
        source.close()
    return [None if picture is None else round(float(picture.mean())) for picture in pictures]


def test_a_video_comes_in_order_and_over_again(tmp_path: Path) -> None:
    path = video_file(tmp_path, [40, 120, 200])
    assert levels(path, 5) == pytest.approx([40, 120, 200, 40, 120], abs=3)
    assert levels(path, 4, loop=False)[3] is None
    assert open_pictures(CameraConfig(source=str(path))).rate_hz == 50
    assert open_pictures(CameraConfig(source=str(path), rate_hz=7)).rate_hz == 7


def test_a_folder_of_pictures_comes_by_name(tmp_path: Path) -> None:
    for name, level in (("b.png", 90), ("a.png", 30), ("c.png", 250)):
        picture_file(tmp_path, name, level)
    (tmp_path / "notes.txt").write_text("no picture")
    assert levels(tmp_path, 4, seconds_each=0.01) == [30, 90, 250, 30]
    assert levels(tmp_path / "b.png", 2) == [90, 90]


def test_each_picture_of_a_folder_is_shown_for_a_while(tmp_path: Path) -> None:
    for name, level in (("a.png", 30), ("b.png", 90)):
        picture_file(tmp_path, name, level)
    usual = round(1.5 * 15)
    assert levels(tmp_path, 2 * usual + 1) == [30] * usual + [90] * usual + [30]
    assert levels(tmp_path, 7, seconds_each=0.5, rate_hz=6, loop=False) == [30, 30, 30, 90, 90, 90, None]
    with pytest.raises(ValidationError, match="seconds_each"):
        CameraConfig(seconds_each=0)


def test_each_image_is_an_array_of_its_own(tmp_path: Path) -> None:
    source = open_pictures(CameraConfig(source=str(picture_file(tmp_path, "a.png", 30))))
    first, second = source.read(), source.read()
    assert first is not None
    assert second is not None
    first[:] = 0
    assert second.mean() == 30


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("gone.mp4", None, "there is no file"),
        ("gone.png", None, "cannot be read: No such file"),
        ("broken.png", b"not a picture", "is no picture"),
        ("huge.png", BOMBS["PNG"], "huge.png has 60000 x 60000 pixels; at most 128 million are decoded"),
        ("broken.mp4", b"not a video", "cannot be read as a video (MP4, AVI, MKV, WebM) or a picture"),
        ("empty", "folder", "there are no pictures"),
    ],
)
def test_what_cannot_be_opened_says_why(tmp_path: Path, name: str, content: bytes | str | None, said: str) -> None:
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif content is not None:
        path.mkdir()
    with pytest.raises(InputUnavailable, match=re.escape(said)):
        open_pictures(CameraConfig(source=str(path)))


def test_a_camera_that_is_not_there_says_what_else_to_do() -> None:
    with pytest.raises(InputUnavailable, match=r"camera 97 cannot be opened.*--camera FILE"):
        open_pictures(CameraConfig(source="97"))


def test_a_stall_is_not_made_up_for() -> None:
    pace = PlaybackTimer(10.0)
    start = pace._due
    assert pace.wait_s(start) == pytest.approx(0.1)
    assert pace.wait_s(start + 0.1) == pytest.approx(0.1)
    assert pace.wait_s(start + 5.0) == 0
    assert pace.wait_s(start + 5.0) == pytest.approx(0.1)
