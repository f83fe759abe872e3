"""The live stream's messages: pure."""

from __future__ import annotations

import msgspec

from .records import LIVE

#: No pictures: they are for pages.
NO_PICTURES = '{"type":"view","camera":false,"panorama":false,"map":false,"costmap":false}'


class _Kind(msgspec.Struct):
    type: str


_kinds = msgspec.json.Decoder(_Kind)
_decoders = {kind: msgspec.json.Decoder(record, strict=False) for kind, record in LIVE.items()}


def message_of(frame: str | bytes) -> msgspec.Struct | None:
    """The record in a text ``frame``; None for pictures, sound, and what a newer program sends beside."""
    if isinstance(frame, bytes):
        return None
    decoder = _decoders.get(_kinds.decode(frame).type)
    return decoder.decode(frame) if decoder is not None else None
