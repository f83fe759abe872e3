"""From configuration to a body."""

from __future__ import annotations

from app.link import RobotLink
from app.robots.config import RobotConfig
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.world_config import WorldConfig
from app.yaml_source import parse


def create_link(robot_config: RobotConfig, clock_offset: float) -> RobotLink:
    """The body that ``robot_config`` asks for, not yet started; ``clock_offset`` + ``time.monotonic()`` is its clock.

    Raises ConfigError (file, line, key) if its world is wrong.
    """
    return SimulatedLink(robot_config, parse(robot_config.world, WorldConfig), clock_offset)
