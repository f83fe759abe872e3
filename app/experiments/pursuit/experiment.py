"""The pursuit study: every condition with every seed, in processes, with stored results for resuming."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.base import compiled, paths
from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.experiments.pool import TrialSeries
from app.experiments.pursuit.courses import course_of
from app.experiments.pursuit.pursuit_run import DRIVING, HEAD_PAN, MAP, PursuitRun, work
from app.experiments.pursuit.result import Condition, PursuitResult, Task
from app.experiments.results_store import ResultsStore, program_digest, results_in
from app.experiments.simulated import simulated_body
from app.experiments.tour.laboratory import drawn
from app.maps.library import MapLibrary
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import simulated_parts
from app.robots.simulated.world_config import WorldConfig

#: Round trips (ms) with their jitter (ms).
DELAYS_MS = ((0.0, 0.0), (150.0, 0.0), (300.0, 50.0))
TASKS: tuple[Task, ...] = ("follow", "course")

OnResult = Callable[[PursuitResult, int, int], None]


@dataclass(frozen=True, slots=True)
class PursuitPlan:
    """A plan: the ``conditions``, each with ``runs`` seeds from ``seed`` on, for the program of ``config``."""

    config: Path
    robot: RobotConfig
    world: WorldConfig
    conditions: tuple[Condition, ...]
    runs: int
    seed: int
    jobs: int
    digest: str

    @property
    def total(self) -> int:
        """How many runs these are."""
        return len(self.conditions) * self.runs

    def of(self) -> dict[str, object]:
        """Identity of the results: results may be combined if it is equal."""
        return {"experiment": "pursuit", "program": str(self.config.resolve()), "digest": self.digest}

    def trials(self, maps: Path) -> tuple[PursuitRun, ...]:
        """All of them, seed by seed."""
        seeds = range(self.seed, self.seed + self.runs)
        return tuple(
            PursuitRun(self.config, maps, condition, course_of(seed), seed)
            for seed in seeds
            for condition in self.conditions
        )


def conditions_of(tasks: Sequence[Task] = TASKS) -> tuple[Condition, ...]:
    """Both modes and all delays, measured and predicted; a course is driven in Mode 1 alone."""
    return tuple(
        Condition(task, mode, delay_ms, jitter_ms, prediction)
        for task in tasks
        for mode in ((1, 2) if task == "follow" else (1,))
        for delay_ms, jitter_ms in DELAYS_MS
        for prediction in (False, True)
    )


def plan(
    runs: int = 3, seed: int = 1, config: Path | None = None, *, tasks: Sequence[Task] = TASKS, jobs: int = 1
) -> PursuitPlan:
    """Read everything. Raises ConfigError."""
    config = config or paths.config_dir() / "lab.yaml"
    configuration = load_configuration(config)
    body = simulated_body(configuration).model_copy(update={"scenario": None})
    if not set(DRIVING) <= set(configuration.program.modules):
        raise ConfigError(f"the study needs a program with {', '.join(DRIVING)}", str(config))
    robot, world, _ = simulated_parts(body)
    if not any(joint == HEAD_PAN for group in robot.actuators.values() for joint in group.joints):
        raise ConfigError(f"this robot's head has no {HEAD_PAN}: it cannot follow the view", str(config))
    return PursuitPlan(
        config,
        robot,
        world,
        conditions=conditions_of(tasks),
        runs=runs,
        seed=seed,
        jobs=jobs,
        digest=program_digest(config),
    )


def run(what: PursuitPlan, kept: ResultsStore, on_result: OnResult) -> tuple[PursuitResult, ...]:
    """Run what has no result; returns the results of the whole plan, in its order.

    Raises ConfigError, TrialLost, OSError, and any programming error.
    """
    results = {(each.condition, each.seed): each for each in done(what, kept)}
    maps = kept.file.parent / "maps"
    planned = what.trials(maps)
    left = [trial for trial in planned if (trial.condition, trial.seed) not in results]
    if left:
        compiled.make_ready()  # before the children start
        # The map's frame is the world's, in which courses are given.
        MapLibrary(maps).keep(MAP, drawn(what.world, what.robot, Pose2()))
    for _, result in TrialSeries(work, left, what.jobs):
        kept.add(result.document())
        results[result.condition, result.seed] = result
        on_result(result, len(results), what.total)
    return tuple(results[trial.condition, trial.seed] for trial in planned)


def done(what: PursuitPlan, kept: ResultsStore) -> tuple[PursuitResult, ...]:
    """The stored results of the plan. Raises ConfigError for a line that is none."""
    wanted = {(trial.condition, trial.seed) for trial in what.trials(kept.file.parent)}
    found = {(result.condition, result.seed): result for result in results_in(kept, PursuitResult)}
    return tuple(result for key, result in found.items() if key in wanted)
