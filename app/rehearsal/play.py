"""A program played on a kept map in virtual time: as fast as the computer can, and the same each time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from app.base.geometry import Pose2
from app.maps.library import MAP, MapLibrary
from app.program.beside import run_beside
from app.program.config import Configuration
from app.program.system import System
from app.rehearsal.configuration import rehearsed
from app.robots.config import BodyConfig, StartPose
from app.robots.factory import create_kinematic, load_body
from app.robots.simulated.kinematic.config import KinematicConfig, kinematic_of
from app.robots.simulated.kinematic.link import KinematicLink
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.runtime.clock import VirtualClock, run_virtual
from app.tours.run_library import RunLibrary

T = TypeVar("T")

PATIENCE_S = 600.0
"""Real seconds for results of threads; only beyond it a rehearsal depends on the computer."""
ORIGIN = 1_000_000.0
"""The robot's clock (s) at the begin."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Where a rehearsal is played: the program ``configuration``, on the map ``map_name`` of ``maps``, from ``start``
    (``X_MB``), among the people of ``scenario``; reports of tours are kept in ``runs`` (None: the user's).

    ``noise_m``: standard deviation of the laser's distances (m), drawn by the scenario's seed."""

    configuration: Configuration
    maps: MapLibrary
    map_name: str
    start: Pose2
    scenario: ScenarioConfig | None = None
    runs: RunLibrary | None = None
    without: Collection[str] = ()
    noise_m: float = 0.0


@dataclass(frozen=True, slots=True)
class RehearsalRun:
    """A rehearsal under way: all of its program, and its body."""

    system: System
    link: KinematicLink


def play(stage: Stage, script: Callable[[RehearsalRun], Awaitable[T]]) -> T:
    """Run the program with ``script`` beside it, in virtual time, and return what that returns; not on an event loop.

    Raises what the script raises, ConfigError and MapUnavailable, and what ended the program if it ended before.
    """
    clock = VirtualClock(ORIGIN)
    configuration = stage.configuration
    body = _body(stage, load_body(configuration.path(configuration.program.robot)))
    link = create_kinematic(body, clock, scenario=stage.scenario)
    numbers = itertools.count(1)
    system = System(
        rehearsed(configuration, link.description, stage.map_name, stage.without),
        link=link,
        body=body,
        clock=clock,
        maps=stage.maps,
        runs=stage.runs,
        new_id=lambda: f"d{next(numbers)}",
        partial=True,
        reproducible=True,
    )
    return run_virtual(run_beside(system, partial(script, RehearsalRun(system, link))), patience_s=PATIENCE_S)


def _body(stage: Stage, body: BodyConfig) -> KinematicConfig:
    start = StartPose(x=stage.start.x, y=stage.start.y, heading_deg=math.degrees(stage.start.theta))
    config = kinematic_of(body, stage.maps.existing(stage.map_name) / MAP, start)
    if config.laser is None or not stage.noise_m:
        return config
    return config.model_copy(update={"laser": config.laser.model_copy(update={"noise_m": stage.noise_m})})
