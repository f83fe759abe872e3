"""JPEGs as VP9 for one page: each picture is coded as it comes, none is held back. For a worker thread.

PyAV (the extra ``video``) does it, by FFmpeg and libvpx (BSD). Without it no video is made.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, cast

from app.console.live.picture_budget import Form

if TYPE_CHECKING:
    from av import VideoCodecContext, VideoFrame

_CODEC = "libvpx-vp9"
#: Bits of a picture are what counts, not bits of a second: the encoder is given pictures that come so often.
_RATE_HZ = 15
_NO_OTHER_KEYS = 1_000_000
#: Realtime, its quickest; constant bit rate; blocks that have rested long are refined in turn (cyclic refresh).
_OPTIONS = {"deadline": "realtime", "cpu-used": "8", "lag-in-frames": "0", "aq-mode": "3"}


def can_encode() -> bool:
    """Whether PyAV is installed. It is not loaded by that: this takes 0.2 s, and is left to the first picture."""
    return importlib.util.find_spec("av") is not None


class NoEncoder(Exception):
    """Why no VP9 can be made here, in a sentence for people."""


@dataclass(frozen=True, slots=True)
class VideoPicture:
    """One picture: ``data`` is a VP9 frame of ``width`` x ``height`` px (even), ``key`` if it needs none before it."""

    data: bytes
    width: int
    height: int
    key: bool


class VideoEncoder:
    """Made, called and dropped by one thread at a time."""

    def __init__(self) -> None:
        """Raises NoEncoder."""
        try:
            import av
            from av.video.reformatter import VideoReformatter
        except ImportError as error:
            raise NoEncoder(f"PyAV cannot be loaded: {error}") from error
        if _CODEC not in av.codecs_available:
            raise NoEncoder(f"this PyAV has no {_CODEC}")
        self._av = av
        self._jpeg = av.VideoCodecContext.create("mjpeg", "r")
        self._jpeg.thread_count = 1
        self._reformatter = VideoReformatter()
        self._video: VideoCodecContext | None = None
        #: What ``_video`` was made for: width and height (px), bits a second.
        self._made_for = (0, 0, 0)
        self._count = 0

    def encode(self, jpeg: bytes, form: Form, *, afresh: bool = False) -> VideoPicture | None:
        """``jpeg`` as the next picture, in ``form``, never larger than it is; None: it is damaged.

        It needs none before it if it is the first, of another size or rate, or to begin ``afresh``.
        """
        source = self._decoded(jpeg)
        if source is None:
            return None
        width = min(form.width or source.width, source.width)
        height = source.height * width / source.width
        # Chroma has half the pixels each way.
        width, height = (max(2, 2 * round(side / 2)) for side in (width, height))
        rate = round((form.bits or 0.0) * width * height * _RATE_HZ)
        if self._video is None or self._made_for != (width, height, rate):
            self._video, self._made_for = self._opened(width, height, rate), (width, height, rate)
        types = self._av.video
        frame = self._reformatter.reformat(
            source,
            width=width,
            height=height,
            format="yuv420p",
            src_colorspace=types.reformatter.Colorspace.ITU601,
            dst_colorspace=types.reformatter.Colorspace.ITU601,
            src_color_range=types.reformatter.ColorRange.JPEG,
            dst_color_range=types.reformatter.ColorRange.MPEG,
            interpolation=types.reformatter.Interpolation.AREA,
        )
        frame.pts, frame.time_base = self._count, Fraction(1, _RATE_HZ)
        frame.pict_type = types.frame.PictureType.I if afresh else types.frame.PictureType.NONE
        self._count += 1
        packets = self._video.encode(frame)
        if len(packets) != 1:
            raise NoEncoder(f"this {_CODEC} gave {len(packets)} frames for a picture, not 1")
        return VideoPicture(bytes(packets[0]), width, height, packets[0].is_keyframe)

    def _decoded(self, jpeg: bytes) -> VideoFrame | None:
        try:
            frames = self._jpeg.decode(self._av.Packet(jpeg))
        except self._av.error.InvalidDataError:
            return None
        return frames[0] if frames else None

    def _opened(self, width: int, height: int, rate: int) -> VideoCodecContext:
        video = cast("VideoCodecContext", self._av.VideoCodecContext.create(_CODEC, "w"))
        video.width, video.height, video.pix_fmt = width, height, "yuv420p"
        video.framerate, video.time_base = Fraction(_RATE_HZ), Fraction(1, _RATE_HZ)
        # Written into the stream (BT.601, 16 to 235): a player that had to guess would show other colours.
        video.colorspace, video.color_range = 6, 1
        video.bit_rate, video.gop_size, video.thread_count = rate, _NO_OTHER_KEYS, 1
        video.options = {**_OPTIONS, "minrate": f"{rate}", "maxrate": f"{rate}", "bufsize": f"{rate // 2}"}
        return video
