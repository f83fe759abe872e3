"""A velocity as rosbridge takes it in JSON: a pure function."""

from __future__ import annotations

from typing import Any

from app.logs.stamps import SECOND, to_ns
from app.robots.guard import BaseVelocity


def twist_message(velocity: BaseVelocity, frame: str | None, stamp: float | None, *, ros1: bool) -> dict[str, Any]:
    """The geometry_msgs/Twist of ``velocity``; with a ``frame`` the TwistStamped of ``stamp`` (s). Where that is None,
    rosbridge puts the robot's own time into it."""
    twist = {
        "linear": {"x": velocity.linear_mps, "y": velocity.lateral_mps, "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": velocity.angular_radps},
    }
    if frame is None:
        return twist
    header: dict[str, Any] = {"frame_id": frame}
    if stamp is not None:
        names = ("secs", "nsecs") if ros1 else ("sec", "nanosec")
        header["stamp"] = dict(zip(names, divmod(to_ns(stamp), SECOND), strict=True))
    return {"header": header, "twist": twist}
