"""The program in the simulated lab, without cameras, for tests that dock."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import TypeVar

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import Pose2, wrap_angle
from app.experiments.world_run import WorldRun, run_in_world, with_settings
from app.program.config import Configuration, load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import load_body
from app.robots.simulated.world_config import WorldConfig

T = TypeVar("T")
ME = Source("operator", "a test")
#: The lab's dock in the world: where its plates meet, and where it opens to.
X_WD = Pose2(11.1, 0.3, math.pi / 2)


def in_the_lab(
    start: Pose2,
    script: Callable[[WorldRun], Awaitable[T]],
    *,
    charge: float = 0.5,
    plate_m: float | None = None,
    attempts: int = 3,
    dock: Pose2 = X_WD,
    world: WorldConfig | None = None,
) -> T:
    """Run ``script`` with the robot at ``start`` in the world, its battery at ``charge``; ``plate_m``: how far ahead of
    base_link its charging plate is; ``attempts`` to dock, and ``dock``, where the dock is: by the settings."""
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    body = load_body(configuration.path(configuration.program.robot))
    assert isinstance(body, RobotConfig)
    assert body.battery is not None
    place = body.start.model_copy(update={"x": start.x, "y": start.y, "heading_deg": math.degrees(start.theta)})
    battery = body.battery.model_copy(update={"charge": charge, "plate_m": plate_m or body.battery.plate_m})
    body = body.model_copy(update={"start": place, "scenario": None, "battery": battery})
    X_MD = start.inverse() @ dock
    docking = {"dock": {"x": X_MD.x, "y": X_MD.y, "heading": X_MD.theta}, "attempts": attempts}
    configuration = _by_laser_alone(with_settings(configuration, {"Docking": docking}))
    return run_in_world(configuration, body, script, world=world)


def _by_laser_alone(configuration: Configuration) -> Configuration:
    """The same program, its planner without a camera."""
    modules = dict(configuration.program.modules)
    planner = modules["PlanAndFollowPath"]
    inputs = {port: channel for port, channel in planner.inputs.items() if port != "images"}
    modules["PlanAndFollowPath"] = planner.model_copy(update={"inputs": inputs})
    return replace(configuration, program=configuration.program.model_copy(update={"modules": modules}))


def errors(X_WB: Pose2, docked_m: float = 0.39) -> tuple[float, float, float]:
    """Of a robot at ``X_WB``: how far along the dock's axis (m) and beside it (m) from where it should be docked, and
    how far it is turned (degrees)."""
    X_DB = X_WD.inverse() @ X_WB
    return X_DB.x - docked_m, X_DB.y, math.degrees(wrap_angle(X_DB.theta - math.pi))
