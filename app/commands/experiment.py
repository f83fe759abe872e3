"""``hbba experiment``: the thesis's experiments and our own, unattended."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands import experiment_barn, experiment_goals
from app.commands.arguments import number, recording_name
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named


def add_parser(subparsers: Any) -> None:
    """Declare ``hbba experiment`` and the experiments there are."""
    parser = subparsers.add_parser(
        "experiment",
        help="run an experiment and report it",
        description="Run an experiment in the simulated world, unattended, and report it as a table and a picture.",
    )
    experiments = parser.add_subparsers(dest="experiment", metavar="EXPERIMENT", required=True)
    overload = experiments.add_parser(
        "overload",
        help="what falls behind on a small computer without attention, and what attention keeps",
        description="Run the scripted trial twice with the program kept on one core: every filter open, then with "
        "attention. Reports CPU, ages of messages, missed beats and what was found.",
    )
    overload.add_argument(
        "--config", type=Path, metavar="FILE", help="the program: a file, or a name as jackal (default: lab)"
    )
    overload.add_argument(
        "--scenario", metavar="FILE", help="one that drives: a file, or a name as mapping (default: trial)"
    )
    overload.add_argument("--seconds", type=_seconds, default=60.0, metavar="S", help="how long each (default 60)")
    overload.add_argument(
        "--budget", type=_budget, default=100.0, metavar="PERCENT", help="how much of one core (default 100, least 10)"
    )
    add_json(overload)
    overload.add_argument("--plot", type=Path, metavar="FILE", help="draw it there (PNG or SVG)")
    trial = experiments.add_parser(
        "trial",
        help="the thesis's tour-guide trial, driven by its script",
        description="Drive the robot along a scenario's script (default: the tour-guide trial of the thesis, figure "
        "4.8), with attention, and report its attention and its findings. Ctrl-C stops it and the robot.",
    )
    trial.add_argument(
        "--config", type=Path, metavar="FILE", help="the program: a file, or a name as jackal (default: lab)"
    )
    trial.add_argument(
        "--scenario", metavar="FILE", help="one that drives: a file, or a name as mapping (default: trial)"
    )
    trial.add_argument("--record", type=recording_name, metavar="NAME", help="record it under this name")
    trial.add_argument(
        "--virtual",
        action="store_true",
        help="in virtual time: every sensor keeps its rate however slow this computer is",
    )
    add_json(trial)
    experiment_barn.add_parser(experiments)
    experiment_goals.add_parser(experiments)


def run(args: argparse.Namespace) -> int:
    """Run the experiment that ``args`` name. Raises ConfigError."""
    import cv2

    from app.experiments.pool import TrialLost
    from app.experiments.script import ScriptBlocked
    from app.link import LinkFailed
    from app.maps.control import MapUnavailable

    cv2.setNumThreads(1)
    experiments = {"trial": _trial, "overload": _overload, "barn": experiment_barn.run, "goals": experiment_goals.run}
    try:
        return experiments[args.experiment](args)
    except (LinkFailed, MapUnavailable, ScriptBlocked, TrialLost) as failure:
        print(f"hbba experiment {args.experiment}: {failure}", file=sys.stderr)
        return 1


def _trial(args: argparse.Namespace) -> int:
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.observation import document
    from app.experiments.simulated import simulated_program
    from app.experiments.trial import run as run_trial

    program = simulated_program(program_named(args.config), _scenario(args.scenario))
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


def _overload(args: argparse.Namespace) -> int:
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.experiments.observation import document
    from app.experiments.overload.experiment import plan
    from app.experiments.overload.experiment import run as run_both
    from app.experiments.overload.report import doubts, plot, table

    what = plan(program_named(args.config), _scenario(args.scenario), args.seconds, args.budget)
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


def _seconds(text: str) -> float:
    value = number(text)
    if value is None or not 5 <= value <= 3600:
        raise argparse.ArgumentTypeError(f"seconds are a number from 5 to 3600, not {text!r}")
    return value


def _budget(text: str) -> float:
    value = number(text)
    if value is None or not 10 <= value <= 100:
        raise argparse.ArgumentTypeError(f"a budget is 10 to 100 % of a core, not {text!r}")
    return value


def _scenario(named: str | None) -> Path | None:
    """The scenario's file, None for the experiment's own. Raises ConfigError."""
    from app.base.errors import ConfigError
    from app.commands.body_options import scenario_file

    if named is None:
        return None
    file = scenario_file(named)
    if file is None:
        raise ConfigError("an experiment needs a scenario that drives", "--scenario")
    return file
