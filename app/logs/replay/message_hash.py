"""A hash of messages: equal for equal messages, in any process."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Mapping
from enum import Enum
from typing import Any

import numpy as np

from app.messages.base import field_names, is_record


class MessageHash:
    """Of all messages of a channel, in their order."""

    def __init__(self) -> None:
        self._hash = hashlib.blake2b(digest_size=16)
        #: Number of messages.
        self.count = 0

    def add(self, message: Any) -> None:
        """Add a message. Raises TypeError for a value without a defined encoding."""
        self.count += 1
        _feed(self._hash.update, message)

    def hex(self) -> str:
        """The fingerprint so far, 32 hexadecimal digits."""
        return self._hash.hexdigest()


def fingerprint(message: Any) -> str:
    """Hash of one message; also of numbers, texts, arrays, tuples and mappings of them."""
    digest = MessageHash()
    digest.add(message)
    return digest.hex()


def _feed(update: Any, value: Any) -> None:
    """Write ``value`` so that no two different values are written alike: each with its kind and its length."""
    match value:
        case None:
            update(b"0")
        case bool():
            update(b"b1" if value else b"b0")
        case int():
            text = b"%d" % value
            update(b"i%d:" % len(text) + text)
        case float():
            update(b"f" + struct.pack("<d", value))
        case str():
            data = value.encode()
            update(b"s%d:" % len(data) + data)
        case bytes():
            update(b"y%d:" % len(value))
            update(value)
        case Enum():
            _feed(update, value.value)
        case np.ndarray():
            update(f"a{value.dtype.str}{value.shape}:".encode())
            update(np.ascontiguousarray(value).data)
        case np.generic():
            _feed(update, value.item())
        case tuple() | list():
            update(b"t%d:" % len(value))
            for item in value:
                _feed(update, item)
        case Mapping():
            update(b"m%d:" % len(value))
            for key in sorted(value):
                _feed(update, key)
                _feed(update, value[key])
        case _ if is_record(type(value)):
            update(f"d{type(value).__name__}:".encode())
            for name in field_names(type(value)):
                _feed(update, getattr(value, name))
        case _:
            raise TypeError(f"a {type(value).__name__} has no certain bytes")
