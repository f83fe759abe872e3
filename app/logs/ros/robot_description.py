"""The robot's model as a ROS message (URDF): viewers draw the robot from it."""

from __future__ import annotations

from app.logs import layout as mcap_layout
from app.logs.manifest import Manifest
from app.logs.ros import typestore
from app.logs.ros.record import Record

TOPIC = "/robot_description"
TYPE = "std_msgs/msg/String"
METADATA = {mcap_layout.DERIVED: "true"}


def robot_description(manifest: Manifest, stamp_ns: int) -> Record | None:
    """The URDF among the manifest's files on ``/robot_description``; None where there is none, or it is no text."""
    for attached in manifest.files:
        if attached.name.endswith(".urdf"):
            try:
                text = attached.data.decode()
            except UnicodeDecodeError:
                return None
            return Record(TOPIC, TYPE, stamp_ns, typestore.serialise(TYPE, text))
    return None
