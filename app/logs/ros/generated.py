"""ROS definitions made from our dataclasses, so that any message, also tomorrow's, is recordable as it is.

=====================================  ==================================================================
Python                                 ROS
=====================================  ==================================================================
``stamp: float``                       ``builtin_interfaces/Time stamp``
``float``, ``int``, ``bool``, ``str``  ``float64``, ``int64``, ``bool``, ``string``
``bytes``                              ``uint8[]``
record                                 nested ``hbba_msgs/<Class>``, or of its package
``tuple[X, ...]``, ``tuple[X, X]``     ``X[]``, ``X[2]``
``NDArray[np.float32]``                ``float32[] name`` (row by row) and ``uint32[] name_shape``
``X | None``                           ``bool has_name`` and ``X name`` (zeros, empty, where there is none)
``Mapping[str, X]``                    ``hbba_msgs/<X>Entry[]``, each ``string key`` and ``X value``
``Mapping[str, Any]``                  ``string``, which holds JSON
=====================================  ==================================================================

A field is named as in Python, in lower case, since ROS allows no other: ``X_BC`` is ``x_bc``. What ``Annotated`` says
of a field beside its type is not in the definition.
"""

from __future__ import annotations

import json
import re
import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.logs.ros import typestore
from app.logs.stamps import to_ns
from app.messages.base import field_names, is_record, read_only

PACKAGE = "hbba_msgs"

#: Arrays of one shape always: they need not say it.
_SHAPES: dict[tuple[type[Any], str], tuple[int, ...]] = {
    (Pose3, "rotation"): (3, 3),
    (Pose3, "translation"): (3,),
}

_NUMBERS = {float: ("float64", np.float64), int: ("int64", np.int64), bool: ("bool", np.bool_)}


class UnrecordableType(TypeError):
    """A dataclass with a field that no ROS definition can be made of; the message names it."""


@dataclass(frozen=True, slots=True)
class _Field:
    """Conversion of one field of a dataclass to ROS fields (``(type, name)`` each) and their values, and back."""

    declared: tuple[tuple[str, str], ...]
    pack: Callable[[Any], tuple[Any, ...]]
    unpack: Callable[[Iterator[Any]], Any]
    empty: Any


def package_of(cls: type[Any]) -> str:
    """The ROS package of the type of ``cls``: ``hbba_msgs``, or that of the import package which ``cls`` comes from."""
    root = cls.__module__.partition(".")[0]
    return PACKAGE if root == "app" else f"{re.sub('[^a-z0-9]+', '_', root.lower()).strip('_')}_msgs"


class Generated:
    """The ROS type ``hbba_msgs/msg/<Class>`` of a dataclass, of another package's ``<package>_msgs/msg/<Class>``:
    registered when made."""

    def __init__(self, cls: type[Any]) -> None:
        """Raises UnrecordableType."""
        self.type = f"{package_of(cls)}/msg/{cls.__name__}"
        hints = typing.get_type_hints(cls)
        self._cls = cls
        self._names = field_names(cls)
        self._fields = [_field(cls, name, hints[name]) for name in self._names]
        declared = [pair for field in self._fields for pair in field.declared]
        if len({name for _, name in declared}) < len(declared):
            raise UnrecordableType(f"two fields of {cls.__name__} have one name in ROS: {declared}")
        typestore.add(self.type, "\n".join(f"{kind} {name}" for kind, name in declared))
        self._make = typestore.store().types[self.type]
        # rosbags renames Python's keywords, and keeps the type's name as one more field.
        self._attributes = [f.name for f in fields(self._make) if f.name != "__msgtype__"]  # type: ignore[arg-type]

    def to_ros(self, message: Any) -> Any:
        """The rosbags object of ``message``."""
        values: list[Any] = []
        for name, field in zip(self._names, self._fields, strict=True):
            values += field.pack(getattr(message, name))
        return self._make(*values)

    def from_ros(self, ros: Any) -> Any:
        """The message of the rosbags object ``ros``. Fields added since its definition have their defaults."""
        if not isinstance(ros, self._make):
            return self._from_older(ros)
        values = iter([getattr(ros, name) for name in self._attributes])
        return self._cls(*[field.unpack(values) for field in self._fields])

    def _from_older(self, ros: Any) -> Any:
        given, begin = {}, 0
        for name, field in zip(self._names, self._fields, strict=True):
            attributes = self._attributes[begin : begin + len(field.declared)]
            begin += len(field.declared)
            if all(hasattr(ros, each) for each in attributes):
                given[name] = field.unpack(iter([getattr(ros, each) for each in attributes]))
        return self._cls(**given)

    def encode(self, message: Any) -> bytes:
        """CDR of ``message``."""
        ros = self.to_ros(message)
        return bytes(typestore.store().serialize_cdr(ros, self.type, little_endian=True))

    def decode(self, data: bytes) -> Any:
        """The message in ``data``. Raises ValueError where it is damaged."""
        return self.from_ros(typestore.deserialise(self.type, data))

    def empty(self) -> Any:
        """A message of default values, written in place of an absent one."""
        return self._cls(*[field.empty for field in self._fields])


