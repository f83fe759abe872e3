"""JSON as it goes over the wire: msgspec, which takes dataclasses as they are and writes NaN and infinity as null.

Arrays are lists (of lists) of their numbers.
"""

from __future__ import annotations

import hashlib
from typing import Any

import msgspec
import numpy as np


def _list(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise NotImplementedError(f"{type(value).__name__} has no JSON")


_encoder = msgspec.json.Encoder(enc_hook=_list)


def encode(value: Any) -> bytes:
    """``value`` as compact JSON in UTF-8. Raises NotImplementedError for what has none."""
    return _encoder.encode(value)


def encode_text(value: Any) -> str:
    """``value`` as compact JSON, for a text frame."""
    return _encoder.encode(value).decode()


def frame(kind: str, record: Any) -> str:
    """``record`` as the message ``kind`` of the live stream: its members after the member ``type``."""
    return f'{{"type":"{kind}",{encode_text(record)[1:]}'


def etag(version: Any) -> str:
    """The entity tag of ``version``, anything with a JSON: 16 hexadecimal digits, quoted."""
    return f'"{hashlib.sha256(encode(version)).hexdigest()[:16]}"'
