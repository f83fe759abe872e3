"""Landmarks as they are, and for viewers a ball and a name for each."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.logs.ros import typestore
from app.logs.ros.native_types import GeneratedConverter
from app.logs.ros.record import Record, RecordTopic
from app.messages import Landmarks

_MARKERS = "visualization_msgs/msg/MarkerArray"
_SPHERE, _TEXT, _DELETE_ALL = 2, 9, 3
#: Diameter of a ball and height of letters (m).
_SIZE_M = 0.1
#: Markers are drawn again when one has moved this far (m) from its drawn place: each sighting moves them by
#: millimetres.
_STEP_M = 0.05


class LandmarksConverter(GeneratedConverter):
    """The generated type, and markers of all of them when one is new, gone or elsewhere."""

    def __init__(self, channel: str) -> None:
        super().__init__(channel, Landmarks)
        self._markers = RecordTopic(f"/{channel}/markers", _MARKERS, None)
        self.topics = (*self.topics, self._markers)
        self._drawn = Landmarks(0.0, ())

    def encode(self, message: Landmarks, stamp_ns: int) -> list[Record]:
        records = super().encode(message, stamp_ns)
        if _moved(self._drawn, message):
            self._drawn = message
            data = typestore.serialise(_MARKERS, _markers(message, stamp_ns))
            records.insert(0, Record(self._markers.name, _MARKERS, stamp_ns, data))
        return records


def _moved(before: Landmarks, now: Landmarks) -> bool:
    if before.frame != now.frame or [mark.text for mark in before.landmarks] != [mark.text for mark in now.landmarks]:
        return True
    pairs = zip(before.landmarks, now.landmarks, strict=True)
    return any(math.dist(a.p_FQ, b.p_FQ) > _STEP_M for a, b in pairs)


def _markers(message: Landmarks, stamp_ns: int) -> list[Any]:
    header = typestore.make("std_msgs/msg/Header", typestore.time(stamp_ns), message.frame)
    markers = [_marker(header, 0, _SPHERE, (0.0, 0.0, 0.0), action=_DELETE_ALL)]
    for i, landmark in enumerate(message.landmarks):
        x, y, z = landmark.p_FQ
        markers.append(_marker(header, 2 * i, _SPHERE, (x, y, z)))
        text = typestore.encodable(landmark.text)
        markers.append(_marker(header, 2 * i + 1, _TEXT, (x, y, z + _SIZE_M), text=text))
    return markers


def _marker(
    header: Any, number: int, kind: int, position: tuple[float, float, float], *, text: str = "", action: int = 0
) -> Any:
    make = typestore.make
    unit = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    no_bytes = np.zeros(0, np.uint8)
    return make(
        "visualization_msgs/msg/Marker",
        header=header,
        ns="landmarks",
        id=number,
        type=kind,
        action=action,
        pose=make("geometry_msgs/msg/Pose", make("geometry_msgs/msg/Point", *position), unit),
        scale=make("geometry_msgs/msg/Vector3", _SIZE_M, _SIZE_M, _SIZE_M),
        color=make("std_msgs/msg/ColorRGBA", 1.0, 0.6, 0.0, 1.0),
        lifetime=make("builtin_interfaces/msg/Duration", 0, 0),
        frame_locked=False,
        points=[],
        colors=[],
        texture_resource="",
        texture=make("sensor_msgs/msg/CompressedImage", header, "", no_bytes),
        uv_coordinates=[],
        text=text,
        mesh_resource="",
        mesh_file=make("visualization_msgs/msg/MeshFile", "", no_bytes),
        mesh_use_embedded_materials=False,
    )
