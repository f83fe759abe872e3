"""The process of a robot over ROS 2: ``python -m app.robots.ros2.process SOCKET`` (an inherited file descriptor).

It ends by a Stop message, when the other end of the socket closes, or when the program dies; its last word to the robot
is zero.
"""

from __future__ import annotations

import os
import sys
from functools import partial

from app.logs.ros.live.graph import MISSING
from app.robots.body_process import Loaded, Unavailable, run_body


def load() -> Loaded:
    """What a robot over ROS 2 needs. Raises Unavailable where ROS 2 is not installed."""
    try:
        import rclpy  # noqa: F401
    except ImportError:
        raise Unavailable(MISSING) from None
    from app.robots.ros2.body_loop import BodyLoop
    from app.robots.ros2.node import RosNode
    from app.robots.ros2.protocol import Start

    return Start, partial(BodyLoop, RosNode)


if __name__ == "__main__":
    status = run_body(sys.argv[1:], load)
    sys.stderr.flush()
    os._exit(status)  # rclpy's and the middleware's exit handlers have nothing to add
