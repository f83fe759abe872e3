"""The videos that people name on the command line: frame by frame, each with its own time."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.base.plain_file import check_plain, open_plain
from app.commands.arguments import real, whole

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from app.commands.progress import Progress
    from app.log_tools.export.mp4 import Video

#: Endings under which videos are looked for in folders; a file that is named is known by how it begins, too.
VIDEO_SUFFIXES = frozenset({".mp4", ".m4v", ".mov", ".webm", ".mkv", ".avi"})
VIDEOS = "MP4, MOV, WebM, MKV, AVI"

_BEGINNING = re.compile(rb"....ftyp|\x1a\x45\xdf\xa3|RIFF....AVI ", re.DOTALL)
#: A video is complete if at most this much (s), and at most this share of its frames, is missing.
_MISSING_S, _MISSING_FRAMES = 0.25, 3.0
_SLOWEST_HZ, _FASTEST_HZ, _USUAL_HZ = 0.1, 1000.0, 30.0
_RATE = f"must be a number of frames a second up to {_FASTEST_HZ:g}"


class NoVideo(Exception):
    """A file that cannot be read as a video, or not to its end; the message says why."""


def add_pace(parser: argparse.ArgumentParser) -> None:
    """Declare how many frames of a video are looked at."""
    pace = parser.add_mutually_exclusive_group()
    pace.add_argument("--every", type=whole(1), metavar="N", help="of a video, look at every Nth frame (default: all)")
    pace.add_argument(
        "--fps",
        type=real(0, _FASTEST_HZ, above=True, rule=_RATE),
        metavar="F",
        help="of a video, look at most at F frames a second",
    )


def is_video(path: Path) -> bool:
    """Whether the file is read as a video: by its ending, or by how it begins."""
    if path.suffix.lower() in VIDEO_SUFFIXES:
        return True
    try:
        with open_plain(path) as file:
            return _BEGINNING.match(file.read(12)) is not None
    except OSError:
        return False  # reading it as an image says why


class VideoFile:
    """A video's frames in turn; ``width`` and ``height`` in px. Raises NoVideo where there is none."""

    def __init__(self, path: Path) -> None:
        import cv2

        from app.base.image_source import MOST_PIXELS

        # FFmpeg's own words about a file say nothing to people.
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        try:
            check_plain(path)
            if not path.stat().st_size:
                raise NoVideo("is empty")
        except OSError as failure:
            raise NoVideo(f"cannot be read: {failure.strerror or failure}") from None
        self._capture = cv2.VideoCapture(str(path))
        if not self._capture.isOpened():
            raise NoVideo(
                f"cannot be read as a video ({VIDEOS}): it is damaged, its end is missing, or it is of another kind"
            )
        self.width, self.height = self._figure(cv2.CAP_PROP_FRAME_WIDTH), self._figure(cv2.CAP_PROP_FRAME_HEIGHT)
        if self.width * self.height > MOST_PIXELS:
            self._capture.release()
            raise NoVideo(f"has frames of {self.width} x {self.height} pixels; at most {MOST_PIXELS:,} are looked at")
        rate_hz = float(self._capture.get(cv2.CAP_PROP_FPS))
        self.rate_hz = rate_hz if _SLOWEST_HZ <= rate_hz <= _FASTEST_HZ else _USUAL_HZ
        #: Declared duration (s); 0 without one.
        self.declared_s = self._figure(cv2.CAP_PROP_FRAME_COUNT) / self.rate_hz
        #: The end of the last frame that was read (s).
        self.end_s = 0.0

    def _figure(self, what: int) -> int:
        value = float(self._capture.get(what))
        return int(value) if math.isfinite(value) and 0 < value < 1e9 else 0

    def frames(
        self, every: int | None, fps: float | None, progress: Progress
    ) -> Iterator[tuple[float, NDArray[np.uint8]]]:
        """Time (s from the beginning) and picture (H, W, 3) uint8 RGB of all frames, every ``every``-th of them, or at
        most ``fps`` a second. Raises NoVideo at its end if that comes sooner than the file says."""
        import cv2
        import numpy as np

        count, due = 0, 0.0
        last_s = -1.0 / self.rate_hz
        while self._capture.grab():
            time_s = self._time(count, last_s)
            wanted = count % (every or 1) == 0 if fps is None else time_s >= due - 1e-6
            if wanted:
                if fps is not None:
                    # In step with the beginning; after a pause, no frames are caught up with.
                    due = (math.floor(time_s * fps + 1e-6) + 1) / fps
                there, picture = self._capture.retrieve()
                if not there:
                    break
                yield time_s, np.asarray(cv2.cvtColor(np.asarray(picture), cv2.COLOR_BGR2RGB), np.uint8)
            count += 1
            last_s = time_s
            self.end_s = time_s + 1 / self.rate_hz
            progress(min(self.end_s, self.declared_s), max(self.declared_s, self.end_s))
        if not count:
            raise NoVideo("holds no frame that can be read")
        if self.end_s < self.declared_s - max(_MISSING_S, _MISSING_FRAMES / self.rate_hz):
            raise NoVideo(f"breaks off at {self.end_s:.1f} s of {self.declared_s:.1f} s")

    def _time(self, count: int, last_s: float) -> float:
        """Of the frame grabbed last; what says no time, or goes back, comes at the usual rate."""
        import cv2

        time_s = float(self._capture.get(cv2.CAP_PROP_POS_MSEC)) / 1e3
        if math.isfinite(time_s) and time_s > last_s and (time_s > 0 or count == 0):
            return time_s
        return last_s + 1 / self.rate_hz

    def close(self) -> None:
        self._capture.release()


class Copy:
    """A copy of a video with its detections drawn on it: ``file``, an MP4 that browsers play."""

    def __init__(self, file: Path, rate_hz: float) -> None:
        self._file, self._rate_hz = file, rate_hz
        self._video: Video | None = None
        self._size = (0, 0)

    def add(self, picture: NDArray[np.uint8], time_s: float) -> None:
        """Show ``picture`` (H, W, 3) RGB from ``time_s`` on. Raises ConfigError."""
        with _Written(self._file):
            import cv2
            import numpy as np

            from app.log_tools.export.mp4 import even_sided, open_video

            picture = even_sided(picture)
            if self._video is None:
                self._size, self._first = (picture.shape[1], picture.shape[0]), time_s
                self._video = open_video(self._file, self._size, self._rate_hz)
            if picture.shape[1::-1] != self._size:
                picture = np.asarray(cv2.resize(picture, self._size, interpolation=cv2.INTER_AREA), np.uint8)
            self._video.add(picture, time_s - self._first)

    def close(self) -> None:
        if self._video is not None:
            with _Written(self._file):
                self._video.close()


class _Written:
    """Report a failure to write ``file`` as a mistake in the value of ``--draw``."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def __enter__(self) -> None: ...

    def __exit__(self, kind: type[BaseException] | None, failure: BaseException | None, trace: Any) -> None:
        from app.logs.log import LogError

        if isinstance(failure, OSError):
            reason = failure.strerror or str(failure)
            raise ConfigError(f"--draw: {self._file} cannot be written: {reason}") from None
        if isinstance(failure, LogError):
            raise ConfigError(f"--draw: {failure}") from None
