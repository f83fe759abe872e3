"""PNG and video: what comes out is what the camera saw, when it saw it."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import CameraModel, Pose3
from app.log_tools.export import mp4
from app.log_tools.export.exporter import Wish, export
from app.logs.log import LogError, Logged
from app.messages import EncodedImage, Image, read_only
from tests.log_tools.export.fakes import MemoryLog

BEGIN = 1_790_000_000.25
#: PyAV's frames, and OpenCV's.
WRITERS = {"exact": mp4.ExactVideo, "constant": mp4.ConstantRateVideo}


def image(at: float, level: int, size: tuple[int, int] = (48, 64), depth: bool = True) -> Image:
    height, width = size
    color = np.full((height, width, 3), (level, 255 - level, 20), np.uint8)
    deep = np.arange(height * width, dtype=np.uint16).reshape(size) * 9 if depth else None
    camera = CameraModel(width, height, 50.0, 50.0, width / 2, height / 2)
    return Image(at, "camera", read_only(color), deep, camera, Pose3.identity())


def log_of(times: list[float], rate_hz: float | None = 10.0, size: tuple[int, int] = (48, 64)) -> MemoryLog:
    """Images whose red grows by ten with each."""
    return MemoryLog(
        [Logged(BEGIN + at + 0.003, "camera", image(BEGIN + at, 10 * k, size)) for k, at in enumerate(times)], rate_hz
    )


def test_colour_and_depth_come_back_exactly(tmp_path: Path) -> None:
    export(log_of([0.0, 0.1]), Wish("png", tmp_path / "out"))
    name = "1790000000.350000.png"
    color = cv2.imread(str(tmp_path / "out" / "camera" / name), cv2.IMREAD_COLOR_RGB)
    depth = cv2.imread(str(tmp_path / "out" / "camera-depth" / name), cv2.IMREAD_UNCHANGED)
    expected = image(0, 10)
    assert color is not None
    assert depth is not None
    np.testing.assert_array_equal(color, expected.color)
    np.testing.assert_array_equal(depth, expected.depth)
    assert depth.dtype == np.uint16
    assert sorted(each.name for each in (tmp_path / "out" / "camera").iterdir()) == ["1790000000.250000.png", name]


def test_a_jpeg_becomes_a_png(tmp_path: Path) -> None:
    done, data = cv2.imencode(".jpg", np.full((40, 30, 3), (10, 20, 200), np.uint8))
    assert done
    message = EncodedImage(BEGIN, "camera", data.tobytes(), 30, 40, Pose3.identity())
    export(MemoryLog([Logged(BEGIN, "view", message)]), Wish("png", tmp_path / "out"))
    (file,) = (tmp_path / "out" / "view").iterdir()
    read = cv2.imread(str(file))
    assert read is not None
    assert read.shape == (40, 30, 3)
    np.testing.assert_allclose(read[20, 15], (10, 20, 200), atol=6)


def test_one_of_so_many_and_a_piece_of_time(tmp_path: Path) -> None:
    log = log_of([0.1 * k for k in range(20)])
    export(log, Wish("png", tmp_path / "out", begin=BEGIN + 0.5, end=BEGIN + 1.5, every=3))
    names = sorted(each.stem for each in (tmp_path / "out" / "camera").iterdir())
    assert [round(float(name) - BEGIN, 3) for name in names] == [0.5, 0.8, 1.1, 1.4]


def test_files_that_are_there_are_not_mixed_with_new_ones(tmp_path: Path) -> None:
    export(log_of([0.0]), Wish("png", tmp_path / "out"))
    with pytest.raises(LogError, match="has files already"):
        export(log_of([0.5]), Wish("png", tmp_path / "out"))
    export(log_of([0.5]), Wish("png", tmp_path / "out", force=True))
    assert len(list((tmp_path / "out" / "camera").iterdir())) == 2


# --- Video -------------------------------------------------------------------------------------------------------


@pytest.fixture(params=list(WRITERS))
def writer(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Every way there is to write a video."""
    name: str = request.param
    if name == "exact" and importlib.util.find_spec("av") is None:
        pytest.skip("PyAV, the extra `video`, is not installed")
    monkeypatch.setattr(mp4, "open_video", lambda path, size, rate: WRITERS[name](path, size, rate or 30.0))
    return name


