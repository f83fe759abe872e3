"""``hbba experiment pursuit``: a person is followed, and a course driven, over a link with delay."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.arguments import add_config, add_results_options, whole
from app.commands.experiment import open_results
from app.commands.output import print_json
from app.commands.packaged import program_named

if TYPE_CHECKING:
    from app.experiments.pursuit.experiment import PursuitPlan
    from app.experiments.pursuit.result import PursuitResult


def add_parser(experiments: Any) -> None:
    """Declare ``hbba experiment pursuit``."""
    parser = experiments.add_parser(
        "pursuit",
        help="a person is followed over a link with delay, with and without prediction",
        description="Let a scripted operator follow a person who walks through the simulated laboratory (Modes 1 and "
        "2), and drive a course, at round trips of 0, 150 and 300 ms, with and without the prediction of where the "
        "robot will be; in virtual time, on a body without physics, by the program's own way of commands. Results are "
        "kept while it goes on: started again after Ctrl-C it goes on where it ended.",
    )
    parser.add_argument(
        "--runs", type=whole(1, 1000), default=3, metavar="N", help="runs of each condition; a course each (default 3)"
    )
    parser.add_argument("--seed", type=whole(0), default=1, metavar="S", help="of the first run (default 1)")
    parser.add_argument("--task", choices=("follow", "course"), help="this one alone (default: both)")
    add_config(parser)
    add_results_options(parser, "runs")
    parser.add_argument(
        "--add",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="runs of a person, JSON as --json prints it: shown beside the scripted operator's",
    )
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the table of runs there")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the measures there (PNG or SVG)")


def run(args: argparse.Namespace) -> int:
    """Run it and report."""
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.pursuit.experiment import TASKS, done, plan
    from app.experiments.pursuit.experiment import run as run_pursuit
    from app.experiments.pursuit.result import results_of

    added = tuple(result for file in args.add for result in results_of(file))
    what = plan(
        args.runs,
        args.seed,
        program_named(args.config),
        tasks=TASKS if args.task is None else (args.task,),
        jobs=args.jobs or os.cpu_count() or 1,
    )
    kept = open_results(args, what.of())
    if before := done(what, kept):
        print(f"hbba experiment pursuit: {len(before)} of {what.total} runs are done already", file=sys.stderr)
    logging_setup.configure("error", as_json=False)
    with shown("driving") as progress:

        def finished(result: PursuitResult, number: int, total: int) -> None:
            mode = f"Mode {result.condition.mode}, {result.condition.words}"
            touched = f", {result.contacts} contacts" if result.contacts else ""
            progress(number, total, f"seed {result.seed}: {mode}: {result.time_s:.0f} s{touched}")

        results = run_pursuit(what, kept, finished)
    _report(args, what, (*results, *added))
    print(f"kept: {kept.file}", file=sys.stderr)
    return 0


def _report(args: argparse.Namespace, what: PursuitPlan, results: tuple[PursuitResult, ...]) -> None:
    from app.experiments.pursuit.report import plot, table_csv, tables
    from app.experiments.pursuit.result import summaries

    if args.json:
        conditions = [each.document() for each in summaries(results)]
        print_json({"of": what.of(), "conditions": conditions, "runs": [each.document() for each in results]})
    else:
        print(tables(results))
    if args.csv is not None:
        try:
            args.csv.write_text(table_csv(results), encoding="utf-8", newline="")
        except OSError as failure:
            raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(args.csv)) from None
    if args.plot is not None:
        plot(results, args.plot)