def generated(cls: type[Any]) -> Generated:
    """The ROS type of ``cls``, a dataclass; the same each time. Raises UnrecordableType."""
    found = _made.get(cls)
    if found is None:
        found = _made[cls] = Generated(cls)
    return found


def class_of(name: str) -> type[Any] | None:
    """The class whose ROS type, made before, is ``name``; None for any other type."""
    return next((cls for cls, made in list(_made.items()) if made.type == name), None)


def rest_has_defaults(cls: type[Any], written: Sequence[bool]) -> bool:
    """Whether a message of ``cls`` can be made of some fields of its ROS type: of each, whether it was ``written``.

    Those of ``cls`` that were not must have defaults, and none may be split. Raises UnrecordableType.
    """
    hints, begin = typing.get_type_hints(cls), 0
    for name, optional in _has_default(cls).items():
        end = begin + len(_field(cls, name, hints[name]).declared)
        parts, begin = written[begin:end], end
        if not (all(parts) or (optional and not any(parts))):
            return False
    return True


def _has_default(cls: type[Any]) -> dict[str, bool]:
    """Whether each field of the record ``cls`` has a default, in order."""
    if issubclass(cls, msgspec.Struct):
        return {
            field.name: field.default is not msgspec.NODEFAULT or field.default_factory is not msgspec.NODEFAULT
            for field in msgspec.structs.fields(cls)
        }
    return {field.name: field.default is not MISSING or field.default_factory is not MISSING for field in fields(cls)}


#: Types registered so far: each is registered once for the whole process, for there is one store.
_made: dict[type[Any], Generated] = {}


def _field(cls: type[Any], name: str, hint: Any) -> _Field:
    if name == "stamp" and hint is float:
        return _single(
            "builtin_interfaces/Time", name, lambda stamp: typestore.time(to_ns(stamp)), typestore.seconds, 0.0
        )
    try:
        return _by_hint(name.lower(), hint, _SHAPES.get((cls, name)))
    except UnrecordableType as error:
        raise UnrecordableType(f"{cls.__name__}.{name} is {hint}: {error}") from None


def _by_hint(name: str, hint: Any, shape: tuple[int, ...] | None = None) -> _Field:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return _optional(name, arguments)
    if origin is tuple:
        return _tuple(name, arguments)
    if origin is Mapping:
        return _mapping(name, arguments[1])
    if origin is np.ndarray:
        return _array(name, typing.get_args(arguments[1])[0], shape)
    if origin is typing.Literal and all(isinstance(value, str) for value in arguments):
        hint = str
    if hint in _NUMBERS:
        return _single(_NUMBERS[hint][0], name, hint, hint, hint())
    if hint is str:
        return _single("string", name, typestore.encodable, str, "")
    if hint is bytes:
        return _single("uint8[]", name, lambda data: np.frombuffer(data, np.uint8), lambda a: a.tobytes(), b"")
    if is_record(hint):
        nested = generated(hint)
        return _single(_nested_name(nested), name, nested.to_ros, nested.from_ros, nested.empty())
    raise UnrecordableType("ROS has nothing like it")


