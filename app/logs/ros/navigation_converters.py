"""Maps and paths in the types of ROS's navigation; values that these hold with fewer digits are written beside,
exactly."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from app.logs.ros import typestore
from app.logs.ros.info import RestTopic
from app.logs.ros.record import MAIN, Record, RecordTopic
from app.messages import OccupancyGrid, PlannedPath, read_only

_GRID = "nav_msgs/msg/OccupancyGrid"
_PATH = "nav_msgs/msg/Path"


class OccupancyGridConverter:
    """``nav_msgs/OccupancyGrid``, and its figures exactly."""

    def __init__(self, channel: str) -> None:
        self._grid = RecordTopic(f"/{channel}", _GRID, "cells")
        self._info = RestTopic(channel, OccupancyGrid, "cells")
        self.topics = (self._grid, self._info.topic)

    def encode(self, message: OccupancyGrid, stamp_ns: int) -> list[Record]:
        height, width = message.cells.shape
        corner = _pose(*message.origin, 0.0)
        time = typestore.time(stamp_ns)
        about = typestore.make("nav_msgs/msg/MapMetaData", time, message.resolution_m, width, height, corner)
        cells = np.ascontiguousarray(message.cells).reshape(-1)
        key = (message.frame, message.resolution_m, message.origin, message.version)
        return [
            Record(
                self._grid.name, _GRID, stamp_ns, typestore.serialise(_GRID, _header(message.frame, time), about, cells)
            ),
            self._info.record_of(message, stamp_ns, key),
        ]

    def decode(self, parts: Mapping[str, bytes]) -> OccupancyGrid | None:
        if "cells" not in parts:
            return None
        ros = typestore.deserialise(_GRID, parts["cells"])
        cells = np.asarray(ros.data, np.int8).reshape(ros.info.height, ros.info.width)
        grid: OccupancyGrid = self._info.message(parts[MAIN], cells=read_only(cells))
        return grid


class PlannedPathConverter:
    """``nav_msgs/Path`` for viewers, and the poses exactly."""

    def __init__(self, channel: str) -> None:
        self._path = RecordTopic(f"/{channel}", _PATH, None)
        self._info = RestTopic(channel, PlannedPath)
        self.topics = (self._path, self._info.topic)

    def encode(self, message: PlannedPath, stamp_ns: int) -> list[Record]:
        head = _header(message.frame, typestore.time(stamp_ns))
        poses = [typestore.make("geometry_msgs/msg/PoseStamped", head, _pose(*pose)) for pose in message.poses.tolist()]
        return [
            Record(self._path.name, _PATH, stamp_ns, typestore.serialise(_PATH, head, poses)),
            self._info.record_of(message, stamp_ns, (message.frame, message.poses.shape, message.poses.tobytes())),
        ]

    def decode(self, parts: Mapping[str, bytes]) -> PlannedPath:
        path: PlannedPath = self._info.message(parts[MAIN])
        return path


def _header(frame: str, time: Any) -> Any:
    return typestore.make("std_msgs/msg/Header", time, frame)


def _pose(x: float, y: float, theta: float) -> Any:
    point = typestore.make("geometry_msgs/msg/Point", x, y, 0.0)
    turn = typestore.make("geometry_msgs/msg/Quaternion", 0.0, 0.0, math.sin(0.5 * theta), math.cos(0.5 * theta))
    return typestore.make("geometry_msgs/msg/Pose", point, turn)
