"""Classes of messages and services for rclpy, of types that no installed package holds.

rclpy and its middleware know a type by C code, which a package of ROS 2 is built with. For types that are known by
their definitions alone (``hbba_msgs``, and of others ``tf2_msgs`` and ``nav2_msgs``, which are not among ROS 2's
wheels) this makes what that code would be: functions and tables of C, of Python's, for Fast DDS as it is in ROS 2
Jazzy. A message is its CDR, which rosbags writes and reads, so that nothing is converted twice; publishers take CDR as
``bytes``, without any of the functions.
"""

from __future__ import annotations

import ctypes
from ctypes import addressof, c_void_p, cast, pointer
from functools import cache
from typing import Any

from app.logs.ros import typestore
from app.logs.ros.live.kinds import INTROSPECTION, Introspection, description, type_hash
from app.logs.ros.live.structs import (
    Create,
    Destroy,
    FromPython,
    Getter,
    Handle,
    LargestSize,
    Members,
    MessageCallbacks,
    MessageSupport,
    NoSources,
    Serialize,
    ServiceCallbacks,
    ServiceMembers,
    ServiceSupport,
    Size,
    ToPython,
    capsule,
)

_FAST_DDS = b"rosidl_typesupport_fastrtps_c"
#: CDR begins with four bytes of encapsulation, which the middleware writes itself.
_ENCAPSULATION = b"\x00\x01\x00\x00"
#: Seven pointers to member functions come before the reference to its buffer in a ``Cdr`` of Fast CDR 2.2.
_BUFFER_IN_CDR = 7 * 16
_EVENT_INFO = """\
uint8 event_type
builtin_interfaces/Time stamp
uint8[16] client_gid
int64 sequence_number
"""


class Unsupported(Exception):
    """The middleware here is another than these types are made for; the message is for people."""


class MadeMessage:
    """A message of a made class: its ``cdr``, with encapsulation."""

    __slots__ = ("cdr",)
    #: Name of the type: ``hbba_msgs/msg/Desire``.
    type_name = ""

    def __init__(self, cdr: bytes = b"") -> None:
        self.cdr = cdr

    @classmethod
    def of(cls, *values: Any) -> Any:
        """The message with these fields, in order, as rosbags has them."""
        return cls(typestore.serialise(cls.type_name, *values))

    def read(self) -> Any:
        """Its fields, as an object of rosbags. Raises ValueError where it is damaged."""
        return typestore.deserialise(self.type_name, self.cdr)


class _Cdr:
    """The middleware's buffers of CDR: Fast CDR 2's ``Cdr``, by pointer."""

    def __init__(self) -> None:
        """Raises Unsupported."""
        try:
            library = ctypes.CDLL("libfastcdr.so.2")
            # Cdr::serialize_array(const char*, size_t), Cdr::get_current_position(), Cdr::get_buffer_pointer()
            self._write = library["_ZN8eprosima7fastcdr3Cdr15serialize_arrayEPKcm"]
            self._position = library["_ZN8eprosima7fastcdr3Cdr20get_current_positionEv"]
            self._begin = library["_ZN8eprosima7fastcdr3Cdr18get_buffer_pointerEv"]
        except (OSError, AttributeError) as failure:
            raise Unsupported(f"Fast CDR 2 of ROS 2 Jazzy is not here: {failure}") from None
        self._write.argtypes, self._write.restype = [c_void_p, ctypes.c_char_p, ctypes.c_size_t], c_void_p
        for function in (self._position, self._begin):
            function.argtypes, function.restype = [c_void_p], c_void_p

    def write(self, cdr: int, data: bytes) -> None:
        self._write(cdr, data, len(data))

    def rest(self, cdr: int) -> bytes | None:
        """All from the current position to the end of its buffer; None where Cdr is laid out in another way."""
        buffer = c_void_p.from_address(cdr + _BUFFER_IN_CDR).value or 0
        # FastBuffer: its table of virtual functions, where its bytes are, and how many.
        begin, size = c_void_p.from_address(buffer + 8).value or 0, ctypes.c_size_t.from_address(buffer + 16).value
        at = self._position(cdr)
        if begin != self._begin(cdr) or not begin <= at <= begin + size:
            return None
        return ctypes.string_at(at, begin + size - at)


