"""From configuration to a body."""

from __future__ import annotations

from app.errors import ConfigError
from app.link import RobotLink
from app.robots.config import RobotConfig
from app.robots.model import load_model
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.world_config import WorldConfig
from app.yaml_source import parse


def create_link(robot_config: RobotConfig, clock_offset: float) -> RobotLink:
    """The body that ``robot_config`` asks for, not yet started; ``clock_offset`` + ``time.monotonic()`` is its clock.

    Raises ConfigError (file, line, key) if its model or its world is wrong.
    """
    _check_model(robot_config)
    return SimulatedLink(robot_config, parse(robot_config.world, WorldConfig), clock_offset)


def _check_model(robot: RobotConfig) -> None:
    """Raise ConfigError unless the model has the joints and links that the configuration names."""
    model = load_model(robot.model)
    sensors = [sensor.link for sensor in (robot.streams.kinect, robot.streams.hokuyo) if sensor is not None]
    for joint in (robot.base.left_wheel_joint, robot.base.right_wheel_joint):
        if joint not in model.joint_names:
            raise ConfigError(f"has no moving joint {joint!r}, a wheel of {robot.name}", str(robot.model))
    for link in sensors:
        if link not in model.links:
            raise ConfigError(f"has no link {link!r} for a sensor of {robot.name}", str(robot.model))
