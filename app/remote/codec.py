"""Messages as bytes for another computer, and back: CDR made from the dataclasses, images as JPEG with depth.

What comes from elsewhere is decoded by the type of the port that it is for, never by a name in the data.
"""

from __future__ import annotations

import typing
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import zstandard
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.base.image_source import TooLarge, decoded
from app.logs.ros.generated import UnrecordableType, generated
from app.messages import Image, read_only
from app.messages.base import field_names, is_record

#: No image of more pixels is taken from another computer.
MOST_PIXELS = 16_000_000
_LEVEL = 1


class BadPayload(ValueError):
    """Bytes that are no message of the type that was to come."""


@dataclass(frozen=True, slots=True)
class ImageOnLink:
    """An Image as it travels: colours as JPEG, or raw; depth as zstd of its rows, empty without depth."""

    stamp_s: float
    frame: str
    pinhole: CameraModel | None
    fisheye: FisheyeModel | None
    X_BC: Pose3
    height: int
    width: int
    jpeg: bool
    color: bytes
    depth: bytes


@dataclass(frozen=True, slots=True)
class Codec:
    """Encodes and decodes messages of ``message_type``. ``quality`` of JPEG, 1 to 100; None: raw colours."""

    message_type: type[Any]
    quality: int | None = 85

    @property
    def heavy(self) -> bool:
        """Whether it takes milliseconds, so that it belongs in a thread."""
        return self.message_type is Image

    def encode(self, message: Any) -> bytes:
        """``message`` as bytes; its stamp comes back exactly. Raises cv2.error for what JPEG cannot hold."""
        if self.heavy:
            message, kind = _packed(message, self.quality), ImageOnLink
        else:
            kind = self.message_type
        head = b"" if self.heavy else np.float64(message.stamp).tobytes()
        return head + generated(kind).encode(message)

    def decode(self, data: bytes) -> Any:
        """The message in ``data``. Raises BadPayload."""
        try:
            if self.heavy:
                return _unpacked(generated(ImageOnLink).decode(data))
            if len(data) < 8:
                raise BadPayload(f"{len(data)} bytes are no {self.message_type.__name__}")
            message = generated(self.message_type).decode(data[8:])
        except (ValueError, KeyError, IndexError, TypeError, OverflowError) as failure:
            raise BadPayload(f"no {self.message_type.__name__}: {failure}") from failure
        # ROS has nanoseconds, a float of today has a quarter of a microsecond, but not the same one.
        return replace(message, stamp=float(np.frombuffer(data[:8], np.float64)[0]))


def shape_of(message_type: type[Any]) -> dict[str, str]:
    """Fields of ``message_type`` and of the records in it, ``Class.field`` each with its type: equal at two computers
    that understand each other."""
    fields: dict[str, str] = {}
    _note_fields(message_type, fields)
    return fields


def travels(message_type: type[Any]) -> str:
    """ "" if messages of this type can go over the network, else why not."""
    try:
        generated(ImageOnLink if message_type is Image else message_type)
    except UnrecordableType as failure:
        return str(failure)
    return ""


def difference(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """The first difference between two shapes in words, "" where there is none."""
    for name, kind in here.items():
        if name not in there:
            return f"there is no {name} there"
        if there[name] != kind:
            return f"{name} is {kind} here and {there[name]} there"
    more = next((name for name in there if name not in here), None)
    return "" if more is None else f"there is no {more} here"


def _note_fields(cls: type[Any], fields: dict[str, str]) -> None:
    hints = typing.get_type_hints(cls)
    for name in field_names(cls):
        key = f"{cls.__name__}.{name}"
        if key in fields:
            continue
        fields[key] = _words(hints[name])
        for nested in _records(hints[name]):
            _note_fields(nested, fields)


def _records(hint: Any) -> list[type[Any]]:
    found = [hint] if is_record(hint) else []
    for argument in typing.get_args(hint):
        found += _records(argument)
    return found


def _words(hint: Any) -> str:
    return hint.__name__ if isinstance(hint, type) and not typing.get_args(hint) else str(hint)


def _packed(image: Image, quality: int | None) -> ImageOnLink:
    height, width = image.color.shape[:2]
    if quality is None:
        color = np.ascontiguousarray(image.color).tobytes()
    else:
        bgr = cv2.cvtColor(image.color, cv2.COLOR_RGB2BGR)
        color = cv2.imencode(".jpg", bgr, (cv2.IMWRITE_JPEG_QUALITY, quality))[1].tobytes()
    depth = b""
    if image.depth is not None:
        depth = zstandard.ZstdCompressor(level=_LEVEL).compress(np.ascontiguousarray(image.depth, "<u2").tobytes())
    fisheye = image.camera if isinstance(image.camera, FisheyeModel) else None
    pinhole = image.camera if isinstance(image.camera, CameraModel) else None
    return ImageOnLink(
        image.stamp, image.frame, pinhole, fisheye, image.X_BC,
        height=height, width=width, jpeg=quality is not None, color=color, depth=depth,
    )  # fmt: skip


def _unpacked(packed: ImageOnLink) -> Image:
    height, width = packed.height, packed.width
    camera = packed.pinhole or packed.fisheye
    if camera is None or height < 1 or width < 1 or height * width > MOST_PIXELS:
        raise BadPayload(f"no image: {width} x {height} pixels, through {camera}")
    color: NDArray[Any] | None
    if packed.jpeg:
        try:
            color = decoded(packed.color, cv2.IMREAD_COLOR_RGB, MOST_PIXELS)
        except TooLarge as failure:
            raise BadPayload(f"an image that {failure}") from failure
    else:
        color = np.frombuffer(packed.color, np.uint8)
        color = color.reshape(height, width, 3) if color.size == 3 * height * width else None
    if color is None or color.shape != (height, width, 3):
        raise BadPayload(f"the colours are not those of {width} x {height} pixels")
    depth = None if not packed.depth else _depth(packed.depth, height, width)
    pixels = read_only(color.astype(np.uint8, copy=False))
    return Image(packed.stamp_s, packed.frame, color=pixels, depth=depth, camera=camera, X_BC=packed.X_BC)


def _depth(data: bytes, height: int, width: int) -> NDArray[np.uint16]:
    try:
        # No more than the pixels take, whatever the data declares.
        raw = zstandard.ZstdDecompressor().stream_reader(data).read(2 * height * width + 1)
    except zstandard.ZstdError as failure:
        raise BadPayload(f"the depth is damaged: {failure}") from failure
    if len(raw) != 2 * height * width:
        raise BadPayload(f"the depth is not that of {width} x {height} pixels")
    return read_only(np.frombuffer(raw, "<u2").astype(np.uint16, copy=False).reshape(height, width))
