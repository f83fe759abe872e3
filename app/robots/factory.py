"""Construction of bodies from configuration."""

from __future__ import annotations

from pathlib import Path

from app.base.errors import ConfigError
from app.base.yaml_source import load_yaml, parse
from app.link import RobotLink, StreamDescription
from app.messages import JointState, LinkStatus, Odometry
from app.robots.config import RobotConfig, StartPose, load_robot_config
from app.robots.devices.config import JOINTS_HZ, ODOMETRY_HZ, STATUS_HZ, DevicesConfig, load_devices_config
from app.robots.model import load_model
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig, load_scenario
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import Clock

Body = RobotConfig | DevicesConfig


def load_body(path: Path | str) -> Body:
    """Read the body of the file, of any kind. Raises ConfigError (file, line, key)."""
    data = load_yaml(path).data
    if isinstance(data, dict) and data.get("kind") == "devices":
        return load_devices_config(path)
    return load_robot_config(path)


def standing_streams(body: Body) -> dict[str, StreamDescription]:
    """The streams that every body has."""
    rates = (ODOMETRY_HZ, JOINTS_HZ, STATUS_HZ)
    if isinstance(body, RobotConfig):
        rates = (body.streams.odometry.rate_hz, body.streams.joints.rate_hz, body.streams.status.rate_hz)
    types = {"odometry": Odometry, "joints": JointState, "status": LinkStatus}
    return {
        name: StreamDescription(name, kind, rate_hz) for (name, kind), rate_hz in zip(types.items(), rates, strict=True)
    }


def body_files(body: Body) -> tuple[Path, ...]:
    """The files named by the body's own file that a recording needs."""
    if isinstance(body, DevicesConfig):
        return (body.model,)
    return (body.model, body.world, *((body.scenario,) if body.scenario is not None else ()))


def create_link(robot_config: Body, clock_offset: float) -> RobotLink:
    """The link of the body ``robot_config``, not yet started; ``clock_offset`` + ``time.monotonic()`` is its clock.

    Raises ConfigError (file, line, key) if its model or its world is wrong.
    """
    if isinstance(robot_config, DevicesConfig):
        return _devices(robot_config, clock_offset)
    robot, world, scenario = simulated_parts(robot_config)
    return SimulatedLink(robot, world, clock_offset, scenario)


def create_lockstep(
    robot_config: RobotConfig,
    clock: Clock,
    *,
    world: WorldConfig | None = None,
    cameras: bool = False,
    microphones: bool = False,
) -> LockstepLink:
    """The simulated body ``robot_config`` in the program's own process, in step with ``clock``; see ``lockstep.py``.

    ``world`` replaces the one that its file names. Raises ConfigError (file, line, key) if its model or its world
    is wrong.
    """
    robot, world, scenario = simulated_parts(robot_config, world)
    return LockstepLink(robot, world, clock, scenario, cameras=cameras, microphones=microphones)


def simulated_parts(
    robot: RobotConfig, world: WorldConfig | None = None
) -> tuple[RobotConfig, WorldConfig, ScenarioConfig | None]:
    """Parts of a simulated body: its configuration with the scenario's start, its world, the scenario.

    ``world`` replaces the one that its file names. Raises ConfigError.
    """
    _check_model(robot)
    world = world or parse(robot.world, WorldConfig)
    if robot.scenario is None:
        return robot, world, None
    scenario = load_scenario(robot.scenario)
    if scenario.start is not None:
        robot = robot.model_copy(update={"start": StartPose(**scenario.start.model_dump())})
    return robot, world, scenario


def _devices(config: DevicesConfig, clock_offset: float) -> RobotLink:
    from app.robots.devices.link import DevicesLink  # imports sound libraries, which a simulated body does not need

    model = load_model(config.model)
    for device in (config.camera, config.microphones):
        if device is not None and device.link not in model.links:
            raise ConfigError(f"has no link {device.link!r} for a device of {config.name}", str(config.model))
    return DevicesLink(config, model, clock_offset)


def _check_model(robot: RobotConfig) -> None:
    """Raise ConfigError unless the model has the joints and links that the configuration names."""
    model = load_model(robot.model)
    streams = robot.streams
    parts = (streams.kinect, streams.hokuyo, streams.imv, streams.microphones, robot.loudspeaker)
    sensors = [part.link for part in parts if part is not None]
    for joint in (robot.base.left_wheel_joint, robot.base.right_wheel_joint):
        if joint not in model.joint_names:
            raise ConfigError(f"has no moving joint {joint!r}, a wheel of {robot.name}", str(robot.model))
    for link in sensors:
        if link not in model.links:
            raise ConfigError(f"has no link {link!r} for a sensor of {robot.name}", str(robot.model))
