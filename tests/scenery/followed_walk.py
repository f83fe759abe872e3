"""A person walks through a hall on a kept map and the robot follows, played without physics in virtual time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.attention.desires import Source
from app.base import paths
from app.base.geometry import Pose2, wrap_angle
from app.maps.library import MapLibrary
from app.messages import OccupancyGrid
from app.program.config import load_configuration
from app.rehearsal.play import RehearsalRun, Stage, play
from app.robots.simulated.scenery.scenario_config import PersonConfig, ScenarioConfig, StepConfig

ME = Source("operator", "ada")
_CELL_M, _LOOK_S = 0.05, 0.25
#: Where the person stands at the begin, 1.6 m before the robot, which is at the origin and looks at them.
_BEGIN = (1.6, 0.0)
_LOOKS_S = 4.0


@dataclass(frozen=True, slots=True)
class Moment:
    """All at ``at_s`` (s): the poses of robot and person on the map, the length that the robot has driven (m), what it
    touched so far, and what became of the desire."""

    at_s: float
    robot: Pose2
    person: Pose2
    driven_m: float
    touches: int
    outcome: str | None
    reason: str

    @property
    def distance_m(self) -> float:
        """From middle to middle."""
        return math.dist((self.robot.x, self.robot.y), (self.person.x, self.person.y))

    @property
    def turned_rad(self) -> float:
        """How far the person is aside of where the robot looks."""
        to = math.atan2(self.person.y - self.robot.y, self.person.x - self.robot.x)
        return abs(wrap_angle(to - self.robot.theta))

    @property
    def aside_rad(self) -> float:
        """How far the robot is aside of where the person looks."""
        to = math.atan2(self.robot.y - self.person.y, self.robot.x - self.person.x)
        return abs(wrap_angle(to - self.person.theta))


def hall() -> OccupancyGrid:
    """10 m by 7 m from (-2, -2), with a wall that reaches from below to y = 1.5 m at x = 4."""
    cells = np.zeros((140, 200), np.int8)
    cells[0] = cells[-1] = 100
    cells[:, 0] = cells[:, -1] = 100
    cells[0:70, 120:124] = 100
    return OccupancyGrid(0.0, "map", cells, _CELL_M, origin=(-2.0, -2.0), version=1)


def walk(speed_mps: float, *ways: tuple[float, float] | float) -> tuple[StepConfig, ...]:
    """The script of a person who looks at the robot first, then goes ``ways``: to points (m), or stands so long (s)."""
    steps = (StepConfig(wait=way) if isinstance(way, float) else StepConfig(walk=way, speed=speed_mps) for way in ways)
    return (StepConfig(wait=_LOOKS_S, look="robot"), *steps)


def followed(folder: Path, script: tuple[StepConfig, ...], seconds: float, **params: Any) -> list[Moment]:
    """What becomes of a desire Follow with ``params`` during ``seconds``; the map is kept in ``folder``."""
    maps = MapLibrary(folder)
    maps.keep("hall", hall())
    person = PersonConfig(name="walker", face="visitor", at=_BEGIN, repeat=False, script=script)
    stage = Stage(
        load_configuration(paths.config_dir() / "lab.yaml"),
        maps,
        "hall",
        Pose2(),
        scenario=ScenarioConfig(name="walk", people=(person,)),
        without=("ScenarioCoordinator",),
    )

    async def look(run: RehearsalRun) -> list[Moment]:
        clock, workspace, link = run.system.clock, run.system.workspace, run.link
        desire = workspace.add("Follow", intensity=4, utility=1, params=params, source=ME)
        begin, moments = clock.now(), list[Moment]()
        while (at_s := clock.now() - begin) < seconds:
            actor, report = link.scenario_state.actors[0], workspace.report(desire.id)
            where = Pose2(actor.x, actor.y, actor.heading)
            base = link.base
            moments.append(
                Moment(
                    at_s, base.pose, where, base.driven_m, base.touches, outcome=report.outcome, reason=report.reason
                )
            )
            await clock.sleep(_LOOK_S)
        return moments

    return play(stage, look)
