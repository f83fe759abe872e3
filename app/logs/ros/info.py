"""Data without a place in ROS's own types, or with fewer digits there, is written beside them: ``/<channel>/info``.

It is the main part of its message: there is one for each, written last.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar

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
