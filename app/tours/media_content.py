"""What a file that was handed in is, by its content: a whole picture or video of a kind that browsers show.

Pictures are decoded wholly. Of videos the container is read (ISO/IEC 14496-12, RFC 8794), not the pictures in it:
whether a phone has the decoder cannot be known here.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from app.base.plain_file import open_plain
from app.tours.steps import PICTURES, VIDEOS

#: What a browser is given files as, by their ending: never as a page, a script or what it may guess.
TYPES = {
    "jpg": "image/jpeg",
    "jpeg": "image/jpeg",
    "png": "image/png",
    "webp": "image/webp",
    "gif": "image/gif",
    "mp4": "video/mp4",
    "webm": "video/webm",
}
#: More bytes are not kept, nor given to visitors' phones.
LARGEST_PICTURE_BYTES, LARGEST_VIDEO_BYTES = 20 * 1024**2, 500 * 1024**2
#: A picture of more pixels would take a phone's memory.
MOST_PIXELS = 50_000_000
#: So many bytes say what a file is.
HEAD_BYTES = 4096

_FORMATS = {"JPEG": "jpg", "PNG": "png", "WEBP": "webp", "GIF": "gif"}
_EBML, _DOC_TYPE, _SEGMENT = b"\x1a\x45\xdf\xa3", b"\x42\x82", b"\x18\x53\x80\x67"
_NOT_SHOWN = {
    b"qt  ": "a QuickTime film, which few browsers play; save it as MP4",
    b"heic": "an HEIC picture, which few browsers show; save it as JPEG",
    b"heix": "an HEIC picture, which few browsers show; save it as JPEG",
    b"mif1": "an HEIC picture, which few browsers show; save it as JPEG",
    b"avif": "an AVIF picture, which is not taken; save it as JPEG",
    b"avis": "an AVIF picture, which is not taken; save it as JPEG",
}


class NotShown(ValueError):
    """It is no picture or video that is shown to visitors; the message is the end of a sentence: "is ..."."""


class TooLarge(NotShown):
    """It has more bytes than are kept."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What a file is: the ending of its name."""

    suffix: str

    @property
    def is_video(self) -> bool:
        """Whether it has an end."""
        return self.suffix in VIDEOS

    @property
    def type(self) -> str:
        """As ``image/jpeg``."""
        return TYPES[self.suffix]

    @property
    def largest_bytes(self) -> int:
        """Files of more bytes are not kept."""
        return LARGEST_VIDEO_BYTES if self.is_video else LARGEST_PICTURE_BYTES

    def check_size(self, size: int) -> None:
        """Raises TooLarge for a file of ``size`` bytes."""
        if size > self.largest_bytes:
            what = "video" if self.is_video else "picture"
            raise TooLarge(f"is larger than the {self.largest_bytes // 1024**2} MB that a {what} may have")


def kind_of_name(file: str) -> Kind | None:
    """What the ending of ``file`` says that it is; None: nothing that is shown."""
    suffix = file.rpartition(".")[2].lower()
    return Kind(suffix) if suffix in (*PICTURES, *VIDEOS) else None


def kind_of_head(head: bytes) -> Kind:
    """What a file is that begins with ``head``, its first HEAD_BYTES or all of it. Raises NotShown."""
    if head.startswith(b"\xff\xd8\xff"):
        return Kind("jpg")
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return Kind("png")
    if head.startswith((b"GIF87a", b"GIF89a")):
        return Kind("gif")
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return Kind("webp")
    if head[4:8] == b"ftyp":
        brand = head[8:12]
        if brand in _NOT_SHOWN:
            raise NotShown(f"is {_NOT_SHOWN[brand]}")
        return Kind("mp4")
    if head.startswith(_EBML):
        at = head.find(_DOC_TYPE)
        if at >= 0 and head[at + 3 : at + 7] == b"webm":
            return Kind("webm")
        raise NotShown("is a Matroska film, which browsers play as WebM alone; save it as WebM or MP4")
    raise NotShown("is no picture (JPEG, PNG, WebP, GIF) and no video (MP4, WebM)" if head else "is empty")


def checked(path: Path) -> Kind:
    """What the file ``path`` is. Blocking. Raises NotShown for what is not whole or too large, and OSError."""
    with open_plain(path) as file:
        kind = kind_of_head(file.read(HEAD_BYTES))
        size = file.seek(0, 2)
        kind.check_size(size)
        file.seek(0)
        match kind.suffix:
            case "mp4":
                _check_mp4(file, size)
            case "webm":
                _check_webm(file, size)
            case _:
                _check_picture(file)
    return kind


def _check_picture(file: BinaryIO) -> None:
    from PIL import Image, UnidentifiedImageError  # seldom needed: not at the program's start

    try:
        with Image.open(file, formats=tuple(_FORMATS)) as picture:
            if picture.width * picture.height > MOST_PIXELS:
                across = f"{picture.width} x {picture.height}"
                raise NotShown(f"has {across} pixels; a picture may have {MOST_PIXELS // 10**6} million")
            picture.load()
    except Image.DecompressionBombError:
        raise NotShown(f"has more pixels than the {MOST_PIXELS // 10**6} million that a picture may have") from None
    # What Pillow's decoders raise for damaged files.
    except (UnidentifiedImageError, OSError, SyntaxError, EOFError, struct.error, IndexError) as damage:
        raise NotShown(f"is a damaged picture: {damage}") from None


def _check_mp4(file: BinaryIO, size: int) -> None:
    """Boxes follow one another to the file's end, and one of them says what is in it."""
    at, found = 0, set[bytes]()
    while at < size:
        file.seek(at)
        head = file.read(16)
        if len(head) < 8:
            raise NotShown("is a damaged video: its end is missing")
        length, name = struct.unpack(">I4s", head[:8])
        if length == 1 and len(head) == 16:
            (length,) = struct.unpack(">Q", head[8:])
        elif length == 0:
            length = size - at
        if length < 8 or at + length > size:
            raise NotShown("is a damaged video: its end is missing")
        found.add(name)
        at += length
    if not found >= {b"moov", b"mdat"}:
        raise NotShown("is a damaged video: it lacks its pictures, or what they are")


def _check_webm(file: BinaryIO, size: int) -> None:
    """A header, and a segment that is as long as it says."""
    at = 0
    while at < size:
        file.seek(at)
        head = file.read(12)
        if len(head) < 5:
            break
        width = _bytes_of(head[4])
        digits = bytes([head[4] & (0xFF >> width)]) + head[5 : 4 + width]
        unknown = digits == bytes([0xFF >> width]) + b"\xff" * (width - 1)
        if head[:4] == _SEGMENT:
            if unknown or at + 4 + width + int.from_bytes(digits) <= size:
                return
            break
        if unknown:
            break
        at += 4 + width + int.from_bytes(digits)
    raise NotShown("is a damaged video: its end is missing")


def _bytes_of(first: int) -> int:
    """How many bytes a length of EBML has whose first byte is ``first``. Raises NotShown."""
    width = 9 - first.bit_length()
    if width > 8:
        raise NotShown("is a damaged video")
    return width
