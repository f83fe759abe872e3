"""The goals experiment: random goals in the lab among people, in runs of several, with stored results for resuming."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.base import compiled, paths
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.experiments.goals.goal_run import MAP, GoalRun, body_in, seeing, work
from app.experiments.goals.reachable_floor import survey
from app.experiments.goals.result import GoalResult
from app.experiments.goals.tour import Tour, drive
from app.experiments.pool import TrialSeries
from app.experiments.results_store import ResultsStore, program_digest, results_in
from app.program.config import load_configuration
from app.robots.factory import simulated_parts

#: Goals per run, given one after another to one instance of the program; runs are parallel. An interrupted run restarts
#: from its begin, so that its results equal those of an uninterrupted one.
SHIFT_GOALS = 5
#: Least clearance (m) of a goal beyond the robot's outermost corner, and least distance (m) from the goal before.
SPARE_M, LEAST_M = 0.12, 2.0
TOLERANCE_M, TOLERANCE_RAD, SLACK_M = 0.25, 0.2, 0.05
PATIENCE_S = 300.0

OnResult = Callable[[GoalResult, int, int], None]


@dataclass(frozen=True, slots=True)
class GoalsPlan:
    """A plan: ``count`` goals, drawn from ``seed``, for the program of ``config`` among people (``scenario``)."""

    config: Path
    scenario: Path
    tour: Path
    count: int
    seed: int
    jobs: int
    cameras: bool
    digest: str

    def of(self) -> dict[str, object]:
        """Identity of the results: results may be combined if it is equal. A larger count continues the same sequence
        of goals."""
        return {
            "experiment": "goals",
            "program": str(self.config.resolve()),
            "scenario": str(self.scenario.resolve()),
            "digest": self.digest,
            "seed": self.seed,
            "cameras": self.cameras,
        }


def plan(
    count: int = 100,
    seed: int = 1,
    config: Path | None = None,
    scenario: Path | None = None,
    *,
    jobs: int = 1,
    cameras: bool = True,
) -> GoalsPlan:
    """Read everything. Raises ConfigError."""
    folder = paths.config_dir()
    config = config or folder / "lab.yaml"
    scenario = (scenario or folder / "scenarios" / "walkers.yaml").resolve()
    program = load_configuration(config).program
    if not {"SLAM2D", "MobileBaseControl"} <= set(program.modules):
        raise ConfigError(
            "this program makes no maps or drives nothing: it needs SLAM2D and MobileBaseControl", str(config)
        )
    simulated_parts(body_in(config, scenario))
    tour = folder / "scenarios" / "mapping.yaml"
    return GoalsPlan(
        config, scenario, tour=tour, count=count, seed=seed, jobs=jobs, cameras=cameras, digest=program_digest(config)
    )


def run(
    what: GoalsPlan, kept: ResultsStore, on_result: OnResult, began: Callable[[str], None]
) -> tuple[GoalResult, ...]:
    """Run the goals without a result; returns the results of the whole plan, by number.

    ``began(text)`` is called at the begin of each long step. Raises ConfigError, TrialLost, ScriptBlocked,
    MapUnavailable, and any programming error.
    """
    results = {result.number: result for result in done(what, kept)}
    if len(results) < what.count:
        compiled.make_ready()  # before the children start
    maps = kept.file.parent / "maps"
    if len(results) < what.count and (kept.moved or not (maps / MAP).is_dir()):
        # An interrupted tour restarts: its map is of another program.
        shutil.rmtree(maps / MAP, ignore_errors=True)
        maps.mkdir(exist_ok=True)
        for _, leg in TrialSeries(drive, [Tour(what.config, what.tour, maps, what.cameras)], 1):
            began(leg)
    goal_runs = [
        goal_run for goal_run in _goal_runs(what, maps) if any(number not in results for number, _ in goal_run.goals)
    ]
    began("going to goals")
    for _, result in TrialSeries(work, goal_runs, what.jobs):
        if result.number in results:
            continue
        kept.add(result.document())
        results[result.number] = result
        on_result(result, len(results), what.count)
    return tuple(results[number] for number in range(1, what.count + 1))


def done(what: GoalsPlan, kept: ResultsStore) -> tuple[GoalResult, ...]:
    """The stored results of the planned goals, the last of each. Raises ConfigError for a line that is none."""
    found = {result.number: result for result in results_in(kept, GoalResult)}
    return tuple(result for number, result in found.items() if number <= what.count)


def _goal_runs(what: GoalsPlan, maps: Path) -> list[GoalRun]:
    """Every goal of the plan, in runs; each run begins at the robot's usual start pose."""
    body, world, _ = simulated_parts(seeing(body_in(what.config, what.scenario)))
    origin = Pose2(body.start.x, body.start.y, np.deg2rad(body.start.heading_deg))
    ground = survey(world, body)
    reach = max(float(np.hypot(x, y)) for x, y in body.footprint)
    cells = ground.reachable(origin, reach + SPARE_M)
    goal_runs = []
    for number in range(0, what.count, SHIFT_GOALS):
        rng = np.random.default_rng([what.seed, number])
        drawn = ground.draw(cells, SHIFT_GOALS, origin, LEAST_M, rng)[: what.count - number]
        goal_runs.append(
            GoalRun(
                config=what.config,
                scenario=what.scenario,
                maps=maps,
                origin=origin,
                start=origin,
                goals=tuple(enumerate(drawn, number + 1)),
                seed=what.seed + number,
                cameras=what.cameras,
                tolerance_m=TOLERANCE_M,
                tolerance_rad=TOLERANCE_RAD,
                slack_m=SLACK_M,
                patience_s=PATIENCE_S,
            )
        )
    return goal_runs
