"""Messages as rosbridge writes them in JSON, from and to the objects of rosbags: pure functions, by the definitions of
the types.

Bytes (``uint8[]``) are base64; null is a float that is not finite, of which NaN is made; a list of bytes, and the words
NaN and Infinity, are taken, too. ROS 1 calls some fields otherwise than ROS 2. Source: rosbridge_library's
``message_conversion``, and the protocol's specification, version 2.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.logs.importers.ros_messages import Unreadable
from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.kinds import Kind, fields_of

_TIME = {"sec": "secs", "nanosec": "nsecs"}
#: By type: the names in ROS 1 of fields that ROS 2 calls otherwise.
_ROS1 = {
    "builtin_interfaces/msg/Time": _TIME,
    "builtin_interfaces/msg/Duration": _TIME,
    "sensor_msgs/msg/CameraInfo": {name: name.upper() for name in "dkrp"},
}
#: Fields that came to ROS late, which an older one does not send: they are left empty.
_LATE = {("sensor_msgs/msg/BatteryState", "temperature")}
_BYTES = frozenset({"uint8", "byte", "octet", "char"})
_DTYPES = {"byte": "uint8", "octet": "uint8", "char": "uint8"}
#: Characters of a value that are quoted where it is wrong.
_QUOTED = 40

_Read = Callable[[Any, str], Any]


def parsed(text: str | bytes) -> dict[str, Any]:
    """The object that a frame of the socket is. Raises Unreadable."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as failure:
        raise Unreadable(f"it is no JSON: {failure}") from None
    if not isinstance(value, dict):
        raise Unreadable(f"it is no object, but {_short(value)}")
    return value


def to_message(kind: str, value: Any) -> Any:
    """The message of the type ``kind`` that ``value``, of JSON, is. Raises Unreadable, which names the field."""
    return _reader(kind)(value, "")


def from_message(kind: str, message: Any, *, ros1: bool = False) -> dict[str, Any]:
    """``message``, of the type ``kind``, for JSON; with the names of ROS 1."""
    return {
        (_ROS1.get(kind, {}).get(name, name) if ros1 else name): _written(field, getattr(message, name), ros1)
        for name, field in fields_of(kind)
    }


def plain_name(kind: str) -> str:
    """The name of a type in ROS 1, which is part of that in ROS 2: ``nav_msgs/Odometry``."""
    return kind.replace("/msg/", "/")


def same_type(one: str, other: str) -> bool:
    """Whether two names, of ROS 1 or 2, are of one type."""
    return plain_name(one) == plain_name(other)


@cache
def _reader(kind: str) -> _Read:
    """What makes a message of the type ``kind`` of a value of JSON, at a path in it."""
    fields = [(name, _field_reader(field)) for name, field in fields_of(kind)]
    other_names = _ROS1.get(kind, {})

    def read(value: Any, path: str) -> Any:
        if not isinstance(value, dict):
            raise Unreadable(f"{path or 'it'} is {_short(value)}, no {plain_name(kind)}")
        read_fields: dict[str, Any] = {}
        for name, read_field in fields:
            found = name if name in value else other_names.get(name, name)
            if found in value:
                read_fields[name] = read_field(value[found], f"{path}.{name}" if path else name)
            elif (kind, name) in _LATE:
                read_fields[name] = getattr(blank(kind), name)
            else:
                raise Unreadable(f"it has no {path}.{name}" if path else f"it has no {name}")
        return typestore.make(kind, *read_fields.values())

    return read


def _field_reader(field: Kind) -> _Read:
    if not (field.is_array or field.is_sequence):
        return _one_reader(field)
    if field.nested or field.base in ("string", "wstring"):
        read_one = _one_reader(field)

        def read_list(value: Any, path: str) -> Any:
            return _counted(field, [read_one(each, f"{path}[{n}]") for n, each in enumerate(_list(value, path))], path)

        return read_list
    return lambda value, path: _counted(field, _numbers(field.base, value, path), path)


