"""Viewers of others beside the console: the option that serves them."""

from __future__ import annotations

import argparse
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

from app.base.errors import ConfigError
from app.commands.arguments import whole
from app.logs.ros.live.graph import MISSING

if TYPE_CHECKING:
    from app.program.config import Configuration

#: The name of the module, beside those that the configuration names.
NAME = "FoxgloveServer"
_CLASS = "app.modules.viewers.foxglove_server:FoxgloveServer"
_HOST = "127.0.0.1"
#: What viewers try first.
_PORT = 8765


_ROS2 = "Ros2Server"
_ROS2_CLASS = "app.modules.viewers.ros2.server:Ros2Server"


def add_viewer_options(parser: argparse.ArgumentParser) -> None:
    """The options that serve Foxglove and Lichtblick, and ROS 2."""
    parser.add_argument(
        "--foxglove",
        type=whole(0, 65535),
        nargs="?",
        const=_PORT,
        metavar="PORT",
        help=f"serve Foxglove and Lichtblick on this computer, without login (default port {_PORT}; 0: any free one)",
    )
    parser.add_argument(
        "--ros2",
        choices=("topics", "commands"),
        nargs="?",
        const="topics",
        help="be in the graph of ROS 2: with topics of what the robot knows; commands: and take desires and goals from "
        "there, which knows no login",
    )


def with_ros2(configuration: Configuration, offered: str | None) -> Configuration:
    """``configuration`` in the graph of ROS 2, with its ``topics`` or ``commands``, too; itself for None.

    A program that names the module keeps its settings. Raises ConfigError where ROS 2 is not installed.
    """
    if offered is None:
        return configuration
    if find_spec("rclpy") is None:
        raise ConfigError(MISSING, "--ros2")
    from app.runtime.graph import ModuleSpec

    program = configuration.program
    known = program.modules.get(_ROS2)
    settings = {**({} if known is None else known.settings), "commands": offered == "commands"}
    spec = ModuleSpec.model_validate({"class": _ROS2_CLASS, "settings": settings})
    return replace(configuration, program=program.model_copy(update={"modules": {**program.modules, _ROS2: spec}}))


def with_viewers(configuration: Configuration, port: int | None) -> Configuration:
    """``configuration`` with the server for viewers on ``port``; itself for None.

    Raises ConfigError where the server's package is not installed or the port is taken.
    """
    if port is None:
        return configuration
    if find_spec("foxglove") is None:
        raise ConfigError("viewers need the package foxglove-sdk: pip install 'hbba[foxglove]'", "--foxglove")
    from app.console.server import listen
    from app.runtime.graph import ModuleSpec

    listen(_HOST, port, "--foxglove").close()
    program = configuration.program
    spec = ModuleSpec.model_validate({"class": _CLASS, "settings": {"port": port}})
    modules = {**{name: each for name, each in program.modules.items() if name != NAME}, NAME: spec}
    return replace(configuration, program=program.model_copy(update={"modules": modules}))
