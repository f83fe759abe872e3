"""``hbba experiment barn``: worlds of the BARN challenge, crossed by the robot on its own."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.arguments import add_results_options, whole
from app.commands.experiment import open_results
from app.commands.output import print_json
from app.commands.packaged import program_named

if TYPE_CHECKING:
    from app.experiments.barn.experiment import BarnPlan
    from app.experiments.barn.result import WorldResult
    from app.experiments.results_store import ResultsStore


def add_parser(experiments: Any) -> None:
    parser = experiments.add_parser(
        "barn",
        help="worlds of the BARN challenge, crossed by the robot on its own",
        description="Let the robot of a program (default: the Jackal) cross the worlds of the BARN challenge, each "
        "mapped, planned and driven in virtual time, a few at a time. Results are kept while it goes on: started "
        "again after Ctrl-C it goes on where it ended.",
    )
    parser.add_argument(
        "--worlds",
        type=Path,
        metavar="FILE",
        help="the worlds, JSON (default: barn/worlds.json of the reference data)",
    )
    parser.add_argument("--only", metavar="IDS", help="these worlds alone, for example 1,5,10-20")
    parser.add_argument("--config", type=Path, metavar="FILE", help="the program: a file, or a name (default: jackal)")
    parser.add_argument("--controller", metavar="NAME", help="how paths are followed (default: as configured)")
    parser.add_argument("--seed", type=whole(0), default=1, metavar="S", help="of the robot's noise (default 1)")
    add_results_options(parser, "worlds")
    parser.add_argument("--plot", action="append", default=[], metavar="ID", help="draw this world and the way driven")


def run(args: argparse.Namespace) -> int:
    from app.experiments.barn.experiment import done, plan
    from app.experiments.barn.experiment import run as run_worlds

    program = program_named(args.config)  # a mistyped name is reported also where no worlds are
    what = plan(
        args.worlds or _default_worlds(),
        args.only,
        program,
        jobs=args.jobs or os.cpu_count() or 1,
        seed=args.seed,
        overrides=_controller(args.controller),
    )
    for named in args.plot:
        if named not in {world.name for world in what.chosen}:
            raise ConfigError(f"world {named!r} is not among those to run", "--plot")
    kept = open_results(args, what.of())
    before = done(what, kept)
    if before:
        print(f"hbba experiment barn: {len(before)} of {len(what.chosen)} worlds are done already", file=sys.stderr)
    results = _run_shown(what, kept, before, run_worlds)
    _report(args, what, kept, results)
    return 0


def _run_shown(what: BarnPlan, kept: ResultsStore, before: tuple[WorldResult, ...], run_worlds: Any) -> Any:
    from app.base import logging_setup
    from app.commands.progress import shown

    logging_setup.configure("warning", as_json=False)
    counts: dict[str, int] = {}
    for result in before:
        counts[result.outcome] = counts.get(result.outcome, 0) + 1
    with shown("crossing") as progress:

        def finished(result: WorldResult, number: int, total: int) -> None:
            counts[result.outcome] = counts.get(result.outcome, 0) + 1
            so_far = ", ".join(f"{count} {outcome}" for outcome, count in counts.items())
            progress(number, total, f"{so_far}; world {result.world}: {result.outcome}, {result.time_s:.1f} s")

        return run_worlds(what, kept, finished)


def _report(args: argparse.Namespace, what: BarnPlan, kept: ResultsStore, results: tuple[WorldResult, ...]) -> None:
    from app.base.yaml_source import load_yaml
    from app.experiments.barn.report import failures, plot, table
    from app.experiments.barn.result import BarnSummary
    from app.robots.factory import load_body

    rows = [result.document() for result in results]
    if args.json:
        print_json({"of": what.of(), "summary": BarnSummary.of(results).document(), "worlds": rows})
    else:
        print("\n\n".join(filter(None, (table(results), "\n".join(failures(results))))))
    for named in args.plot:
        (world,) = (world for world in what.chosen if world.name == named)
        (result,) = (result for result in results if result.world == named)
        body = load_body(what.config.resolve().parent / load_yaml(what.config).data["robot"])
        picture = kept.file.with_name(f"world_{named}.png")
        plot(world, result, getattr(body, "footprint", ()), picture)
        print(f"drawn: {picture}", file=sys.stderr)
    print(f"kept: {kept.file}", file=sys.stderr)


def _controller(named: str | None) -> dict[str, dict[str, object]]:
    """The settings given by ``--controller``. Raises ConfigError."""
    from app.base.yaml_source import suggestion
    from app.modules.behaviors.navigation.tracking.control_cycle import CONTROLLERS

    if named is None:
        return {}
    if named not in CONTROLLERS:
        raise ConfigError(f"there is no controller {named!r}; {suggestion(named, CONTROLLERS)}", "--controller")
    return {"PlanAndFollowPath": {"controller": named}}


def _default_worlds() -> Path:
    from app.base import paths

    named = os.environ.get("HBBA_REFERENCE_DATA")
    checkout = paths.checkout_dir()
    folders = [Path(named)] if named else [checkout.parent / "shared" / "data"] if checkout is not None else []
    for folder in folders:
        if (file := folder / "barn" / "worlds.json").is_file():
            return file
    raise ConfigError(
        "no worlds are at hand: name a file, or the folder of reference data in $HBBA_REFERENCE_DATA", "--worlds"
    )
