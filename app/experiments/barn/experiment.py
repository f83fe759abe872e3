"""The BARN worlds crossed one after another, a few at a time, and kept so that a broken run goes on where it ended."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from app.base import compiled, paths
from app.base.errors import ConfigError
from app.experiments.barn.result import WorldResult
from app.experiments.barn.trial import Drive, Trial, cross, desire_goal
from app.experiments.barn.worlds import BarnWorld, Worlds, chosen, load_worlds
from app.experiments.pool import Trials
from app.experiments.results_store import KeptResults, program_digest

Told = Callable[[WorldResult, int, int], None]
"""Told each result as it comes, how many there are, and of how many."""


@dataclass(frozen=True, slots=True)
class BarnPlan:
    """What to run: the ``chosen`` worlds of a file by the program of ``config``, ``jobs`` at a time.

    ``digest`` tells whether it is the same program.
    """

    worlds: Worlds
    chosen: tuple[BarnWorld, ...]
    config: Path
    jobs: int
    digest: str
    seed: int = 1
    overrides: dict[str, dict[str, object]] = field(default_factory=dict)

    def of(self) -> dict[str, object]:
        """What results are of: equal where they may be put together."""
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


def run(what: BarnPlan, kept: KeptResults, told: Told, drive: Drive = desire_goal) -> tuple[WorldResult, ...]:
    """Cross what has not been crossed yet, and return the results of all that is planned, in the plan's order.

    Raises ConfigError, TrialLost, and any mistake of the program's own.
    """
    results = _done(kept, what.chosen)
    left = [world for world in what.chosen if world.name not in results]
    trials = [Trial(what.config, world, what.worlds.max_mps, what.seed, what.overrides) for world in left]
    if trials:
        compiled.make_ready()  # before any child wants it
    for _, result in Trials(functools.partial(cross, drive=drive), trials, what.jobs):
        kept.add(result.document())
        results[result.world] = result
        told(result, len(results), len(what.chosen))
    return tuple(results[world.name] for world in what.chosen)


def done(what: BarnPlan, kept: KeptResults) -> tuple[WorldResult, ...]:
    """The results that are there already, of the worlds planned."""
    return tuple(_done(kept, what.chosen).values())


def _done(kept: KeptResults, worlds: Sequence[BarnWorld]) -> dict[str, WorldResult]:
    wanted = {world.name for world in worlds}
    found = {}
    for document in kept.found:
        try:
            result = WorldResult.of(document)
        except (KeyError, TypeError, ValueError) as failure:
            raise ConfigError(
                f"holds a line that is no result ({failure}); --fresh begins anew", str(kept.file)
            ) from None
        if result.world in wanted:
            found[result.world] = result
    return found
