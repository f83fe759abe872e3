"""Messages with nothing in them, to be filled field by field: rosbags' objects have no defaults."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.logs.ros import typestore
from app.logs.ros.live.kinds import Kind, fields_of


def blank(name: str, **given: Any) -> Any:
    """A message of the type ``name``, which the store has: zero, empty and false, but for the fields ``given``."""
    values = [given.get(field, _EMPTY) for field, _ in fields_of(name)]
    kinds = [kind for _, kind in fields_of(name)]
    return typestore.make(
        name, *(_empty(kind) if value is _EMPTY else value for kind, value in zip(kinds, values, strict=True))
    )


_EMPTY = object()


def _empty(kind: Kind) -> Any:
    count = kind.count if kind.is_array else 0
    if kind.is_array or kind.is_sequence:
        if kind.nested or kind.base in ("string", "wstring"):
            return [_one(kind) for _ in range(count)]
        return np.zeros(count, {"byte": "uint8", "octet": "uint8", "char": "uint8"}.get(kind.base, kind.base))
    return _one(kind)


def _one(kind: Kind) -> Any:
    if kind.nested:
        return blank(kind.nested)
    if kind.base in ("string", "wstring"):
        return ""
    return False if kind.base == "bool" else 0.0 if kind.base.startswith("float") else 0
