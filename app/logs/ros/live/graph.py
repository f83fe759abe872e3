"""The environment of a process that joins a graph of ROS 2."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

Discovery = Literal["localhost", "subnet", "environment"]
_TRANSPORTS, _RANGE = "FASTDDS_BUILTIN_TRANSPORTS", "ROS_AUTOMATIC_DISCOVERY_RANGE"
#: Where rclpy is not, this is said to people.
MISSING = (
    "ROS 2 is not here (there is no rclpy for this Python): pip install 'hbba[ros2]', or start the program in a shell "
    "that has sourced a ROS 2 of the same Python"
)


def environment(discovery: Discovery) -> dict[str, str]:
    """Variables of the process: how far it looks for others, and by what its messages go.

    By UDP also within a computer: a process that froze with a lock in shared memory would hold the others up.
    """
    found = {} if _TRANSPORTS in os.environ else {_TRANSPORTS: "UDPv4"}
    if discovery != "environment":
        found[_RANGE] = discovery.upper()
    return found


def installed_definition(file: str) -> str | None:
    """The text of ``nav2_msgs/action/NavigateToPose.action`` or its like, of the sourced ROS 2; None where
    it has none."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and (path := Path(prefix, "share", file)).is_file():
            return path.read_text(encoding="utf-8")
    return None
