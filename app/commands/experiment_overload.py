"""``hbba experiment overload``: a small computer without attention, and with it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.arguments import add_config, real
from app.commands.body_options import experiment_scenario
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(experiments: Any) -> None:
    parser = experiments.add_parser(
        "overload",
        help="what falls behind on a small computer without attention, and what attention keeps",
        description="Run the scripted trial twice with the program kept on one core: every filter open, then with "
        "attention. Reports CPU, ages of messages, missed beats and what was found.",
    )
    add_config(parser)
    parser.add_argument(
        "--scenario", metavar="FILE", help="one that drives: a file, or a name as mapping (default: trial)"
    )
    parser.add_argument(
        "--seconds",
        type=real(5, 3600, rule="seconds are a number from 5 to 3600"),
        default=60.0,
        metavar="S",
        help="how long each (default 60)",
    )
    parser.add_argument(
        "--budget",
        type=real(10, 100, rule="a budget is 10 to 100 % of a core"),
        default=100.0,
        metavar="PERCENT",
        help="how much of one core (default 100, least 10)",
    )
    add_json(parser)
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw it there (PNG or SVG)")


def run(args: argparse.Namespace) -> int:
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.observation import document
    from app.experiments.overload.experiment import plan
    from app.experiments.overload.experiment import run as run_both
    from app.experiments.overload.report import doubts, plot, table

    what = plan(program_named(args.config), experiment_scenario(args.scenario), args.seconds, args.budget)
    logging_setup.configure("warning", as_json=False)
    with shown("running") as progress:
        without, kept = run_both(what, lambda condition, part: progress(round(1000 * part), 1000, condition))
    if args.json:
        settings = {"seconds": args.seconds, "budget": args.budget}
        print_json(document((without, kept), settings))
    else:
        print(table(without, kept))
    for doubt in doubts((without, kept), args.budget):
        print(f"hbba experiment overload: these figures say little: {doubt}", file=sys.stderr)
    if args.plot is not None:
        try:
            plot(without, kept, args.plot)
        except OSError as failure:
            raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(args.plot)) from None
    return 0
