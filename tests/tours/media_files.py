"""Pictures and videos as small files."""

from __future__ import annotations

import struct
from typing import Any

import cv2
import numpy as np


def picture(suffix: str = "png", shade: int = 90, *, width: int = 32) -> bytes:
    """A picture of ``width`` x 24 pixels of one shade (0 to 255), made by OpenCV."""
    done, data = cv2.imencode(f".{suffix}", np.full((24, width, 3), shade, np.uint8))
    assert done
    return bytes(data)


def box(name: bytes, content: bytes = b"") -> bytes:
    """A box of ISO/IEC 14496-12."""
    return struct.pack(">I4s", 8 + len(content), name) + content


def mp4(brand: bytes = b"isom", content: bytes = b"pictures") -> bytes:
    """The container of an MP4 video."""
    return box(b"ftyp", brand + bytes(4)) + box(b"moov") + box(b"mdat", content)


def element(number: bytes, content: bytes) -> bytes:
    """An element of EBML of up to 126 bytes."""
    return number + bytes([0x80 | len(content)]) + content


def webm(kind: bytes = b"webm") -> bytes:
    """The container of a WebM video."""
    return element(b"\x1a\x45\xdf\xa3", element(b"\x42\x82", kind)) + element(b"\x18\x53\x80\x67", b"pictures")


def showing(*files: str) -> list[dict[str, Any]]:
    """Steps that show ``files``."""
    return [{"show": {"file": file, "alt": {"en": "A picture"}}} for file in files]
