"""Link of a robot over ROS 2 in the program: what its process needs, and what body it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.link import RobotDescription, StreamDescription
from app.logs.ros.live.graph import environment
from app.messages import BatteryState, Image, Imu, JointState, LaserScan, LinkStatus, Odometry
from app.robots.process_link import ProcessLink
from app.robots.ros2.config import STATUS_HZ, Ros2Config
from app.robots.ros2.protocol import Start

START_TIMEOUT_S = 30.0
"""Beyond the time in which the robot may appear: for a process that loads its libraries."""
_TYPES: dict[str, type[Any]] = {
    "odometry": Odometry,
    "joints": JointState,
    "hokuyo": LaserScan,
    "battery": BatteryState,
    "imu": Imu,
    "camera": Image,
    "kinect": Image,
}


class Ros2Link(ProcessLink):
    """Implements ``app.link.RobotLink``, over ROS 2 or rosbridge; ``clock_offset`` (s) makes the robot's clock of
    ``time.monotonic()``. A topic that is not wanted has no subscription."""

    def __init__(self, config: Ros2Config, clock_offset: float) -> None:
        def begin(demanded: Mapping[str, float], e_stop: str | None) -> Start:
            return Start(config, clock_offset, demanded, e_stop)

        within_s = START_TIMEOUT_S + config.graph.found_within_s
        where = environment(config.graph.discovery)
        module = "app.robots.ros2.process" if config.graph.rosbridge is None else "app.robots.ros2.rosbridge.process"
        super().__init__(describe(config), module, begin, within_s, environment=where)


def describe(config: Ros2Config) -> RobotDescription:
    """The description of the body that ``config`` maps."""
    rates = {name: topic.rate_hz for name, topic in config.mapped.items()}
    rates["joints"] = config.standing_rates_hz[1]
    streams = {name: StreamDescription(name, _TYPES[name], rate_hz) for name, rate_hz in rates.items()}
    streams["status"] = StreamDescription("status", LinkStatus, STATUS_HZ)
    return RobotDescription(
        config.name,
        config.model,
        config.limits.base(),
        streams,
        simulated=False,
        footprint=config.footprint,
        height_m=config.height_m,
        restartable=True,
        groups=dict(config.groups),
        arms=dict(config.arm_descriptions),
    )
