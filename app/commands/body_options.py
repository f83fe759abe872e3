"""Which body a command runs: the program's own, or another that its options name."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.base import paths
from app.commands.packaged import config_file, program_named

if TYPE_CHECKING:
    from app.program.config import Configuration
    from app.robots.devices.config import CameraConfig, SoundInputConfig
    from app.robots.factory import Body


def add_body_options(parser: argparse.ArgumentParser) -> None:
    """The options for a body, its devices and its surroundings."""
    parser.add_argument("--robot", type=Path, metavar="FILE", help="the body to run: a file, or a name as webcam")
    parser.add_argument(
        "--camera", metavar="SOURCE", help="camera of a body of devices: a device number, a video file, or pictures"
    )
    parser.add_argument(
        "--scenario",
        metavar="FILE",
        help="people in the simulated world: a file, a name as walkers, or none",
    )
    parser.add_argument(
        "--microphones", metavar="SOURCE", help="microphones of a body of devices: an input's name, or a sound file"
    )


def chosen(args: argparse.Namespace) -> tuple[Configuration, Body]:
    """The program and the body that ``args`` ask for. Raises ConfigError.

    ``--robot`` alone runs the program which that body's file names, with ``--config`` that program in that body.
    """
    from pydantic import ValidationError

    from app.base.errors import ConfigError
    from app.base.yaml_source import validation_message
    from app.program.config import load_configuration
    from app.robots.config import RobotConfig
    from app.robots.devices.config import DevicesConfig
    from app.robots.factory import load_body

    robot = None if args.robot is None else config_file(args.robot, "robot", "--robot")
    body = None if robot is None else load_body(robot)
    program = program_named(args.config)
    if program is None:
        named = None if body is None else body.program
        program = named or paths.config_dir() / "lab.yaml"
    configuration = load_configuration(program)
    if robot is not None:
        in_it = configuration.program.model_copy(update={"robot": robot.resolve()})
        configuration = replace(configuration, program=in_it)
    if body is None:
        body = load_body(configuration.path(configuration.program.robot))
    if args.scenario is not None:
        if not isinstance(body, RobotConfig):
            raise ConfigError(f"is for the simulated world, and {body.name} is not in it", "--scenario")
        body = body.model_copy(update={"scenario": scenario_file(args.scenario)})
    for option in ("camera", "microphones"):
        source = getattr(args, option)
        if source is None:
            continue
        if not isinstance(body, DevicesConfig):
            raise ConfigError(f"is for a body of devices, and {body.name} is none: --robot webcam", f"--{option}")
        device = getattr(body, option)
        if device is None:
            raise ConfigError(f"{body.name} has no {option} to be replaced", f"--{option}")
        if not Path(source).exists() and _names_a_file(source):
            raise ConfigError(f"there is no file or folder {source}", f"--{option}")
        try:
            device = type(device).model_validate(device.model_dump() | {"source": source})
        except ValidationError as failure:
            (detail,) = failure.errors(include_url=False)
            raise ConfigError(validation_message(type(device), detail), f"--{option}") from None
        _try_file(device, f"--{option}")
        if isinstance(device.source, str) and Path(source).exists():
            device = device.model_copy(update={"source": str(Path(source).resolve())})
        body = body.model_copy(update={option: device})
    if isinstance(body, DevicesConfig):
        file = robot or configuration.path(configuration.program.robot)
        for option in ("camera", "microphones"):
            if getattr(args, option) is None and (device := getattr(body, option)) is not None:
                _try_file(device, f"{file}: {option}.source")
    return configuration, body


def _try_file(device: CameraConfig | SoundInputConfig, where: str) -> None:
    """A device is waited for, a file that cannot be read will not mend. Raises ConfigError."""
    from app.base.errors import ConfigError
    from app.robots.devices.config import CameraConfig
    from app.robots.devices.image_inputs import InputUnavailable, open_pictures
    from app.robots.devices.sound import SOUNDS, open_sound

    path = Path(device.source) if isinstance(device.source, str) else None
    if path is None or not (path.is_file() or path.is_dir()):
        return
    try:
        if isinstance(device, CameraConfig):
            pictures = open_pictures(device.model_copy(update={"loop": False}))
            empty = pictures.read() is None
            pictures.close()
        elif path.is_dir():
            raise InputUnavailable(f"{path} is a folder: name one sound file ({SOUNDS})")
        else:
            sound = open_sound(device)
            empty = sound.read(1) is None
            sound.close()
    except InputUnavailable as failure:
        raise ConfigError(str(failure), where) from None
    if empty:
        raise ConfigError(f"{path} holds no picture that can be read", where)


def _names_a_file(source: str) -> bool:
    """Whether ``source`` can be nothing but a file: neither a device's path nor its name."""
    return not source.startswith("/dev/") and ("/" in source or Path(source).suffix[1:].isalnum())


def scenario_file(named: str) -> Path | None:
    """The file of a scenario given by its path or by its name in ``config/scenarios``; None for "none", an empty world.

    Raises ConfigError.
    """
    return None if named == "none" else config_file(named, "scenario", "--scenario").resolve()


def experiment_scenario(named: str | None) -> Path | None:
    """The file of an experiment's scenario, None for the experiment's own. Raises ConfigError."""
    from app.base.errors import ConfigError
    from app.commands.body_options import scenario_file

    if named is None:
        return None
    file = scenario_file(named)
    if file is None:
        raise ConfigError("an experiment needs a scenario that drives", "--scenario")
    return file
