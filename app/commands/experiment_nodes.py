"""``hbba experiment nodes``: what a second computer is worth to attention."""

from __future__ import annotations

import argparse
from typing import Any

from app.base import paths
from app.commands.arguments import add_config, names, numbers, real
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(experiments: Any) -> None:
    from app.experiments.nodes.experiment import BUDGETS, CLASSES

    parser = experiments.add_parser(
        "nodes",
        help="the utility of perception on one computer, and on two of the same budget",
        description="Let attention serve several perceptions at once on the robot's computer alone, and with a second "
        "one of the same budget that may run all modules that can be elsewhere. What becomes of a node that is lost "
        "or slow, `hbba bench nodes` measures.",
    )
    add_config(parser)
    parser.add_argument(
        "--classes", type=names, default=CLASSES, metavar="A,B", help=f"what is desired (default {','.join(CLASSES)})"
    )
    parser.add_argument(
        "--budgets",
        type=numbers(0.1, 1e6),
        default=BUDGETS,
        metavar="X,Y",
        help=f"of each computer, %% of a core (default {','.join(f'{each:g}' for each in BUDGETS)})",
    )
    parser.add_argument(
        "--bandwidth", type=real(0, 1e5), default=5.0, metavar="MB/S", help="of the link (default 5 MB/s)"
    )
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Print the table. Raises ConfigError."""
    from app.experiments.nodes.experiment import document, plan, table
    from app.experiments.nodes.experiment import run as run_all

    what = plan(
        program_named(args.config) or paths.config_dir() / "lab.yaml",
        args.classes,
        args.budgets,
        bandwidth=args.bandwidth,
    )
    found = run_all(what)
    if args.json:
        print_json(document(what, found))
    else:
        print(f"Desired: {', '.join(what.classes)}. Elsewhere: {', '.join(what.node.settings.modules)}.\n")
        print(table(what, found))
    return 0
