"""The body of a simulated robot that ROS is played for, and the options that its players share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.link import RobotLink
from app.maps.map_file import read_map
from app.messages import JointCommand
from app.robots.battery_config import BatteryConfig
from app.robots.config import StartPose
from app.robots.factory import create_link, load_body
from app.robots.ros2.config import Ros2Config
from app.robots.simulated.kinematic.config import KinematicLaserConfig, kinematic_of
from app.robots.simulated.kinematic.link import KinematicLink
from app.runtime.clock import RealClock

BATTERY = BatteryConfig(capacity_wh=26.0, charge=0.9, empty_v=12.0, full_v=16.4)
#: What it draws (W), and how often (s) that is reckoned.
LOAD_W, BATTERY_S = 12.0, 1.0
#: Robot's laser: an RPLIDAR A1's rays, all around.
_LASER: dict[str, Any] = {"rays": 360, "fov_deg": 359.0, "range_max_m": 12.0, "range_min_m": 0.15}


class Controllers:
    """The controllers of ros2_control of the joints of ``link``: each goes to its newest set-point, all the way, and
    stays. :meth:`hold` is called with each state of the joints."""

    def __init__(self, link: RobotLink, clock: RealClock) -> None:
        self._link = link
        self._clock = clock
        self._setpoints: dict[str, tuple[tuple[str, ...], tuple[float, ...]]] = {}

    def take(self, group: str, names: tuple[str, ...], positions: tuple[float, ...]) -> None:
        """Take the set-point ``positions`` (rad, m) of joints ``names``."""
        self._setpoints[group] = names, positions

    def hold(self) -> None:
        """Command every set-point again: the body itself stops where commands do."""
        for group, setpoint in self._setpoints.items():
            self._link.command(JointCommand(self._clock.now(), group, *setpoint))


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that :func:`played_body` and its player take."""
    parser.add_argument("--robot", type=Path, required=True, help="its mapping")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--map", type=Path, help="YAML file of a kept map")
    where.add_argument("--body", type=Path, help="a simulated body, in its world")
    parser.add_argument("--start", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar=("X", "Y", "DEGREES"))
    parser.add_argument("--watchdog", type=float, default=0.5, help="seconds after which it stops by itself")
    parser.add_argument("--ahead", type=float, default=0.0, help="seconds by which its clock is ahead")
    parser.add_argument("--log", type=Path, default=None, help="file for its true velocity")


def played_body(config: Ros2Config, options: argparse.Namespace, clock: RealClock) -> RobotLink:
    """The body that is played: that of a file, or the mapping's own on the map."""
    if options.body is not None:
        return create_link(load_body(options.body), clock.offset)
    laser = config.streams.hokuyo
    limits = config.limits.model_copy(update={"command_timeout_s": options.watchdog})
    x, y, heading = options.start
    body = kinematic_of(
        config.model_copy(update={"limits": limits}),
        options.map,
        StartPose(x=x, y=y, heading_deg=heading),
        laser=None if laser is None else KinematicLaserConfig(link=laser.link, rate_hz=10, **_LASER),
    )
    return KinematicLink(body, read_map(body.map), clock)
