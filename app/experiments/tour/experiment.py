"""The tour experiment: runs of one tour with different seeds, in processes, with stored results for resuming."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from app.base import compiled, paths
from app.base.errors import ConfigError
from app.experiments.pool import TrialSeries
from app.experiments.results_store import ResultsStore, program_digest, results_in
from app.experiments.simulated import simulated_body
from app.experiments.tour import laboratory
from app.experiments.tour.result import TourResult
from app.experiments.tour.tour_run import TourRun, work
from app.maps.library import MapLibrary
from app.program.config import load_configuration
from app.robots.config import RobotConfig
from app.robots.factory import simulated_parts
from app.robots.simulated.world_config import WorldConfig
from app.tours.model import Tour
from app.tours.tour_file import digest, tour_text

OnResult = Callable[[TourResult, int, int], None]


@dataclass(frozen=True, slots=True)
class TourPlan:
    """A plan: ``runs`` of ``tour`` with the seeds from ``seed`` on, led by the program of ``config`` in ``world``."""

    config: Path
    tour: Tour
    robot: RobotConfig
    world: WorldConfig
    runs: int
    seed: int
    jobs: int
    digest: str

    @property
    def seeds(self) -> range:
        """One a run."""
        return range(self.seed, self.seed + self.runs)

    def of(self) -> dict[str, object]:
        """Identity of the results: results may be combined if it is equal."""
        return {
            "experiment": "tour",
            "program": str(self.config.resolve()),
            "digest": self.digest,
            "tour": self.tour.id,
            "tour_digest": digest(self.tour),
        }


def plan(tour: Tour, runs: int = 10, seed: int = 1, config: Path | None = None, *, jobs: int = 1) -> TourPlan:
    """Read everything. Raises ConfigError."""
    config = config or paths.config_dir() / "lab.yaml"
    body = simulated_body(load_configuration(config)).model_copy(update={"scenario": None})
    robot, world, _ = simulated_parts(body)
    known = [place.id for place in laboratory.places(world.posters, laboratory.origin_of(robot))]
    named = [stop.place for stop in tour.stops if not stop.left_out]
    missing = [place for place in (*named, *filter(None, [tour.home])) if place not in known]
    if missing or not named:
        lacks = f"no place {missing[0]}" if missing else "no stop"
        raise ConfigError(
            f"the tour {tour.id} has {lacks}; before the posters of the world there are: {_listed(known)}"
        )
    return TourPlan(config, tour, robot, world, runs=runs, seed=seed, jobs=jobs, digest=program_digest(config))


def run(what: TourPlan, kept: ResultsStore, on_result: OnResult) -> tuple[TourResult, ...]:
    """Run what has no result; returns the results of the whole plan, by seed.

    Raises ConfigError, TrialLost, OSError, and any programming error.
    """
    results = {result.seed: result for result in done(what, kept)}
    maps = kept.file.parent / "maps"
    trials = [TourRun(what.config, tour_text(what.tour), maps, seed) for seed in what.seeds if seed not in results]
    if trials:
        compiled.make_ready()  # before the children start
        laboratory.keep(MapLibrary(maps), what.tour.map, what.world, what.robot)
    for _, result in TrialSeries(work, trials, what.jobs):
        kept.add(result.document())
        results[result.seed] = result
        on_result(result, len(results), what.runs)
    return tuple(results[seed] for seed in what.seeds)


def done(what: TourPlan, kept: ResultsStore) -> tuple[TourResult, ...]:
    """The stored results of the plan. Raises ConfigError for a line that is none."""
    found = {result.seed: result for result in results_in(kept, TourResult)}
    return tuple(result for seed, result in found.items() if seed in what.seeds)


def _listed(names: list[str]) -> str:
    return ", ".join(names) or "none"