def frames(path: Path) -> list[tuple[float, NDArray[np.uint8]]]:
    """Every frame of a video with its time, s."""
    video = cv2.VideoCapture(str(path))
    found: list[tuple[float, NDArray[np.uint8]]] = []
    while True:
        done, frame = video.read()
        if not done:
            video.release()
            return found
        found.append((video.get(cv2.CAP_PROP_POS_MSEC) / 1000, frame.astype(np.uint8)))


def red(frame: NDArray[np.uint8]) -> float:
    return float(frame[..., 2].mean())


def test_a_video_shows_at_each_moment_what_was_the_newest_then(writer: str, tmp_path: Path) -> None:
    # Regular, then nothing for a while (attention looked elsewhere), then a burst.
    times = [0.0, 0.1, 0.2, 0.3, 1.3, 1.4, 1.45, 1.5, 1.6]
    export(log_of(times), Wish("mp4", tmp_path / "out"))
    shown = frames(tmp_path / "out" / "camera.mp4")
    for moment in np.arange(0.06, 1.6, 0.1):  # amid the slots
        expected = 10 * max(k for k, at in enumerate(times) if at <= moment + 1e-9)
        at, frame = max((each for each in shown if each[0] <= moment), key=lambda each: each[0])
        tolerance = 4 if writer == "exact" else 14  # of two images in one slot, the later
        assert abs(red(frame) - expected) <= tolerance, (moment, at)
    if writer == "exact":
        assert [at for at, _ in shown] == pytest.approx(times, abs=1e-3)
    else:
        assert len(shown) == 17


def test_a_video_begins_with_the_time_asked_for_whenever_its_first_picture_was_captured(
    writer: str, tmp_path: Path
) -> None:
    # A busy computer: what arrived just after the begin was captured long before it.
    arrived = [(-7.3, -7.5, 0), (0.01, -7.2, 60), (0.02, -3.0, 120), (1.0, 0.99, 180), (1.5, 1.49, 240)]
    log = MemoryLog([Logged(BEGIN + at, "camera", image(BEGIN + stamp, level)) for at, stamp, level in arrived], 10.0)
    result = export(log, Wish("mp4", tmp_path / "out", begin=BEGIN))
    shown = frames(tmp_path / "out" / "camera.mp4")
    assert shown[-1][0] == pytest.approx(1.5, abs=0.06)
    assert "3 images over 1.5 s" in result.lines()[0]
    for moment, level in ((0.0, 120), (0.9, 120), (1.2, 180), (1.5, 240)):
        _, frame = max((each for each in shown if each[0] <= moment + 0.06), key=lambda each: each[0])
        assert abs(red(frame) - level) <= 5, moment
    export(log, Wish("mp4", tmp_path / "early", begin=BEGIN, end=BEGIN + 0.5))
    ((_, frame),) = frames(tmp_path / "early" / "camera.mp4")
    assert abs(red(frame) - 120) <= 5


def test_a_camera_without_a_nominal_rate_has_the_one_it_came_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rates = []

    def open_video(path: Path, size: tuple[int, int], rate_hz: float | None) -> mp4.Video:
        rates.append(rate_hz)
        return mp4.ConstantRateVideo(path, size, rate_hz or 30.0)

    monkeypatch.setattr(mp4, "open_video", open_video)
    export(log_of([0.2 * k for k in range(11)], rate_hz=None), Wish("mp4", tmp_path / "out"))
    assert rates == [pytest.approx(5.5)]


def test_odd_sizes_are_filled_up_not_cropped(writer: str, tmp_path: Path) -> None:
    export(log_of([0.0, 0.1, 0.2], size=(47, 63)), Wish("mp4", tmp_path / "out"))
    assert frames(tmp_path / "out" / "camera.mp4")[0][1].shape == (48, 64, 3)


def test_an_interrupted_video_leaves_nothing(writer: str, tmp_path: Path) -> None:
    def interrupt(done: int, total: int) -> None:
        if done > total / 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export(log_of([0.1 * k for k in range(10)]), Wish("mp4", tmp_path / "out"), interrupt)
    assert list((tmp_path / "out").iterdir()) == []


def test_a_camera_without_an_image_in_that_time_gives_no_video(writer: str, tmp_path: Path) -> None:
    log = log_of([0.0, 5.0])
    result = export(log, Wish("mp4", tmp_path / "out", begin=BEGIN + 1, end=BEGIN + 2))
    assert "nothing was written" in result.lines()[0]
    assert list((tmp_path / "out").iterdir()) == []