class _Held:
    """Messages in C: the address of a byte for each, and the CDR that it stands for."""

    def __init__(self) -> None:
        self._bytes: dict[int, tuple[Any, bytes]] = {}

    def create(self) -> int:
        place = ctypes.c_uint64()
        self._bytes[addressof(place)] = (place, b"")
        return addressof(place)

    def destroy(self, address: int) -> None:
        del self._bytes[address]

    def set(self, address: int, cdr: bytes) -> None:
        self._bytes[address] = (self._bytes[address][0], cdr)

    def get(self, address: int) -> bytes:
        return self._bytes[address][1]


class Maker:
    """Makes classes. All that C points to is kept as long as this is. ``sources``: for a type's support, that there is
    no text of its definition."""

    def __init__(self) -> None:
        self._cdr = _Cdr()
        self._held = _Held()
        self._introspection = Introspection()
        self._kept: list[Any] = []
        self._no_sources = NoSources(None, 0, 0)
        self.sources = Getter(lambda _: addressof(self._no_sources))
        self._serialize = Serialize(self._written)
        self._deserialize = Serialize(self._taken)
        self._size = Size(lambda message: max(len(self._held.get(message)) - len(_ENCAPSULATION), 0))
        self._largest = LargestSize(_unbounded)
        self._create = Create(self._held.create)
        self._destroy = Destroy(self._held.destroy)

    def keep(self, *made: object) -> None:
        """Keep what C points to."""
        self._kept += made

    def message(self, name: str, base: type[MadeMessage] = MadeMessage) -> type[MadeMessage]:
        """The class of the type ``name``, which the store has, with what ``base`` has."""
        support = self._message_support(name)
        made: Any = None

        def from_python(message: MadeMessage, address: int) -> bool:
            self._held.set(address, message.cdr)
            return True

        def to_python(address: int) -> MadeMessage:
            message: MadeMessage = made(self._held.get(address))
            return message

        functions = FromPython(from_python), ToPython(to_python)
        self._kept.append(functions)
        metaclass = type(
            "MadeType",
            (type,),
            {
                "_TYPE_SUPPORT": capsule(addressof(support)),
                "_CREATE_ROS_MESSAGE": _function(self._create),
                "_DESTROY_ROS_MESSAGE": _function(self._destroy),
                "_CONVERT_FROM_PY": _function(functions[0]),
                "_CONVERT_TO_PY": _function(functions[1]),
            },
        )
        made = metaclass(name.rpartition("/")[2], (base,), {"__slots__": (), "type_name": name})
        return made  # type: ignore[no-any-return]

    def service(self, name: str, request: type[MadeMessage], response: type[MadeMessage]) -> type[Any]:
        """The class of the service ``name``."""
        package, folder, short = name.split("/")
        supports = [self._message_support(each.type_name) for each in (request, response)]
        callbacks = ServiceCallbacks(
            f"{package}::{folder}".encode(), short.encode(), *(pointer(support) for support in supports)
        )
        introspected = ServiceMembers(f"{package}__{folder}".encode(), short.encode())
        for field, each in (("request", request), ("response", response)):
            members = cast(self._introspection.support(each.type_name).data, ctypes.POINTER(Members))
            setattr(introspected, field, members)
        hash_of, described = type_hash(name), description(name)
        common = (
            None,
            None,
            Getter(lambda _: addressof(hash_of)),
            Getter(lambda _: addressof(described)),
            self.sources,
        )
        pairs = addressof(supports[0]), addressof(supports[1]), None
        other = ServiceSupport(
            INTROSPECTION, addressof(introspected), Handle(lambda handle, _: handle), *pairs, *common
        )
        support = ServiceSupport(_FAST_DDS, addressof(callbacks), _chosen(other), *pairs, *common)
        self._kept += [supports, callbacks, introspected, hash_of, described, common, other, support]
        metaclass = type("MadeServiceType", (type,), {"_TYPE_SUPPORT": capsule(addressof(support))})
        made: type[Any] = metaclass(short, (), {"Request": request, "Response": response})
        return made

    def _message_support(self, name: str) -> MessageSupport:
        package, folder, short = name.split("/")
        callbacks = MessageCallbacks(
            namespace=f"{package}::{folder}".encode(),
            name=short.encode(),
            serialize=self._serialize,
            deserialize=self._deserialize,
            size=self._size,
            largest_size=self._largest,
        )
        hash_of, described = type_hash(name), description(name)
        support = MessageSupport(
            identifier=_FAST_DDS,
            data=addressof(callbacks),
            handle=_chosen(self._introspection.support(name)),
            hash=Getter(lambda _: addressof(hash_of)),
            description=Getter(lambda _: addressof(described)),
            sources=self.sources,
        )
        self._kept += [callbacks, hash_of, described, support]
        return support

    def _written(self, message: int, cdr: int) -> bool:
        self._cdr.write(cdr, self._held.get(message)[len(_ENCAPSULATION) :])
        return True

    def _taken(self, cdr: int, message: int) -> bool:
        rest = self._cdr.rest(cdr)
        if rest is None:
            return False
        self._held.set(message, _ENCAPSULATION + rest)
        return True


