"""How the kinds of fields are numbered, and a type's definition in C: for the middleware, and for those who ask."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, cast, pointer
from typing import Any

from rosbags.interfaces import Nodetype

from app.logs.ros import typestore
from app.logs.ros.live.structs import (
    Description,
    Descriptions,
    Field,
    Fields,
    FieldType,
    Handle,
    Member,
    Members,
    MessageSupport,
    OneDescription,
    Text,
    TypeHash,
)

#: By name: the number of ``rosidl_typesupport_introspection_c/field_types.h``, and that of
#: ``type_description_interfaces/msg/FieldType``.
_NUMBERS = {
    "float32": (1, 10),
    "float64": (2, 11),
    "bool": (6, 15),
    "byte": (7, 16),
    "octet": (7, 16),
    "char": (8, 13),
    "uint8": (8, 3),
    "int8": (9, 2),
    "uint16": (10, 5),
    "int16": (11, 4),
    "uint32": (12, 7),
    "int32": (13, 6),
    "uint64": (14, 9),
    "int64": (15, 8),
    "string": (16, 17),
    "wstring": (17, 18),
}
_MESSAGE, _NESTED, _BOUNDED_STRING = 18, 1, 21
#: What is added to a field's number in a description: of an array, a bounded and an unbounded sequence.
_ARRAY, _BOUNDED, _UNBOUNDED = 48, 96, 144
INTROSPECTION = b"rosidl_typesupport_introspection_c"


class Kind:
    """What a field of rosbags' definitions is. ``count``: of an array, or the bound of a sequence."""

    def __init__(self, described: Any) -> None:
        node, inner = described
        self.is_array = node == Nodetype.ARRAY
        self.is_sequence = node == Nodetype.SEQUENCE
        self.count = 0
        if self.is_array or self.is_sequence:
            (node, inner), self.count = inner
        self.nested = inner if node == Nodetype.NAME else ""
        self.base: str = ""
        self.string_bound: int = 0
        if not self.nested:
            self.base, self.string_bound = inner

    @property
    def introspected(self) -> int:
        """The number of introspection."""
        return _MESSAGE if self.nested else _NUMBERS[self.base][0]

    @property
    def described(self) -> int:
        """The number in a description."""
        number = _NESTED if self.nested else _BOUNDED_STRING if self.string_bound else _NUMBERS[self.base][1]
        if self.is_array:
            return number + _ARRAY
        return number + (_BOUNDED if self.count else _UNBOUNDED) if self.is_sequence else number


def fields_of(name: str) -> list[tuple[str, Kind]]:
    """The fields of the type ``name``, in order."""
    return [(field, Kind(described)) for field, described in typestore.store().fielddefs[name][1]]


def type_hash(name: str) -> TypeHash:
    """The hash of the type ``name`` (REP 2011)."""
    digest = bytes.fromhex(typestore.store().hash_rihs01(name).removeprefix("RIHS01_"))
    return TypeHash(1, (ctypes.c_uint8 * len(digest))(*digest))


def description(name: str) -> Description:
    """The definition of the type ``name`` and of all it uses, for those who ask a node for it."""
    used: list[str] = []
    _add_used(name, used)
    others = [_one(other) for other in sorted(used)]
    array = (OneDescription * len(others))(*others)
    return Description(_one(name), Descriptions(cast(array, POINTER(OneDescription)), len(others), len(others)))


def _add_used(name: str, used: list[str]) -> None:
    for _, kind in fields_of(name):
        if kind.nested and kind.nested not in used:
            used.append(kind.nested)
            _add_used(kind.nested, used)


def _one(name: str) -> OneDescription:
    fields = [
        Field(
            Text.of(field),
            FieldType(kind.described, kind.count, kind.string_bound, Text.of(kind.nested)),
            Text.of(""),
        )
        for field, kind in fields_of(name)
    ]
    array = (Field * len(fields))(*fields)
    return OneDescription(Text.of(name), Fields(cast(array, POINTER(Field)), len(fields), len(fields)))


class Introspection:
    """The members of types for the middleware, which sends their shape to other computers, and compares it."""

    def __init__(self) -> None:
        self._supports: dict[str, MessageSupport] = {}

    def support(self, name: str) -> MessageSupport:
        """The support of the type ``name``; the same each time."""
        known = self._supports.get(name)
        if known is not None:
            return known
        members = pointer(self._members(name))
        made = MessageSupport(INTROSPECTION, cast(members, ctypes.c_void_p), Handle(lambda handle, _: handle))
        made.kept = members
        self._supports[name] = made
        return made

    def _members(self, name: str) -> Members:
        package, folder, short = name.split("/")
        fields = fields_of(name)
        array = (Member * len(fields))()
        for member, (field, kind) in zip(array, fields, strict=True):
            member.name, member.type, member.string_bound = field.encode(), kind.introspected, kind.string_bound
            member.is_array, member.array_size = kind.is_array or kind.is_sequence, kind.count
            member.is_bound = kind.is_sequence and kind.count > 0
            if kind.nested:
                member.members = pointer(self.support(kind.nested))
        made = Members(f"{package}__{folder}".encode(), short.encode(), len(fields))
        made.members = cast(array, POINTER(Member))
        made.kept = array
        return made
