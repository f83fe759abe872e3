"""Images as a video that a browser plays, each shown for as long as it really was the newest.

With PyAV (the extra ``video``): H.264, each frame at its own time. Without: what OpenCV's wheels can write that
browsers play, which is VP9 at a constant rate (they have no H.264 encoder; MPEG-4 part 2, which they have, no browser
plays). A frame is then repeated, or left out, to keep the time; it takes some seventy times as long.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from app.log_tools.export.png import rgb_of
from app.log_tools.export.target import Format, Target, Write
from app.logs.log import LogError, LoggedChannel
from app.logs.output_file import DiskTrouble, disk_trouble
from app.messages import EncodedImage, Image

if TYPE_CHECKING:
    from av import VideoStream

SLOWEST_HZ, FASTEST_HZ = 1.0, 60.0
#: Usual upper limit (s) of an image's delay from capture to arrival.
LATE_S = 0.5
#: Ticks a second of a video's own clock, the usual one.
CLOCK_HZ = 90_000


class Mp4(Format):
    """``<channel>.mp4``; it begins with the first image, and is within the requested time.

    An image may arrive long after it was captured, from a busy computer: one captured more than ``LATE_S`` before that
    time is shown from its begin on, until the next.
    """

    def accepts(self, message_type: type[Any]) -> bool:
        return message_type in (Image, EncodedImage)

    @contextmanager
    def writer(self, channel: LoggedChannel, target: Target) -> Iterator[Write]:
        name = f"{channel.name}.mp4"
        target.check(name)
        video: Video | None = None
        size = (0, 0)
        first, last, count = 0.0, 0.0, 0
        earlier: NDArray[np.uint8] | None = None

        def add(image: NDArray[np.uint8], at: float) -> None:
            nonlocal video, size, first, last, count
            if video is None:
                size, first = (image.shape[1], image.shape[0]), at
                video = open_video(part, size, channel.rate_hz)
            if image.shape[1::-1] != size:
                image = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
            video.add(image, at - first)
            last, count = at, count + 1

        def add_earlier() -> None:
            nonlocal earlier
            if earlier is not None and video is None:
                add(earlier, target.begin)
            earlier = None

        def write(message: Any) -> None:
            nonlocal earlier
            image = even_sided(rgb_of(message))
            if message.stamp < target.begin - LATE_S:
                earlier = image
            else:
                add_earlier()
                add(image, min(message.stamp, target.end))

        with target.file(name) as part:
            try:
                yield write
                add_earlier()
            except BaseException:
                if video is not None:
                    with suppress(LogError):  # what came first is what matters
                        video.close()
                raise
            if video is None:
                return
            what = video.close()
        target.written.append(f"{target.folder / name}: {count} images over {last - first:.1f} s, {what}")


def open_video(path: Path, size: tuple[int, int], rate_hz: float | None) -> Video:
    """A video of ``size`` (width, height; even, px) whose images come at about ``rate_hz`` (None: not known)."""
    rate = min(max(rate_hz or 30.0, SLOWEST_HZ), FASTEST_HZ)
    try:
        import av  # noqa: F401
    except ImportError:
        return ConstantRateVideo(path, size, rate)
    return ExactVideo(path, size, rate)


class ExactVideo:
    """H.264 through PyAV: every image at its own time."""

    def __init__(self, path: Path, size: tuple[int, int], rate_hz: float) -> None:
        import av

        self._path = path
        self._frame = av.VideoFrame
        self._failure = av.error.FFmpegError
        self._file = av.open(str(path), "w", format="mp4", options={"movflags": "faststart"})
        codec = "libx264" if "libx264" in av.codecs_available else "libvpx-vp9"
        options = {"preset": "veryfast", "crf": "21"} if codec == "libx264" else {"deadline": "realtime", "crf": "31"}
        self._stream = cast("VideoStream", self._file.add_stream(codec, rate=round(rate_hz) or 1, options=options))
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = Fraction(1, CLOCK_HZ)
        self._what = "H.264" if codec == "libx264" else "VP9"
        self._last = -1

    def add(self, image: NDArray[np.uint8], at: float) -> None:
        """Show ``image`` (H, W, 3) RGB from ``at`` seconds after the first; a frame not later than the last is left
        out."""
        tick = round(at * CLOCK_HZ)
        if tick <= self._last:
            return
        frame = self._frame.from_ndarray(np.ascontiguousarray(image), format="rgb24")
        frame.pts, frame.time_base = tick, Fraction(1, CLOCK_HZ)
        self._last = tick
        try:
            self._file.mux(self._stream.encode(frame))
        except self._failure as failure:
            raise disk_trouble(OSError(failure.errno, failure.strerror), self._path) from failure

    def close(self) -> str:
        """End the file; returns a summary for people. Raises DiskTrouble if it could not be written."""
        try:
            self._file.mux(self._stream.encode(None))
            self._file.close()
        except self._failure as failure:
            raise disk_trouble(OSError(failure.errno, failure.strerror), self._path) from failure
        return self._what


class ConstantRateVideo:
    """VP9 through OpenCV: an image is repeated until the next one's slot comes."""

    def __init__(self, path: Path, size: tuple[int, int], rate_hz: float) -> None:
        self._path = path
        self._rate = rate_hz
        code = cv2.VideoWriter.fourcc(*"vp09")
        self._writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, rate_hz, size)
        if not self._writer.isOpened():
            raise LogError(f"this OpenCV cannot write video; install hbba[video] for {path.suffix} export")
        self._shown: NDArray[np.uint8] | None = None
        self._slot = 0
        self._frames = 0

    def add(self, image: NDArray[np.uint8], at: float) -> None:
        """Show ``image`` from the slot nearest to ``at``; of two in one slot the later is shown."""
        slot = max(round(at * self._rate), self._slot)
        self._fill(slot)
        self._shown = np.ascontiguousarray(image[..., ::-1])

    def close(self) -> str:
        """End the file. Raises DiskTrouble where frames are missing: OpenCV does not say that a disk is full."""
        self._fill(self._slot + 1)
        self._writer.release()
        check = cv2.VideoCapture(str(self._path), cv2.CAP_FFMPEG)
        found = int(check.get(cv2.CAP_PROP_FRAME_COUNT)) if check.isOpened() else 0
        check.release()
        if found != self._frames:
            raise DiskTrouble(f"{self._path}: {found} of {self._frames} frames were written; is the disk full?")
        return f"VP9 at {self._rate:g} frames a second; the extra hbba[video] makes H.264, and much faster"

    def _fill(self, until: int) -> None:
        if self._shown is not None:
            for _ in range(until - self._slot):
                self._writer.write(self._shown)
                self._frames += 1
            self._slot = until


Video: TypeAlias = ExactVideo | ConstantRateVideo


def even_sided(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """``image`` with its last row or column repeated where their number is odd: colour is kept for blocks of 2 x 2."""
    height, width = image.shape[:2]
    if height % 2 or width % 2:
        return np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    return image
