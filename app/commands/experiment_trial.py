"""``hbba experiment trial``: the thesis's tour-guide trial."""

from __future__ import annotations

import argparse
from typing import Any

from app.commands.arguments import add_config, recording_name
from app.commands.body_options import experiment_scenario
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(experiments: Any) -> None:
    parser = experiments.add_parser(
        "trial",
        help="the thesis's tour-guide trial, driven by its script",
        description="Drive the robot along a scenario's script (default: the tour-guide trial of the thesis, figure "
        "4.8), with attention, and report what it attended to and found. Ctrl-C stops it and the robot.",
    )
    add_config(parser)
    parser.add_argument(
        "--scenario", metavar="FILE", help="one that drives: a file, or a name as mapping (default: trial)"
    )
    parser.add_argument("--record", type=recording_name, metavar="NAME", help="record it under this name")
    parser.add_argument(
        "--virtual",
        action="store_true",
        help="in virtual time: every sensor keeps its rate however slow this computer is",
    )
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.observation import document
    from app.experiments.simulated import simulated_program
    from app.experiments.tour_guide_trial import run as run_trial

    program = simulated_program(program_named(args.config), experiment_scenario(args.scenario))
    logging_setup.configure("warning", as_json=False)
    with shown("driving") as progress:
        outcome, events = run_trial(
            program, args.record, lambda leg, of, label: progress(leg, of, label), virtual=args.virtual
        )
    if args.json:
        rows = [{"at": round(event.at, 3), "subject": event.subject, "text": event.text} for event in events]
        print_json(document((outcome,), {"events": rows}))
        return 0
    for event in events:
        print(f"{event.at:7.1f} s  {event.text}")
    found = ", ".join(f"{count} {kind}" for kind, count in outcome.found.items())
    cost = (
        "in virtual time"
        if args.virtual
        else f"program {outcome.cpu:.0f} % of a core, world's time {outcome.world_rate:.2f} of real time"
    )
    print(
        f"\n{outcome.seconds:.0f} s; found {found}; {outcome.missed} of {outcome.beats + outcome.missed} beats of the "
        f"base missed, {outcome.stops} stops by the guard; {cost}"
    )
    return 0
