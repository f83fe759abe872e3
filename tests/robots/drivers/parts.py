"""A robot of parts in a process of its own, whose ports go wrong as a test asks."""

from __future__ import annotations

import asyncio
import os
import socket
import sys
from pathlib import Path
from typing import Any

import yaml

from app.base import paths
from app.base.child_processes import python
from app.base.kinematic_model import load_model
from app.robots.drivers.config import DriversConfig, load_drivers_config
from app.robots.drivers.link import DriversLink
from app.runtime.clock import RealClock
from tests.patience import PATIENCE_S
from tests.robots.played import Driver, PlayedRobot

SHIPPED = paths.config_dir() / "robots" / "serial_base.yaml"


def free_port() -> int:
    """A TCP port that nothing listens on."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        return int(found.getsockname()[1])


def body_file(folder: Path, **changes: Any) -> Path:
    """The body as shipped, with ports in ``folder`` and ``changes``."""
    text = yaml.safe_load(SHIPPED.read_text("utf-8"))
    text["model"] = str(SHIPPED.parent / text["model"])
    text["program"] = str((SHIPPED.parent / text["program"]).resolve())
    text["base"]["port"] = str(folder / "base")
    text["hokuyo"]["port"] = f"tcp://127.0.0.1:{free_port()}"
    text["gamepad"]["port"] = str(folder / "gamepad")
    text["found_within_s"] = PATIENCE_S
    path = folder / "robot.yaml"
    path.write_text(yaml.safe_dump(text | changes), "utf-8")
    return path


class Robot(PlayedRobot):
    """The robot of ``file``, in the room."""

    def __init__(self, file: Path, *options: str) -> None:
        self.file = file
        self.config: DriversConfig = load_drivers_config(file)
        log = file.parent / "robot.log"
        command = python(
            *("-m", "app.robots.simulated.parts.player", "--robot", str(file), "--faults", "--scan-hz", "10"),
            *("--log", str(log), *options),
        )
        super().__init__(command, log, dict(os.environ))


class PartsDriver(Driver):
    """A driven link to a robot of parts; ``parts`` is the same as ``link``."""

    def __init__(self, config: DriversConfig) -> None:
        clock = RealClock()
        self.parts = DriversLink(config, load_model(config.model), clock.offset)
        super().__init__(self.parts, clock)


if __name__ == "__main__":  # a program that drives, to be frozen and killed

    async def main(file: Path) -> None:
        """Drive for as long as it is let."""
        async with PartsDriver(load_drivers_config(file)) as driver:
            await driver.set_out()
            print("driving", driver.parts.process_id, flush=True)
            await asyncio.Event().wait()

    asyncio.run(main(Path(sys.argv[1])))