def _one_reader(field: Kind) -> _Read:
    if field.nested:
        kind = field.nested
        return lambda value, path: _reader(kind)(value, path)
    return _SCALARS.get(field.base) or (lambda value, path: _integer(field.base, value, path))


def _float(value: Any, path: str) -> float:
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Unreadable(f"{path} is {_short(value)}, no number")
    try:
        return float(value)
    except OverflowError:
        raise Unreadable(f"{path} is too large a number") from None


def _integer(base: str, value: Any, path: str) -> int:
    limits = np.iinfo(_DTYPES.get(base, base))
    if isinstance(value, bool) or not isinstance(value, int) or not limits.min <= value <= limits.max:
        raise Unreadable(f"{path} is {_short(value)}, no {base}")
    return value


def _bool(value: Any, path: str) -> bool:
    if not isinstance(value, bool):
        raise Unreadable(f"{path} is {_short(value)}, neither true nor false")
    return value


def _text(value: Any, path: str) -> str:
    if not isinstance(value, str):
        raise Unreadable(f"{path} is {_short(value)}, no text")
    return value


_SCALARS: dict[str, _Read] = {
    "float32": _float, "float64": _float, "bool": _bool, "string": _text, "wstring": _text,
}  # fmt: skip


def _numbers(base: str, value: Any, path: str) -> NDArray[Any]:
    """An array of numbers; of bytes from base64, too."""
    if base in _BYTES and isinstance(value, str):
        try:
            return np.frombuffer(base64.b64decode(value, validate=True), np.uint8)
        except (binascii.Error, ValueError) as failure:
            raise Unreadable(f"{path} is no base64: {failure}") from None
    given = _list(value, path)
    dtype = np.dtype(_DTYPES.get(base, base))
    if not given:
        return np.zeros(0, dtype)
    allowed = (int, float, type(None)) if dtype.kind == "f" else (bool,) if base == "bool" else (int,)
    if not all(type(each) in allowed for each in given):
        wrong = next(n for n, each in enumerate(given) if type(each) not in allowed)
        raise Unreadable(f"{path}[{wrong}] is {_short(given[wrong])}, no {base}")
    try:
        with np.errstate(over="ignore"):  # a number beyond float32 is infinite in it
            return np.array(given, np.float64).astype(dtype) if dtype.kind == "f" else np.array(given, dtype)
    except OverflowError:
        raise Unreadable(f"{path} has a number that is too large for {base}") from None


def _list(value: Any, path: str) -> list[Any]:
    if not isinstance(value, list):
        raise Unreadable(f"{path} is {_short(value)}, no list")
    return value


def _counted(field: Kind, values: Any, path: str) -> Any:
    if field.is_array and len(values) != field.count:
        raise Unreadable(f"{path} has {len(values)} values, not {field.count}")
    return values


def _short(value: Any) -> str:
    if isinstance(value, dict | list):
        return "an object" if isinstance(value, dict) else "a list"
    if isinstance(value, str) and len(value) > _QUOTED:
        return f"{value[:_QUOTED]!r}…"
    return json.dumps(value)


def _written(field: Kind, value: Any, ros1: bool) -> Any:
    if field.is_array or field.is_sequence:
        if field.nested:
            return [from_message(field.nested, each, ros1=ros1) for each in value]
        if field.base in _BYTES:
            return base64.b64encode(np.asarray(value, np.uint8).tobytes()).decode("ascii")
        plain = value.tolist() if isinstance(value, np.ndarray) else list(value)
        return [_finite(each) for each in plain] if field.base.startswith("float") else plain
    if field.nested:
        return from_message(field.nested, value, ros1=ros1)
    if field.base.startswith("float"):
        return _finite(float(value))
    return bool(value) if field.base == "bool" else str(value) if field.base.endswith("string") else int(value)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
