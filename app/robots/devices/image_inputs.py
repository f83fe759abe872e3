"""Image inputs: a camera, a video, images on disk. Blocking; each is used in a thread of its own."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from itertools import repeat
from pathlib import Path
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.image_source import MOST_BYTES, MOST_PIXELS, TooLarge, decoded
from app.base.plain_file import read_plain
from app.robots.devices.config import CameraConfig

Picture = NDArray[np.uint8]
PICTURE_SUFFIXES = {".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp"}
#: Supported files, in words.
PICTURES, VIDEOS = "BMP, JPEG, PNG, TIFF, WebP", "MP4, AVI, MKV, WebM"
DEFAULT_RATE_HZ = 15.0
#: Greatest number of images that a driver buffers.
_KEPT_BY_DRIVERS = 10


class InputUnavailable(Exception):
    """A device or file cannot be opened or has failed; the message names it and a remedy."""


def open_pictures(config: CameraConfig) -> ImageInput:
    """The opened input of ``config.source``. Raises InputUnavailable.

    Its ``read`` gives the next image (H, W, 3) uint8 RGB, None at the end, and raises InputUnavailable. A ``live`` one
    (a camera) has its own rate, and ``skip`` discards what it has buffered; else the reader waits ``1 / rate_hz`` s.
    """
    source = config.source
    if isinstance(source, str):
        path = Path(source)
        if path.is_dir():
            try:
                files = sorted(file for file in path.iterdir() if file.suffix.lower() in PICTURE_SUFFIXES)
            except OSError as failure:
                raise InputUnavailable(f"the folder {source} cannot be read: {failure.strerror}") from None
            if not files:
                raise InputUnavailable(f"there are no pictures ({', '.join(sorted(PICTURE_SUFFIXES))}) in {source}")
            return _Stills(files, config)
        if path.suffix.lower() in PICTURE_SUFFIXES:
            return _Stills([path], config)
        if path.is_file():
            return _Video(path, config)
        if not source.startswith("/dev/"):
            raise InputUnavailable(f"there is no file {source}")
    return _CaptureDevice(source, config)


class _CaptureDevice:
    live = True

    def __init__(self, source: int | str, config: CameraConfig) -> None:
        self._name = f"camera {source}"
        self._capture = _capture(source)
        if self._capture is None:
            raise InputUnavailable(
                f"{self._name} cannot be opened: is it there, free, and may you use it? `hbba doctor` lists cameras; "
                "--camera FILE takes a video or a picture instead"
            )
        self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, config.width)
        self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, config.height)
        if config.rate_hz is not None:
            self._capture.set(cv2.CAP_PROP_FPS, config.rate_hz)
        self.rate_hz = config.rate_hz or _rate(self._capture) or 30.0

    def read(self) -> Picture | None:
        assert self._capture is not None
        there, picture = self._capture.read()
        if not there:
            raise InputUnavailable(f"{self._name} gives no more pictures")
        return _rgb(picture)

    def skip(self) -> None:
        assert self._capture is not None
        for _ in range(_KEPT_BY_DRIVERS):
            began = time.monotonic()
            # An image after a wait is current.
            if not self._capture.grab() or time.monotonic() - began > 0.3 / self.rate_hz:
                return

    def close(self) -> None:
        if self._capture is not None:
            self._capture.release()


class _Video:
    live = False

    def __init__(self, path: Path, config: CameraConfig) -> None:
        self._path = path
        self._loop = config.loop
        capture = _capture(str(path))
        if capture is None:
            raise InputUnavailable(
                f"{path} cannot be read as a video ({VIDEOS}) or a picture ({PICTURES}): it is damaged, breaks off, or "
                "is of another kind"
            )
        self._capture = capture
        width, height = (int(capture.get(side)) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
        if width * height > MOST_PIXELS:
            raise InputUnavailable(
                f"{path} has {width} x {height} pixels; at most {MOST_PIXELS / 1e6:g} million are decoded"
            )
        self.rate_hz = config.rate_hz or _rate(capture) or DEFAULT_RATE_HZ

    def read(self) -> Picture | None:
        there, picture = self._capture.read()
        if not there and self._loop:
            self._capture.release()
            again = _capture(str(self._path))
            if again is None:
                raise InputUnavailable(f"{self._path} cannot be read any more")
            self._capture = again
            there, picture = again.read()
        return _rgb(picture) if there else None

    def skip(self) -> None: ...

    def close(self) -> None:
        self._capture.release()


class _Stills:
    live = False

    def __init__(self, files: list[Path], config: CameraConfig) -> None:
        self.rate_hz = config.rate_hz or DEFAULT_RATE_HZ
        times = max(1, round(config.seconds_each * self.rate_hz))
        self._pictures = self._each(files, config.loop, times)
        # A broken image in a folder is reported at once, not later.
        self._kept = {file: _picture(file) for file in files[:1]}

    def _each(self, files: list[Path], loop: bool, times: int) -> Iterator[Picture]:
        while True:
            for file in files:
                if file not in self._kept:
                    if len(self._kept) > 1:
                        self._kept.pop(next(iter(self._kept)))
                    self._kept[file] = _picture(file)
                yield from repeat(self._kept[file], times)
            if not loop:
                return

    def read(self) -> Picture | None:
        picture = next(self._pictures, None)
        # An image file gives the same array every time: read-only, since subscribers share it.
        return None if picture is None else picture.copy()

    def skip(self) -> None: ...

    def close(self) -> None:
        self._kept.clear()


ImageInput: TypeAlias = _CaptureDevice | _Video | _Stills


class PlaybackTimer:
    """Times playback at ``rate_hz`` per second, without catching up after a stall."""

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._due = time.monotonic()

    def wait_s(self, now: float) -> float:
        """Seconds (>= 0) from ``now`` (monotonic) to the next item; the one after it is due a period later."""
        self._due = max(self._due + self._period_s, now)
        return self._due - now


def _capture(source: int | str) -> cv2.VideoCapture | None:
    # FFmpeg's messages are suppressed: ours follow.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    capture = cv2.VideoCapture(source)
    if not capture.isOpened():
        capture.release()
        return None
    return capture


def _rate(capture: cv2.VideoCapture) -> float | None:
    """The input's own rate (Hz), if it is plausible."""
    rate_hz = float(capture.get(cv2.CAP_PROP_FPS))
    return rate_hz if 0.1 <= rate_hz <= 240 else None


def _picture(file: Path) -> Picture:
    try:
        picture = decoded(read_plain(file, MOST_BYTES), cv2.IMREAD_COLOR)
    except OSError as failure:
        raise InputUnavailable(f"{file} cannot be read: {failure.strerror}") from None
    except TooLarge as failure:
        raise InputUnavailable(f"{file} {failure}") from None
    if picture is None:
        raise InputUnavailable(f"{file} is no picture that can be read ({PICTURES})")
    return _rgb(picture)


def _rgb(picture: NDArray[np.generic]) -> Picture:
    return np.asarray(cv2.cvtColor(np.asarray(picture), cv2.COLOR_BGR2RGB), np.uint8)
