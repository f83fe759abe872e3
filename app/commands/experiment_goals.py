"""``hbba experiment goals``: goals in the lab among people who walk, one after another, unattended."""

from __future__ import annotations

import argparse
import os
import sys
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.arguments import add_config, add_results_options, whole
from app.commands.experiment import open_results
from app.commands.output import print_json
from app.commands.packaged import program_named

if TYPE_CHECKING:
    from app.experiments.goals.result import GoalResult


def add_parser(experiments: Any) -> None:
    parser = experiments.add_parser(
        "goals",
        help="random goals in the lab among three people who walk",
        description="Have the robot map the lab on a tour driven by hand, then give it random goals, one after "
        "another, among three people who walk; in virtual time, in shifts that run beside each other. Results are "
        "kept while it goes on: started again after Ctrl-C it goes on where it ended.",
    )
    parser.add_argument("--count", type=whole(1, 10_000), default=100, metavar="N", help="how many goals (default 100)")
    parser.add_argument("--seed", type=whole(0), default=1, metavar="S", help="of the goals and the noise (default 1)")
    add_config(parser)
    parser.add_argument("--scenario", metavar="FILE", help="who walks there (default: walkers)")
    parser.add_argument(
        "--blind", action="store_true", help="without the Kinect: quicker, but what is lower than the laser is not seen"
    )
    add_results_options(parser, "shifts")


def run(args: argparse.Namespace) -> int:
    from app.base import logging_setup
    from app.commands.body_options import scenario_file
    from app.commands.progress import shown
    from app.experiments.goals.experiment import done, plan
    from app.experiments.goals.experiment import run as run_goals
    from app.experiments.goals.report import failures, table
    from app.experiments.goals.result import GoalsSummary

    scenario = None if args.scenario is None else scenario_file(args.scenario)
    if args.scenario is not None and scenario is None:
        raise ConfigError("the experiment needs a scenario, with people or without", "--scenario")
    what = plan(
        args.count,
        args.seed,
        program_named(args.config),
        scenario,
        jobs=args.jobs or os.cpu_count() or 1,
        cameras=not args.blind,
    )
    kept = open_results(args, what.of())
    before = done(what, kept)
    if before:
        print(f"hbba experiment goals: {len(before)} of {args.count} goals are done already", file=sys.stderr)
    logging_setup.configure("warning", as_json=False)
    reached = sum(result.outcome == "reached" for result in before)
    with_contact = sum(bool(result.touched) for result in before)
    with shown("goals") as progress:

        def finished(result: GoalResult, number: int, total: int) -> None:
            nonlocal reached, with_contact
            reached += result.outcome == "reached"
            with_contact += bool(result.touched)
            touched = f", touched {', '.join(result.touched)}" if result.touched else ""
            progress(
                number,
                total,
                f"goal {result.number}: {result.outcome} after {result.time_s:.0f} s{touched}; "
                f"{reached} of {number} reached, {with_contact} with contact",
            )

        results = run_goals(what, kept, finished, lambda stage: progress(len(before), args.count, stage))
    rows = [result.document() for result in results]
    if args.json:
        print_json({"of": what.of(), "summary": GoalsSummary.of(results).document(), "goals": rows})
    else:
        print("\n\n".join(filter(None, (table(results), "\n".join(failures(results))))))
    print(f"kept: {kept.file}", file=sys.stderr)
    return 0
