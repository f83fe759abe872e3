"""Construction of bodies from configuration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.base.extensions import extensions
from app.base.kinematic_model import load_model
from app.base.yaml_source import load_yaml, parse, suggestion
from app.link import RobotLink, StreamDescription
from app.maps.map_file import read_map
from app.messages import JointState, LinkStatus, Odometry
from app.robots.config import BodyConfig, RobotConfig, StartPose, load_robot_config
from app.robots.devices.config import DevicesConfig, load_devices_config
from app.robots.drivers.config import DriversConfig, load_drivers_config
from app.robots.ros2.config import Ros2Config, load_ros2_config
from app.robots.ros2.link import Ros2Link
from app.robots.simulated.kinematic.config import KinematicConfig, load_kinematic_config
from app.robots.simulated.kinematic.link import KinematicLink
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig, load_scenario
from app.robots.simulated.world_config import WorldConfig
from app.runtime.clock import Clock, RealClock

Body = BodyConfig


@dataclass(frozen=True, slots=True)
class BodyKind:
    """A kind of body: what an entry point of the group ``hbba.bodies`` names; its name is the ``kind`` of files.

    ``load`` reads a file of that kind and raises ConfigError (:func:`app.robots.config.load_body_config` does most of
    it). ``create`` makes the link, not yet started, of what ``load`` returned; its second argument plus
    ``time.monotonic()`` is the robot's clock. It raises ConfigError.
    """

    load: Callable[[Path], BodyConfig]
    create: Callable[[Any, float], RobotLink]


def load_body(path: Path | str) -> Body:
    """Read the body of the file, of any kind. Raises ConfigError (file, line, key)."""
    document = load_yaml(path)
    named = document.data.get("kind", SIMULATED_KIND) if isinstance(document.data, dict) else SIMULATED_KIND
    try:
        kind = body_kind(named)
    except ConfigError as failure:
        raise document.error(f"kind: {failure.message}", ("kind",)) from failure
    return kind.load(Path(path))


def body_kind(name: object) -> BodyKind:
    """The kind of body that the project or a package calls ``name``.

    Raises ConfigError where there is none, naming those there are, or where its package cannot be used.
    """
    kinds = extensions("hbba.bodies")
    extension = kinds.get(str(name))
    if extension is None:
        known = suggestion(str(name), list(kinds))
        raise ConfigError(f"there is no kind of body {name!r}; {known}, and those of a package once it is installed")
    found = extension.load()
    if not isinstance(found, BodyKind):
        raise ConfigError(f"{extension.value} of {extension.distribution} is no BodyKind")
    return found


def standing_streams(body: Body) -> dict[str, StreamDescription]:
    """The streams that every body has."""
    types = {"odometry": Odometry, "joints": JointState, "status": LinkStatus}
    return {
        name: StreamDescription(name, message_type, rate_hz)
        for (name, message_type), rate_hz in zip(types.items(), body.standing_rates_hz, strict=True)
    }


def create_link(body: Body, clock_offset: float) -> RobotLink:
    """The link of ``body``, not yet started; ``clock_offset`` + ``time.monotonic()`` is its clock.

    Raises ConfigError (file, line, key) if its model or its world is wrong.
    """
    return body_kind(body.kind).create(body, clock_offset)


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


def _simulated(config: RobotConfig, clock_offset: float) -> RobotLink:
    robot, world, scenario = simulated_parts(config)
    return SimulatedLink(robot, world, clock_offset, scenario)


def _devices(config: DevicesConfig, clock_offset: float) -> RobotLink:
    from app.robots.devices.link import DevicesLink  # imports sound libraries, which a simulated body does not need

    model = load_model(config.model)
    for device in (config.camera, config.microphones):
        if device is not None and device.link not in model.links:
            raise ConfigError(f"has no link {device.link!r} for a device of {config.name}", str(config.model))
    return DevicesLink(config, model, clock_offset)


def _drivers(config: DriversConfig, clock_offset: float) -> RobotLink:
    from app.robots.drivers.link import DriversLink  # imports sound libraries, too

    return DriversLink(config, load_model(config.model), clock_offset)


def _kinematic(config: KinematicConfig, clock_offset: float) -> RobotLink:
    return create_kinematic(config, RealClock(clock_offset))


def _ros2(config: Ros2Config, clock_offset: float) -> RobotLink:
    return Ros2Link(config, clock_offset)


def create_kinematic(config: KinematicConfig, clock: Clock, *, scenario: ScenarioConfig | None = None) -> KinematicLink:
    """The kinematic body ``config`` on ``clock``, with the people of ``scenario``, or else of the one that its file
    names. Raises ConfigError (file, line, key) if its map or that scenario is wrong."""
    if scenario is None and config.scenario is not None:
        scenario = load_scenario(config.scenario)
    return KinematicLink(config, read_map(config.map), clock, scenario)


def _check_model(robot: RobotConfig) -> None:
    """Raise ConfigError unless the model has the joints and links that the configuration names."""
    model = load_model(robot.model)
    streams = robot.streams
    parts = (streams.kinect, streams.hokuyo, streams.panorama, streams.microphones, robot.loudspeaker)
    sensors = [part.link for part in parts if part is not None]
    for joint in (robot.base.left_wheel_joint, robot.base.right_wheel_joint):
        if joint not in model.joint_names:
            raise ConfigError(f"has no moving joint {joint!r}, a wheel of {robot.name}", str(robot.model))
    for link in sensors:
        if link not in model.links:
            raise ConfigError(f"has no link {link!r} for a sensor of {robot.name}", str(robot.model))
    # Cameras are placed by the joints of each image's instant; these once for all
    fixed = {"laser": streams.hokuyo, "microphones": streams.microphones, "loudspeaker": robot.loudspeaker}
    for what, part in fixed.items():
        if part is not None and (joints := model.moved_by(part.link)):
            raise ConfigError(
                f"moves {part.link!r} by the joint {joints[0]!r}; "
                f"the {what} of a simulated robot must be fixed to its base",
                str(robot.model),
            )
    for link in sensors:
        if kinematic := set(robot.kinematic_joints).intersection(model.moved_by(link)):
            raise ConfigError(
                f"moves {link!r} by the joint {min(kinematic)!r}; a sensor of a simulated robot cannot be on a "
                "joint of a kinematic group",
                str(robot.model),
            )


SIMULATED_KIND = "simulated"
#: The objects that pyproject.toml names, as a package's names its own.
SIMULATED = BodyKind(load_robot_config, _simulated)
DEVICES = BodyKind(load_devices_config, _devices)
KINEMATIC = BodyKind(load_kinematic_config, _kinematic)
DRIVERS = BodyKind(load_drivers_config, _drivers)
ROS2 = BodyKind(load_ros2_config, _ros2)
