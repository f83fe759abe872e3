"""Landmarks as they are, and for viewers a ball and a name for each."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from app.logs.ros import typestore
from app.logs.ros.frames import ODOM
from app.logs.ros.native_types import GeneratedConverter
from app.logs.ros.record import Record, RecordTopic
from app.messages import Landmark, Landmarks

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
        self._drawn: tuple[Landmark, ...] = ()

    def encode(self, message: Landmarks, stamp_ns: int) -> list[Record]:
        records = super().encode(message, stamp_ns)
        if _moved(self._drawn, message.landmarks):
            self._drawn = message.landmarks
            data = typestore.serialise(_MARKERS, _markers(message.landmarks, stamp_ns))
            records.insert(0, Record(self._markers.name, _MARKERS, stamp_ns, data))
        return records


def _moved(before: tuple[Landmark, ...], now: tuple[Landmark, ...]) -> bool:
    if [landmark.text for landmark in before] != [landmark.text for landmark in now]:
        return True
    return any(math.dist(a.p_OQ, b.p_OQ) > _STEP_M for a, b in zip(before, now, strict=True))


def _markers(landmarks: tuple[Landmark, ...], stamp_ns: int) -> list[Any]:
    markers = [_marker(0, _SPHERE, (0.0, 0.0, 0.0), "", stamp_ns, action=_DELETE_ALL)]
    for i, landmark in enumerate(landmarks):
        x, y, z = landmark.p_OQ
        markers.append(_marker(2 * i, _SPHERE, (x, y, z), "", stamp_ns))
        markers.append(_marker(2 * i + 1, _TEXT, (x, y, z + _SIZE_M), typestore.encodable(landmark.text), stamp_ns))
    return markers


def _marker(
    number: int, kind: int, position: tuple[float, float, float], text: str, stamp_ns: int, action: int = 0
) -> Any:
    make = typestore.make
    header = make("std_msgs/msg/Header", typestore.time(stamp_ns), ODOM)
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
