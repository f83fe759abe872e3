"""``hbba experiment closed-loop``: wrong costs, a dear module, half of the computer gone; attention's loop open and
closed."""

from __future__ import annotations

import argparse
import csv
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.arguments import add_config, real
from app.commands.body_options import experiment_scenario
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(experiments: Any) -> None:
    parser = experiments.add_parser(
        "closed-loop",
        help="how attention follows what is measured: wrong costs, a dear module, half of the computer gone",
        description="Drive to and fro among people, the program kept on one core, with costs declared three times "
        "wrong, with a module that suddenly takes twice the CPU, and with half of the core taken away and given back; "
        "each with attention's loop open and closed. Reports how soon the CPU was within its budget, what changed "
        "after that, and the planner's period.",
    )
    add_config(parser)
    parser.add_argument("--scenario", metavar="FILE", help="a file, or a name as people (default: walkers)")
    parser.add_argument(
        "--seconds",
        type=real(8, 600, rule="seconds are a number from 8 to 600"),
        default=20.0,
        metavar="S",
        help="how long each phase (default 20)",
    )
    add_json(parser)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write all samples there")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw it there (PNG or SVG)")


def run(args: argparse.Namespace) -> int:
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.closed_loop.experiment import plan, rows
    from app.experiments.closed_loop.experiment import run as run_all
    from app.experiments.closed_loop.report import doubts, plot, table
    from app.experiments.observation import plain

    what = plan(program_named(args.config), experiment_scenario(args.scenario or "walkers"), args.seconds)
    logging_setup.configure("warning", as_json=False)
    with shown("running") as progress:
        results = run_all(what, lambda name, part: progress(round(1000 * part), 1000, name))
    if args.json:
        print_json(plain({"phase_s": args.seconds, "runs": [asdict(each) for each in results]}))
    else:
        print(table(results))
    for doubt in doubts(results):
        print(f"hbba experiment closed-loop: these figures say little: {doubt}", file=sys.stderr)
    try:
        if args.csv is not None:
            with args.csv.open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows(rows(results))
        if args.plot is not None:
            plot(results, args.plot)
    except OSError as failure:
        raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(failure.filename)) from None
    return 0
