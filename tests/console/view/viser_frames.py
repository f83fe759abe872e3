"""What viser sends its page, read as the page reads it."""

from __future__ import annotations

from typing import Any

import msgspec
import zstandard


def viser_messages(frame: bytes) -> list[dict[str, Any]]:
    """The messages of one frame of viser's WebSocket."""
    size = int.from_bytes(frame[8:16], "little")
    window = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(frame[16 : 16 + size]))
    return list(window["messages"])
