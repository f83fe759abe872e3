"""The process of a robot over rosbridge's WebSocket: ``python -m app.robots.ros2.rosbridge.process SOCKET`` (an
inherited file descriptor); as :mod:`app.robots.ros2.process`, without rclpy."""

from __future__ import annotations

import sys
from functools import partial

from app.robots.body_process import Loaded, run_body


def load() -> Loaded:
    """What a robot over rosbridge needs."""
    from app.robots.ros2.body_loop import BodyLoop
    from app.robots.ros2.protocol import Start
    from app.robots.ros2.rosbridge.node import RosbridgeNode

    return Start, partial(BodyLoop, RosbridgeNode)


if __name__ == "__main__":
    sys.exit(run_body(sys.argv[1:], load))