def message_class(name: str, base: Any = MadeMessage) -> type[MadeMessage]:
    """The class for rclpy of the message type ``name``, which :mod:`app.logs.ros.typestore` has; the same each time.
    It has what ``base`` has.

    Raises KeyError for a type that the store does not have, Unsupported.
    """
    return _message(name, base)


def service_class(name: str, request: str, response: str, base: Any = MadeMessage) -> type[Any]:
    """The class for rclpy of the service ``name`` (``hbba_msgs/srv/AddDesire``) with the fields of ``request`` and
    ``response``, as a ``.srv`` file has them. Its ``Request`` and ``Response`` are of ``base``.

    Raises Unsupported.
    """
    return _service(name, request, response, base)


@cache
def maker() -> Maker:
    """What makes the classes, of which there is one."""
    return Maker()


@cache
def _message(name: str, base: Any) -> type[MadeMessage]:
    return maker().message(name, base)


@cache
def _service(name: str, request: str, response: str, base: Any) -> type[Any]:
    typestore.add(f"{name}_Request", request)
    typestore.add(f"{name}_Response", response)
    # A service is described, and hashed, as a message that has both and an event (REP 2016).
    typestore.add("service_msgs/msg/ServiceEventInfo", _EVENT_INFO)
    parts = f"{name}_Request[<=1] request\n{name}_Response[<=1] response\n"
    typestore.add(f"{name}_Event", f"service_msgs/ServiceEventInfo info\n{parts}")
    typestore.add(name, "".join(f"{name}_{part} {part.lower()}_message\n" for part in ("Request", "Response", "Event")))
    return maker().service(name, _message(f"{name}_Request", base), _message(f"{name}_Response", base))


def _chosen(introspection: Any) -> Any:
    """The function by which the middleware asks a support for itself, or for that of introspection."""

    def handle(asked: int, identifier: bytes) -> int:
        if identifier == _FAST_DDS:
            return asked
        return addressof(introspection) if identifier == INTROSPECTION else 0

    return Handle(handle)


def _function(made: Any) -> object:
    return capsule(cast(made, c_void_p).value or 0)


def _unbounded(bounds: Any) -> int:
    bounds[0] = 0
    return 0
