"""The C structures by which ROS 2 and its middleware know a type, as of ROS 2 Jazzy: ``rosidl_runtime_c``,
``rosidl_typesupport_introspection_c`` and ``rosidl_typesupport_fastrtps_cpp`` (Apache-2.0), whose headers say what each
field means."""

from __future__ import annotations

import ctypes
from ctypes import (
    CFUNCTYPE,
    POINTER,
    PYFUNCTYPE,
    Structure,
    c_bool,
    c_char_p,
    c_size_t,
    c_uint8,
    c_uint32,
    c_uint64,
    c_void_p,
    py_object,
)

Handle = CFUNCTYPE(c_void_p, c_void_p, c_char_p)
"""The support of a type that a middleware asks for by its identifier; 0 for one that there is not."""
Getter = CFUNCTYPE(c_void_p, c_void_p)
Serialize = CFUNCTYPE(c_bool, c_void_p, c_void_p)
Size = CFUNCTYPE(c_uint32, c_void_p)
LargestSize = CFUNCTYPE(c_size_t, POINTER(c_uint8))
#: The four by which rclpy makes, fills, reads and ends a message in C; they run with the interpreter's lock held.
Create = PYFUNCTYPE(c_void_p)
Destroy = PYFUNCTYPE(None, c_void_p)
FromPython = PYFUNCTYPE(c_bool, py_object, c_void_p)
ToPython = PYFUNCTYPE(py_object, c_void_p)


class TypeHash(Structure):
    """``rosidl_type_hash_t``."""

    _fields_ = (("version", c_uint8), ("value", c_uint8 * 32))


class MessageSupport(Structure):
    """``rosidl_message_type_support_t``."""

    _fields_ = (
        ("identifier", c_char_p),
        ("data", c_void_p),
        ("handle", Handle),
        ("hash", Getter),
        ("description", Getter),
        ("sources", Getter),
    )


class ServiceSupport(Structure):
    """``rosidl_service_type_support_t``."""

    _fields_ = (
        ("identifier", c_char_p),
        ("data", c_void_p),
        ("handle", Handle),
        ("request", c_void_p),
        ("response", c_void_p),
        ("event", c_void_p),
        ("make_event", c_void_p),
        ("destroy_event", c_void_p),
        ("hash", Getter),
        ("description", Getter),
        ("sources", Getter),
    )


class ActionSupport(Structure):
    """``rosidl_action_type_support_t``."""

    _fields_ = (
        ("goal", c_void_p),
        ("result", c_void_p),
        ("cancel", c_void_p),
        ("feedback", c_void_p),
        ("status", c_void_p),
        ("hash", Getter),
        ("description", Getter),
        ("sources", Getter),
    )


class Member(Structure):
    """``rosidl_typesupport_introspection_c__MessageMember``; offsets and functions are of messages in C, which ours are
    not."""

    _fields_ = (
        ("name", c_char_p),
        ("type", c_uint8),
        ("string_bound", c_size_t),
        ("members", POINTER(MessageSupport)),
        ("is_key", c_bool),
        ("is_array", c_bool),
        ("array_size", c_size_t),
        ("is_bound", c_bool),
        ("offset", c_uint32),
        ("default", c_void_p),
        ("functions", c_void_p * 6),
    )


class Members(Structure):
    """``rosidl_typesupport_introspection_c__MessageMembers``."""

    _fields_ = (
        ("namespace", c_char_p),
        ("name", c_char_p),
        ("count", c_uint32),
        ("size", c_size_t),
        ("has_key", c_bool),
        ("members", POINTER(Member)),
        ("functions", c_void_p * 2),
    )


class ServiceMembers(Structure):
    """``rosidl_typesupport_introspection_c__ServiceMembers``."""

    _fields_ = (
        ("namespace", c_char_p),
        ("name", c_char_p),
        ("request", POINTER(Members)),
        ("response", POINTER(Members)),
        ("event", POINTER(Members)),
    )


class MessageCallbacks(Structure):
    """``message_type_support_callbacks_t`` of Fast DDS."""

    _fields_ = (
        ("namespace", c_char_p),
        ("name", c_char_p),
        ("serialize", Serialize),
        ("deserialize", Serialize),
        ("size", Size),
        ("largest_size", LargestSize),
        ("key", c_void_p),
    )


class ServiceCallbacks(Structure):
    """``service_type_support_callbacks_t`` of Fast DDS."""

    _fields_ = (
        ("namespace", c_char_p),
        ("name", c_char_p),
        ("request", POINTER(MessageSupport)),
        ("response", POINTER(MessageSupport)),
    )


class Text(Structure):
    """``rosidl_runtime_c__String``."""

    _fields_ = (("data", c_char_p), ("size", c_size_t), ("capacity", c_size_t))

    @classmethod
    def of(cls, text: str) -> Text:
        """``text``, whose bytes the structure keeps alive."""
        data = text.encode()
        return cls(data, len(data), len(data) + 1)


class FieldType(Structure):
    """``type_description_interfaces/FieldType``."""

    _fields_ = (("type", c_uint8), ("capacity", c_uint64), ("string_capacity", c_uint64), ("nested", Text))


class Field(Structure):
    """``type_description_interfaces/Field``."""

    _fields_ = (("name", Text), ("type", FieldType), ("default", Text))


class Fields(Structure):
    """A sequence of fields."""

    _fields_ = (("data", POINTER(Field)), ("size", c_size_t), ("capacity", c_size_t))


class OneDescription(Structure):
    """``type_description_interfaces/IndividualTypeDescription``."""

    _fields_ = (("name", Text), ("fields", Fields))


class Descriptions(Structure):
    """A sequence of descriptions."""

    _fields_ = (("data", POINTER(OneDescription)), ("size", c_size_t), ("capacity", c_size_t))


class Description(Structure):
    """``type_description_interfaces/TypeDescription``: a type, and those it uses."""

    _fields_ = (("type", OneDescription), ("used", Descriptions))


class NoSources(Structure):
    """An empty sequence of sources."""

    _fields_ = (("data", c_void_p), ("size", c_size_t), ("capacity", c_size_t))


def capsule(pointer: int) -> object:
    """A PyCapsule of ``pointer``, as rclpy takes them of a class."""
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = py_object, [c_void_p, c_char_p, c_void_p]
    made: object = new(pointer, None, None)
    return made


def pointer_in(held: object) -> int:
    """What a PyCapsule that rclpy takes of a class points to."""
    get = ctypes.pythonapi.PyCapsule_GetPointer
    get.restype, get.argtypes = c_void_p, [py_object, c_char_p]
    return int(get(held, None) or 0)
