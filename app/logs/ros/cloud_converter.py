"""Point clouds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from app.logs.ros import typestore
from app.logs.ros.frames import BASE, header
from app.logs.ros.info import RestTopic
from app.logs.ros.record import MAIN, Record, RecordTopic
from app.logs.ros.record_templates import assembled, with_length
from app.messages import PointCloud, read_only

_FLOAT32 = 7
XYZ = ("x", "y", "z")
#: Colour as PCL packs it: a float32 whose bytes are blue, green, red and 0.
XYZ_RGB = (*XYZ, "rgb")
_POINT = np.dtype([("xyz", "<f4", 3), ("bgr", "u1", 3), ("pad", "u1")])


class CloudHead:
    """``sensor_msgs/PointCloud2`` of one frame with float32 fields, in one row."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/PointCloud2"

    def __init__(self, frame: str, fields: Sequence[str]) -> None:
        described = [
            typestore.make("sensor_msgs/msg/PointField", name, 4 * i, _FLOAT32, 1) for i, name in enumerate(fields)
        ]
        self._step = 4 * len(fields)
        nothing = np.zeros(0, np.uint8)
        data = typestore.serialise(self.TYPE, header(frame), 1, 0, described, False, self._step, 0, nothing, True)
        # At the end: row_step, length of the data (both still 0), is_dense. The width follows header and height.
        self._head, self._dense = data[:-9], data[-1:]
        self._width_at = 4 + 8 + _padded(4 + len(frame.encode()) + 1) + 4

    def encode(self, stamp_ns: int, points: NDArray[Any]) -> bytes:
        """CDR of ``points``, C-contiguous: N points of this head's fields."""
        count = len(points)
        head, at = self._head, self._width_at
        size = (count * self._step).to_bytes(4, "little")
        bulk = np.ascontiguousarray(points).view(np.uint8).reshape(-1).data
        head = b"".join((head[:at], count.to_bytes(4, "little"), head[at + 4 :], size))
        return assembled(head, stamp_ns, *with_length(bulk, len(bulk)), self._dense)


class PointCloudConverter:
    """``sensor_msgs/PointCloud2`` in ``base_link`` with colours, and the pose of its base."""

    def __init__(self, channel: str) -> None:
        self._cloud = RecordTopic(f"/{channel}", CloudHead.TYPE, "points")
        self._info = RestTopic(channel, PointCloud, "points", "colors")
        self.topics = (self._cloud, self._info.topic)
        self._head = CloudHead(BASE, XYZ_RGB)

    def encode(self, message: PointCloud, stamp_ns: int) -> list[Record]:
        points = np.zeros(len(message.points), _POINT)
        points["xyz"] = message.points
        points["bgr"] = message.colors[:, ::-1]
        return [
            Record(self._cloud.name, CloudHead.TYPE, stamp_ns, self._head.encode(stamp_ns, points)),
            self._info.record_of(message, stamp_ns, message.X_OB),
        ]

    def decode(self, parts: Mapping[str, bytes]) -> PointCloud | None:
        if "points" not in parts:
            return None
        points = typestore.deserialise(CloudHead.TYPE, parts["points"]).data.view(_POINT)
        xyz = np.ascontiguousarray(points["xyz"])
        colors = np.ascontiguousarray(points["bgr"][:, ::-1])
        cloud: PointCloud = self._info.message(parts[MAIN], points=read_only(xyz), colors=read_only(colors))
        return cloud


def _padded(size: int) -> int:
    """``size`` up to the next multiple of four."""
    return -(-size // 4) * 4
