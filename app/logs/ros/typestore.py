"""The ROS 2 types a recording uses: the ones ROS comes with, and ours, in one store of rosbags."""

from __future__ import annotations

import threading
from functools import cache
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from app.logs.stamps import SECOND, from_ns

#: Recordings are written in one thread and read in others; all share one store, since filling it costs.
_guard = threading.RLock()
_added: dict[str, str] = {}


def store() -> Typestore:
    """The store: definitions of ROS 2 Humble, to which ours are added. It only grows."""
    with _guard:
        return _humble()


@cache
def _humble() -> Typestore:
    return get_typestore(Stores.ROS2_HUMBLE)


def add(name: str, text: str) -> None:
    """Add the type ``name`` (``hbba_msgs/msg/Twist``) with the lines ``text`` of its ``.msg`` file; twice is harmless.

    Parts of services and actions are types, too: ``nav_msgs/srv/GetMap_Request``.

    Raises rosbags' TypesysError if the name has another definition already.
    """
    with _guard:
        _added[name] = text
        store().register({_whole(made): (constants, [(field, _renamed(kind)) for field, kind in fields])
                          for made, (constants, fields) in get_types_from_msg(text, name).items()})  # fmt: skip


def added() -> tuple[tuple[str, str], ...]:
    """Names and texts of all that was added, in that order."""
    with _guard:
        return tuple(_added.items())


def _whole(name: str) -> str:
    """``pkg/srv/Name`` of what rosbags makes of it, which takes every type for one of a ``.msg`` file."""
    return name.replace("/srv/msg/", "/srv/").replace("/action/msg/", "/action/")


def _renamed(kind: Any) -> Any:
    if isinstance(kind, str):
        return _whole(kind)
    return tuple(map(_renamed, kind)) if isinstance(kind, tuple) else kind


def definition(name: str) -> str:
    """``ros2msg`` text of a type: its ``.msg`` file, then those of every type it uses, as MCAP's registry says."""
    return store().generate_msgdef(name, ros_version=2)[0]


def make(name: str, *values: Any, **named: Any) -> Any:
    """A rosbags object of the type, its fields in order or by name; arrays of numbers are numpy arrays."""
    return store().types[name](*values, **named)


def time(stamp_ns: int) -> Any:
    """A ``builtin_interfaces/Time``."""
    return make("builtin_interfaces/msg/Time", *divmod(stamp_ns, SECOND))


def seconds(time: Any) -> float:
    """Seconds of a ``builtin_interfaces/Time``."""
    return from_ns(time.sec * SECOND + time.nanosec)


def serialise(name: str, *values: Any) -> bytes:
    """Little-endian CDR of the type with these fields, in order."""
    return bytes(store().serialize_cdr(make(name, *values), name, little_endian=True))


def of_definition(name: str, text: str) -> Typestore:
    """A store of the type ``name`` alone, and what it uses, as a file's ``ros2msg`` definition says."""
    then = get_typestore(Stores.EMPTY)
    then.register(get_types_from_msg(text, name))
    return then


def deserialise(name: str, data: bytes, types: Typestore | None = None) -> Any:
    """The rosbags object in ``data`` (of the store ``types``, if given); its arrays are views of ``data``.

    Raises ValueError where it is damaged.
    """
    try:
        return (types or store()).deserialize_cdr(data, name)
    except SerdeError as error:
        raise ValueError(f"no {name}: {error}") from error


def encodable(text: str) -> str:
    """Replace characters that UTF-8 cannot encode (half a surrogate pair, out of a file's name) by question marks."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()
