"""``hbba experiment exploration``: a place that the robot maps by itself."""

from __future__ import annotations

import argparse
from typing import Any

from app.commands.arguments import add_config
from app.commands.body_options import experiment_scenario
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(experiments: Any) -> None:
    """Declare ``hbba experiment exploration``."""
    parser = experiments.add_parser(
        "exploration",
        help="a place that the robot maps by itself",
        description="Desire the robot to explore the simulated lab, which it knows nothing of, until all that it can "
        "reach is mapped; report how much of the floor its map has, how long it took and what it touched. In virtual "
        "time.",
    )
    add_config(parser)
    parser.add_argument("--scenario", metavar="FILE", help="people: a file, or a name (default: nobody)")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Run it and print the table. Raises ConfigError."""
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.exploration.experiment import document, plan, table
    from app.experiments.exploration.experiment import run as explore

    scenario = None if args.scenario is None else experiment_scenario(args.scenario)
    what = plan(program_named(args.config), scenario)
    logging_setup.configure("warning", as_json=False)
    with shown("of the floor is mapped") as progress:
        result = explore(what, lambda share: progress(round(1000 * share), 1000))
    if args.json:
        print_json(document(result))
    else:
        print(table(result))
    return 0
