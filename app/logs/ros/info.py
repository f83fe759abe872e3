"""Data without a place in ROS's own types, or with fewer digits there, is written beside them: ``/<channel>/info``.

It is the main part of its message: there is one for each, written last.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import fields, make_dataclass
from functools import cache
from typing import Any, Generic, TypeVar, get_type_hints

from app.base.geometry import Pose3
from app.logs.ros.generated import generated
from app.logs.ros.record import Record, RecordTopic
from app.logs.ros.record_templates import stamped

InfoT = TypeVar("InfoT")


class InfoTopic(Generic[InfoT]):
    """Writes and reads a dataclass whose first field is ``stamp`` and whose others seldom change."""

    def __init__(self, channel: str, cls: type[InfoT]) -> None:
        self._generated = generated(cls)
        self.topic = RecordTopic(f"/{channel}/info", self._generated.type)
        self._key: Hashable = None
        self._data = b""

    def record(self, info: InfoT, stamp_ns: int, key: Hashable) -> Record:
        """The record of ``info``; ``key`` identifies its content without the stamp: equal keys, equal bytes."""
        if key != self._key:
            self._data = self._generated.encode(info)
            self._key = key
        return Record(self.topic.name, self.topic.type, stamp_ns, stamped(self._data, stamp_ns))

    def decode(self, data: bytes) -> InfoT:
        """The value of a record. Raises ValueError where it is damaged."""
        info: InfoT = self._generated.decode(data)
        return info


def pose_key(pose: Pose3) -> Hashable:
    """A key that is equal for equal poses alone."""
    return pose.rotation.tobytes(), pose.translation.tobytes()


class RestTopic(InfoTopic[Any]):
    """The fields of a message class but those that its other records hold exactly: ``hbba_msgs/<Class>Info``."""

    def __init__(self, channel: str, cls: Any, *elsewhere: str) -> None:
        """``elsewhere``: the fields that are in other records."""
        self._cls = cls
        self._rest = _rest_of(cls, elsewhere)
        super().__init__(channel, self._rest)

    def record_of(self, message: Any, stamp_ns: int, key: Hashable) -> Record:
        """The record of ``message``; ``key`` as for :meth:`record`."""
        rest = self._rest(*(getattr(message, field.name) for field in fields(self._rest)))
        return self.record(rest, stamp_ns, key)

    def message(self, data: bytes, **elsewhere: Any) -> Any:
        """The message of a record and of its fields from elsewhere. Raises ValueError where it is damaged."""
        rest = self.decode(data)
        return self._cls(**{field.name: getattr(rest, field.name) for field in fields(rest)}, **elsewhere)


@cache
def _rest_of(cls: Any, elsewhere: tuple[str, ...]) -> type[Any]:
    hints = get_type_hints(cls)
    rest = [(field.name, hints[field.name]) for field in fields(cls) if field.name not in elsewhere]
    return make_dataclass(f"{cls.__name__}Info", rest, frozen=True, slots=True, namespace={"__module__": __name__})
