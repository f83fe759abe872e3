"""What crosses the live stream, as in docs/live-stream.md: messages from the page, pictures to it, sound both ways."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Annotated, Final, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from app.console.drive.command_age import Times
from app.messages import Audio, EncodedImage, read_only

PROTOCOL: Final = 1
#: Kinds of binary frames.
CAMERA = 1
PANORAMA = 2
MAP = 3
COSTMAP = 4
SOUND = 16
VOICE = 17

VOICE_RATES = (48_000, 16_000)
LONGEST_VOICE_S = 0.04

#: How a picture is coded: as a file (JPEG, of maps PNG), as VP9 that begins afresh, as VP9 that needs those before it.
FILE = 0
VP9_KEY = 1
VP9_DELTA = 2

PICTURE_HEADER = struct.Struct("<BB2xIdHH4x")
PICTURE_FIELDS = ("kind", "coding", "seq", "stamp", "width", "height")
SOUND_HEADER = struct.Struct("<B3xIdHHI")
SOUND_FIELDS = ("kind", "seq", "stamp", "samples", "channels", "rate")


class TimedMessage(msgspec.Struct):
    """A message that says when it was sent.

    ``t``: by the page's clock (ms). ``heard``: the stamp of the newest ``hello``, ``status`` or ``pong`` that the page
    had received (s), ``heard_t``: when that came, by the page's clock (ms). None: it does not say.
    """

    t: float | None = None
    heard: float | None = None
    heard_t: float | None = None


class DriveMessage(TimedMessage, tag="drive", kw_only=True):
    """A drive command of the operator: of the base while ``held``, of the head while ``head_held``.

    Shares of the body's limits: forward, turn left, sideways to the left; the head left and up.
    """

    seq: int
    held: bool
    linear: float
    angular: float
    override: bool = False
    lateral: float = 0.0
    head_held: bool = False
    pan: float = 0.0
    tilt: float = 0.0


class LookMessage(TimedMessage, tag="look", kw_only=True):
    """Turn the head to a place in the camera's picture.

    ``stamp`` is the picture's (s); ``u`` and ``v`` are shares of its width and height, from its upper left.
    """

    stamp: float
    u: float
    v: float


class EStopMessage(msgspec.Struct, tag="e_stop"):
    """Latch the emergency stop."""


class ClearEStopMessage(TimedMessage, tag="clear_e_stop"):
    """Release the emergency stop."""


class TakeControlMessage(TimedMessage, tag="take_control"):
    """Take the wheel at once."""


class ReleaseControlMessage(msgspec.Struct, tag="release_control"):
    """Give the wheel back."""


class AskControlMessage(TimedMessage, tag="ask_control"):
    """Ask for the wheel."""


class AnswerControlMessage(msgspec.Struct, tag="answer_control"):
    """Give the wheel to who asks for it, or keep it."""

    give: bool


class PingMessage(TimedMessage, tag="ping"):
    """Ping; the pong returns ``t`` unchanged."""

    rtt_ms: float | None = None


class AckMessage(msgspec.Struct, tag="ack"):
    """The picture ``seq`` of its kind was drawn."""

    kind: Literal[1, 2, 3, 4]
    seq: int


class ViewMessage(msgspec.Struct, tag="view"):
    """Which pictures the page shows; None: unchanged. ``camera_px``: so many pixels wide it shows the camera's.

    ``vp9``: whether it decodes them as VP9, too.
    """

    camera: bool | None = None
    panorama: bool | None = None
    map: bool | None = None
    costmap: bool | None = None
    camera_px: Annotated[int, msgspec.Meta(ge=1, le=16_384)] | None = None
    vp9: bool | None = None


class ListenMessage(msgspec.Struct, tag="listen"):
    """Subscribe to the microphones' sound, or end that."""

    on: bool


FromPage = (
    DriveMessage
    | LookMessage
    | EStopMessage
    | ClearEStopMessage
    | TakeControlMessage
    | ReleaseControlMessage
    | PingMessage
    | AckMessage
    | ViewMessage
    | ListenMessage
    | AskControlMessage
    | AnswerControlMessage
)

_decoder: msgspec.json.Decoder[FromPage] = msgspec.json.Decoder(FromPage)


def decode(text: str | bytes) -> FromPage:
    """A message from the page. Raises msgspec.DecodeError (malformed) or its ValidationError (not of the protocol)."""
    return _decoder.decode(text)


def times(message: TimedMessage) -> Times | None:
    """What ``message`` says of its time; None: not enough."""
    if message.t is None or message.heard is None or message.heard_t is None:
        return None
    return Times(1e-3 * message.t, message.heard, 1e-3 * message.heard_t)


def picture_frame(kind: int, image: EncodedImage, sequence: int) -> bytes:
    """A picture with its 24-byte header."""
    return picture_header(kind, sequence, image.stamp, (image.width, image.height)) + image.jpeg


def picture_header(kind: int, sequence: int, stamp: float, size: tuple[int, int], *, coding: int = FILE) -> bytes:
    """The 24 bytes before every picture; ``size``: width and height in pixels, at most 65,535."""
    return PICTURE_HEADER.pack(kind, coding, sequence & 0xFFFFFFFF, stamp, *size)


def sound_frame(audio: Audio, sequence: int) -> bytes:
    """A frame of one channel of sound with its 24-byte header."""
    samples = audio.samples[:, 0]
    header = SOUND_HEADER.pack(SOUND, sequence & 0xFFFFFFFF, audio.stamp, len(samples), 1, audio.rate)
    return header + samples.astype("<i2").tobytes()


@dataclass(frozen=True, slots=True, eq=False)
class Voice:
    """A frame of an operator's voice: ``samples`` (N,) int16, none to end the talk; ``stamp`` 0 where not known."""

    seq: int
    stamp: float
    samples: NDArray[np.int16]
    rate: int


def decode_voice(frame: bytes) -> Voice:
    """A frame of kind 17. Raises ValueError, in words for people, for one that cannot be."""
    if len(frame) < SOUND_HEADER.size:
        raise ValueError(f"a frame of speech has a header of {SOUND_HEADER.size} bytes, not {len(frame)} in all")
    _, seq, stamp, count, channels, rate = SOUND_HEADER.unpack_from(frame)
    if channels != 1:
        raise ValueError(f"speech has 1 channel, not {channels}")
    if rate not in VOICE_RATES:
        raise ValueError(f"speech has {' or '.join(map(str, VOICE_RATES))} samples a second, not {rate}")
    if count > rate * LONGEST_VOICE_S:
        raise ValueError(f"a frame of speech has at most {1e3 * LONGEST_VOICE_S:.0f} ms, not {1e3 * count / rate:.0f}")
    if len(frame) != SOUND_HEADER.size + 2 * count:
        raise ValueError(f"{count} samples take {2 * count} bytes, not {len(frame) - SOUND_HEADER.size}")
    if not math.isfinite(stamp) or stamp < 0:
        raise ValueError(f"a stamp is a time in seconds, not {stamp}")
    samples = np.frombuffer(frame, "<i2", offset=SOUND_HEADER.size).astype(np.int16)
    return Voice(seq, stamp, read_only(samples), rate)
