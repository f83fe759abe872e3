"""What crosses the live stream, as in docs/live-stream.md: messages from the page, and pictures to it."""

from __future__ import annotations

import struct
from typing import Literal

import msgspec

from app.messages import EncodedImage

PROTOCOL = 1
CAMERA = 1

_PICTURE_HEADER = struct.Struct("<B3xIdHH4x")


class DriveMessage(msgspec.Struct, tag="drive"):
    """The operator's hands."""

    seq: int
    held: bool
    linear: float
    angular: float


class EStopMessage(msgspec.Struct, tag="e_stop"):
    """Latch the emergency stop."""


class ClearEStopMessage(msgspec.Struct, tag="clear_e_stop"):
    """Release it."""


class TakeControlMessage(msgspec.Struct, tag="take_control"):
    """Ask for the wheel."""


class ReleaseControlMessage(msgspec.Struct, tag="release_control"):
    """Give it back."""


class PingMessage(msgspec.Struct, tag="ping"):
    """A sign of life; ``t`` comes back as it is."""

    t: float
    rtt_ms: float | None = None


class AckMessage(msgspec.Struct, tag="ack"):
    """The picture ``seq`` was drawn."""

    kind: Literal[1]
    seq: int


class ViewMessage(msgspec.Struct, tag="view"):
    """Whether the page shows the camera."""

    camera: bool


FromPage = (
    DriveMessage
    | EStopMessage
    | ClearEStopMessage
    | TakeControlMessage
    | ReleaseControlMessage
    | PingMessage
    | AckMessage
    | ViewMessage
)

_decoder: msgspec.json.Decoder[FromPage] = msgspec.json.Decoder(FromPage)


def decode(text: str | bytes) -> FromPage:
    """A message from the page. Raises msgspec.DecodeError (malformed) or its ValidationError (not of the protocol)."""
    return _decoder.decode(text)


def picture_frame(image: EncodedImage, sequence: int) -> bytes:
    """A camera picture with its 24-byte header."""
    header = _PICTURE_HEADER.pack(CAMERA, sequence & 0xFFFFFFFF, image.stamp, image.width, image.height)
    return header + image.jpeg
