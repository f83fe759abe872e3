"""``hbba experiment body``: every actuator group commanded by behaviors under attention, and the guard's figures."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.arguments import add_config
from app.commands.body_options import experiment_scenario
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(experiments: Any) -> None:
    """Declare ``hbba experiment body``."""
    parser = experiments.add_parser(
        "body",
        help="every actuator group at once, commanded by behaviors under attention",
        description="State the desires of a play, one after the other and at once; report for each actuator group "
        "which behaviors commanded it, what its guard did, its speeds against their limits, and how soon the emergency "
        "stop brought it to rest. Ctrl-C stops it and the robot.",
    )
    add_config(parser)
    parser.add_argument("--play", type=Path, metavar="FILE", help="what is desired and when (default: that of the lab)")
    parser.add_argument("--scenario", metavar="FILE", help="people and sounds: a file, or a name (default: lab)")
    parser.add_argument(
        "--virtual",
        action="store_true",
        help="in virtual time: every sensor keeps its rate however slow this computer is",
    )
    add_json(parser)
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw it there (PNG or SVG)")


def run(args: argparse.Namespace) -> int:
    """Run it and print the figures."""
    from app.base import logging_setup, paths
    from app.commands.progress import shown
    from app.experiments.body.experiment import document
    from app.experiments.body.experiment import run as play_it
    from app.experiments.body.report import plot, table
    from app.experiments.simulated import simulated_program

    program = simulated_program(program_named(args.config), experiment_scenario(args.scenario or "lab"))
    play = args.play or paths.config_dir() / "experiments" / "body.yaml"
    logging_setup.configure("warning", as_json=False)
    with shown("playing") as progress:
        result = play_it(program, play, lambda part: progress(round(1000 * part), 1000), virtual=args.virtual)
    if args.json:
        print_json(document(result))
    else:
        print(table(result))
        pace = "in virtual time" if args.virtual else f"world's time {result.world_rate:.2f} of real time"
        print(f"\n{result.play.seconds:g} s, {pace}")
    if args.plot is not None:
        try:
            plot(result, args.plot)
        except OSError as failure:
            raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(args.plot)) from None
    return 0
