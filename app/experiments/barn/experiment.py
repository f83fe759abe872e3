"""The BARN experiment: worlds crossed in parallel trials, with stored results so that a broken run can be resumed."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from app.base import compiled, paths
from app.base.errors import ConfigError
from app.experiments.barn.result import WorldResult
from app.experiments.barn.trial import Drive, Trial, cross, desire_goal
from app.experiments.barn.worlds import BarnWorld, Worlds, chosen, load_worlds
from app.experiments.pool import TrialSeries
from app.experiments.results_store import ResultsStore, program_digest, results_in

OnResult = Callable[[WorldResult, int, int], None]
"""OnResult each result as it comes, how many there are, and of how many."""


@dataclass(frozen=True, slots=True)
class BarnPlan:
    """A plan: the ``chosen`` worlds of a file with the program of ``config``, ``jobs`` at a time.

    ``digest``: identifies the program.
    """

    worlds: Worlds
    chosen: tuple[BarnWorld, ...]
    config: Path
    jobs: int
    digest: str
    seed: int = 1
    overrides: dict[str, dict[str, object]] = field(default_factory=dict)

    def of(self) -> dict[str, object]:
        """Identity of the results: results may be combined if it is equal."""
        return {
            "experiment": "barn",
            "worlds": self.worlds.digest,
            "program": str(self.config.resolve()),
            "files": self.digest,
            "version": paths.version(),
            "seed": self.seed,
            "overrides": self.overrides,
        }


def plan(
    worlds: Path,
    only: str | None = None,
    config: Path | None = None,
    *,
    jobs: int = 1,
    seed: int = 1,
    overrides: dict[str, dict[str, object]] | None = None,
) -> BarnPlan:
    """Read everything. Raises ConfigError."""
    file = load_worlds(worlds)
    config = config or paths.config_dir() / "jackal.yaml"
    if not config.is_file():
        raise ConfigError("there is no such file", str(config))
    return BarnPlan(
        file,
        chosen(file, only),
        config=config,
        jobs=jobs,
        digest=program_digest(config),
        seed=seed,
        overrides=overrides or {},
    )


def run(what: BarnPlan, kept: ResultsStore, on_result: OnResult, drive: Drive = desire_goal) -> tuple[WorldResult, ...]:
    """Run the worlds without a result, and return the results of the whole plan, in its order.

    Raises ConfigError, TrialLost, and any programming error.
    """
    results = {result.world: result for result in done(what, kept)}
    left = [world for world in what.chosen if world.name not in results]
    trials = [Trial(what.config, world, what.worlds.max_mps, what.seed, what.overrides) for world in left]
    if trials:
        compiled.make_ready()  # before the children start
    for _, result in TrialSeries(functools.partial(_cross, drive=drive), trials, what.jobs):
        kept.add(result.document())
        results[result.world] = result
        on_result(result, len(results), len(what.chosen))
    return tuple(results[world.name] for world in what.chosen)


def _cross(trial: Trial, give: Callable[[WorldResult], None], *, drive: Drive) -> None:
    give(cross(trial, drive))


def done(what: BarnPlan, kept: ResultsStore) -> tuple[WorldResult, ...]:
    """The stored results of the planned worlds, the last of each. Raises ConfigError for a line that is none."""
    wanted = {world.name for world in what.chosen}
    found = {result.world: result for result in results_in(kept, WorldResult)}
    return tuple(result for world, result in found.items() if world in wanted)
