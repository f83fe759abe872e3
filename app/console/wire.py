"""JSON as it goes over the wire: msgspec, which takes dataclasses as they are and writes NaN and infinity as null."""

from __future__ import annotations

from typing import Any

import msgspec

_encoder = msgspec.json.Encoder()


def encode(value: Any) -> bytes:
    """``value`` as compact JSON in UTF-8."""
    return _encoder.encode(value)


def encode_text(value: Any) -> str:
    """``value`` as compact JSON, for a text frame."""
    return _encoder.encode(value).decode()


def frame(kind: str, record: Any) -> str:
    """``record`` as the message ``kind`` of the live stream: its members after the member ``type``."""
    return f'{{"type":"{kind}",{encode_text(record)[1:]}'
