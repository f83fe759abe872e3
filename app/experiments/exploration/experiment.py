"""The experiment: one desire to explore in a simulated world, until it ends; the map beside the ground truth."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Source
from app.base import compiled, paths
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.experiments.goals.goal_run import UNCONCERNED, body_in, seeing
from app.experiments.goals.reachable_floor import CELL_M, ReachableFloor, survey
from app.experiments.world_run import WorldRun, run_in_world
from app.maps.place_checks import inscribed_radius_m
from app.messages import OccupancyGrid
from app.program.config import load_configuration
from app.robots.factory import simulated_parts

#: Exploring is given up after so long (s).
PATIENCE_S = 1800.0
_LOOK_S, _LOOKS_S = 0.5, 10.0
#: Room (m) around the body where it counts as able to stand.
_SPARE_M = 0.05
_EXPERIMENT = Source("operator", "the experiment")


@dataclass(frozen=True, slots=True)
class Look:
    """What was known at one time: ``time_s`` since the desire, ``driven_m`` until then, ``share`` of the floor."""

    time_s: float
    driven_m: float
    share: float


@dataclass(frozen=True, slots=True)
class ExplorationResult:
    """How exploring went.

    ``share``: of the floor that the body can stand on and get to, by the world's own shapes, how much the map has as
    free. ``outcome`` and ``reason``: the report on the desire; "late" where it was given up. ``touched``: what the body
    touched. ``looks``: every ten seconds.
    """

    outcome: str
    reason: str
    time_s: float
    driven_m: float
    floor_m2: float
    share: float
    touched: tuple[str, ...]
    looks: tuple[Look, ...]


@dataclass(frozen=True, slots=True)
class ExplorationPlan:
    """The program of ``config``, in its world with the people of ``scenario`` (None: no people)."""

    config: Path
    scenario: Path | None
    patience_s: float = PATIENCE_S


def plan(config: Path | None, scenario: Path | None, *, patience_s: float = PATIENCE_S) -> ExplorationPlan:
    """Read everything. Raises ConfigError."""
    config = config or paths.config_dir() / "lab.yaml"
    if "Curiosity" not in load_configuration(config).program.modules:
        raise ConfigError("this program does not explore: it has no module Curiosity", str(config))
    simulated_parts(body_in(config, scenario))
    return ExplorationPlan(config, scenario, patience_s)


def run(what: ExplorationPlan, progress: Callable[[float], None]) -> ExplorationResult:
    """Run it in virtual time; ``progress(share)`` is called with the share of the floor that is known.

    Raises ConfigError, and any programming error.
    """
    compiled.make_ready()
    body = seeing(body_in(what.config, what.scenario))
    floor = survey(simulated_parts(body)[1], body)
    radius_m = inscribed_radius_m(body.footprint) + _SPARE_M

    async def script(world: WorldRun) -> ExplorationResult:
        return await _explore(world, floor, radius_m, what.patience_s, progress)

    cameras = body.streams.kinect is not None
    return run_in_world(load_configuration(what.config), body, script, cameras=cameras, without=UNCONCERNED)


def document(result: ExplorationResult) -> dict[str, Any]:
    """The result as JSON values."""
    return asdict(result)


def table(result: ExplorationResult) -> str:
    """The result as a Markdown table."""
    rows = [
        ("outcome", f"{result.outcome}: {result.reason}" if result.reason else result.outcome),
        ("floor it can get to, m²", f"{result.floor_m2:.0f}"),
        ("of it mapped", f"{100 * result.share:.1f} %"),
        ("time, s", f"{result.time_s:.0f}"),
        *((f"until {part} % were mapped, s", _time_of(result, part)) for part in (50, 90, 99)),
        ("driven, m", f"{result.driven_m:.1f}"),
        ("touched", ", ".join(result.touched) or "nothing"),
    ]
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)])


def _time_of(result: ExplorationResult, part: int) -> str:
    return next((f"{look.time_s:.0f}" for look in result.looks if 100 * look.share >= part), "–")


def known_share(floor: ReachableFloor, cells: NDArray[np.bool_], grid: OccupancyGrid, X_WM: Pose2) -> float:
    """Of ``cells`` of the ``floor`` the share that ``grid``, whose origin is at ``X_WM`` in the world, has as free."""
    rows, columns = np.nonzero(cells)
    x, y = (columns + 0.5) * CELL_M - X_WM.x, (rows + 0.5) * CELL_M - X_WM.y
    cosine, sine = math.cos(X_WM.theta), math.sin(X_WM.theta)
    on_map = np.stack((cosine * x + sine * y, cosine * y - sine * x), axis=1)
    at = np.floor((on_map - np.array(grid.origin)) / grid.resolution_m).astype(np.int64)
    width, height = grid.cells.shape[1], grid.cells.shape[0]
    inside = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    found = grid.cells[at[inside, 1], at[inside, 0]]
    return float(np.count_nonzero((found >= 0) & (found < 50))) / max(rows.size, 1)


async def _explore(
    run: WorldRun, floor: ReachableFloor, radius_m: float, patience_s: float, progress: Callable[[float], None]
) -> ExplorationResult:
    system, clock, start = run.system, run.system.clock, run.link.true_pose()
    cells, channel = floor.reachable(start, radius_m), system.graph.channels["map"]

    def share() -> float:
        return 0.0 if channel.latest is None else known_share(floor, cells, channel.latest, start)

    desire = system.workspace.add("Explore", intensity=5, utility=1, source=_EXPERIMENT)
    began, last, driven_m = clock.now(), start, 0.0
    looks: list[Look] = []
    while system.workspace.report(desire.id).ended is None and clock.now() - began < patience_s:
        await clock.sleep(_LOOK_S)
        pose = run.link.true_pose()
        driven_m += math.dist((pose.x, pose.y), (last.x, last.y))
        last = pose
        if clock.now() - began >= _LOOKS_S * (len(looks) + 1):
            looks.append(Look(round(clock.now() - began, 1), round(driven_m, 2), round(share(), 4)))
            progress(looks[-1].share)
    report = system.workspace.report(desire.id)
    return ExplorationResult(
        outcome="late" if report.ended is None else str(report.outcome),
        reason=report.reason,
        time_s=round(clock.now() - began, 1),
        driven_m=round(driven_m, 1),
        floor_m2=round(float(np.count_nonzero(cells)) * CELL_M**2, 1),
        share=round(share(), 4),
        touched=tuple(contact.what for contact in run.link.contacts),
        looks=tuple(looks),
    )