def _single(kind: str, name: str, pack: Callable[[Any], Any], unpack: Callable[[Any], Any], empty: Any) -> _Field:
    return _Field(((kind, name),), lambda value: (pack(value),), lambda values: unpack(next(values)), empty)


def _optional(name: str, options: tuple[Any, ...]) -> _Field:
    given = [option for option in options if option is not types.NoneType]
    if len(given) != 1:
        raise UnrecordableType("of several types, one at most beside None")
    field = _by_hint(name, given[0])
    nothing = (False, *field.pack(field.empty))

    def unpack(values: Iterator[Any]) -> Any:
        present = next(values)
        value = field.unpack(values)
        return value if present else None

    declared = (("bool", f"has_{name}"), *field.declared)
    return _Field(declared, lambda value: nothing if value is None else (True, *field.pack(value)), unpack, None)


def _tuple(name: str, arguments: tuple[Any, ...]) -> _Field:
    item = arguments[0]
    if arguments[1:] == (Ellipsis,):
        size, length = "[]", 0
    elif all(argument is item for argument in arguments):
        size, length = f"[{len(arguments)}]", len(arguments)
    else:
        raise UnrecordableType("a tuple holds one type only")
    if item in _NUMBERS:
        kind, dtype = _NUMBERS[item]
        return _single(kind + size, name, lambda values: np.array(values, dtype), lambda a: tuple(a.tolist()),
                       (item(),) * length)  # fmt: skip
    one = _by_hint(name, item)
    if len(one.declared) != 1 or one.declared[0][0].endswith("]"):
        raise UnrecordableType("ROS has no sequence of that")
    return _single(
        one.declared[0][0] + size,
        name,
        lambda values: [one.pack(value)[0] for value in values],
        lambda values: tuple(one.unpack(iter((value,))) for value in values),
        (one.empty,) * length,
    )


def _mapping(name: str, hint: Any) -> _Field:
    if hint is Any:
        return _single("string", name, _pack_json, json.loads, {})
    value = _by_hint("value", hint)
    kind = value.declared[0][0]
    if len(value.declared) != 1 or kind.endswith("]"):
        raise UnrecordableType("a mapping is from words to one value each")
    package, _, short = kind.rpartition("/")
    declared = f"{package or PACKAGE}/{short[0].upper()}{short[1:]}Entry"
    entry = declared.replace("/", "/msg/")
    typestore.add(entry, f"string key\n{kind} value")
    return _single(
        f"{declared}[]",
        name,
        lambda mapping: [typestore.make(entry, typestore.encodable(k), *value.pack(v)) for k, v in mapping.items()],
        lambda entries: {each.key: value.unpack(iter((each.value,))) for each in entries},
        {},
    )


def _array(name: str, scalar: Any, shape: tuple[int, ...] | None) -> _Field:
    try:
        dtype = np.dtype(scalar)
    except TypeError:
        raise UnrecordableType("an array says what its numbers are") from None
    if dtype.kind not in "iufb" or dtype.itemsize > 8 or dtype == np.float16:
        raise UnrecordableType("ROS has no such numbers")
    kind = dtype.name

    def flat(array: NDArray[Any]) -> NDArray[Any]:
        return np.ascontiguousarray(array, dtype).reshape(-1)

    if shape is not None:
        empty = read_only(np.zeros(shape, dtype))
        return _single(f"{kind}[{empty.size}]", name, flat, lambda a: read_only(np.array(a, dtype).reshape(shape)),
                       empty)  # fmt: skip
    return _Field(
        ((f"{kind}[]", name), ("uint32[]", f"{name}_shape")),
        lambda array: (flat(array), np.array(array.shape, np.uint32)),
        lambda values: read_only(np.array(next(values), dtype).reshape(next(values))),
        read_only(np.zeros(0, dtype)),
    )


def _nested_name(nested: Generated) -> str:
    package, _, name = nested.type.split("/")
    return f"{package}/{name}"


def _pack_json(mapping: Mapping[str, Any]) -> str:
    return typestore.encodable(json.dumps(dict(mapping), ensure_ascii=False))
