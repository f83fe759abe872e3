"""``hbba experiment tour``: a guided tour with one visitor who lags and one who asks, again and again."""

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
    from app.experiments.tour.experiment import TourPlan
    from app.experiments.tour.result import TourResult


def add_parser(experiments: Any) -> None:
    """Declare ``hbba experiment tour``."""
    parser = experiments.add_parser(
        "tour",
        help="a guided tour with one visitor who lags and one who asks",
        description="Lead a tour of the simulated laboratory again and again, in virtual time, on a body without "
        "physics: the program's own guide, planner and attention, and two visitors who follow, one who lags and one "
        "who asks. Each run is judged by the truth. Results are kept while it goes on: started again after Ctrl-C it "
        "goes on where it ended. Exit code 1 where a run has a problem.",
    )
    parser.add_argument("--tour", default="lab-tour", metavar="TOUR", help="a file, or a tour's id (default: lab-tour)")
    parser.add_argument("--runs", type=whole(1, 1000), default=10, metavar="N", help="how many (default 10)")
    parser.add_argument("--seed", type=whole(0), default=1, metavar="S", help="of the first run (default 1)")
    add_config(parser)
    add_results_options(parser, "runs")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the table of runs there")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the first run's ways there (PNG or SVG)")


def run(args: argparse.Namespace) -> int:
    """Run it and report."""
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.commands.tour import tour_named
    from app.experiments.tour.experiment import done, plan
    from app.experiments.tour.experiment import run as run_tours

    what = plan(
        tour_named(args.tour), args.runs, args.seed, program_named(args.config), jobs=args.jobs or os.cpu_count() or 1
    )
    kept = open_results(args, what.of())
    if before := done(what, kept):
        print(f"hbba experiment tour: {len(before)} of {args.runs} runs are done already", file=sys.stderr)
    logging_setup.configure("error", as_json=False)
    good = sum(not result.problems for result in before)
    with shown("touring") as progress:

        def finished(result: TourResult, number: int, total: int) -> None:
            nonlocal good
            good += not result.problems
            progress(number, total, f"seed {result.seed}: {result.outcome}; {good} of {number} without a problem")

        results = run_tours(what, kept, finished)
    _report(args, what, results, kept.file)
    return 0 if all(not result.problems for result in results) else 1


def _report(args: argparse.Namespace, what: TourPlan, results: tuple[TourResult, ...], kept: Path) -> None:
    from app.experiments.tour.report import plot, problems, runs_table, summary_table, table_csv
    from app.experiments.tour.result import TourSummary
    from app.maps.library import MapLibrary

    if args.json:
        runs = [result.document() | {"problems": result.problems} for result in results]
        print_json({"of": what.of(), "summary": TourSummary.of(results).document(), "runs": runs})
    else:
        parts = (runs_table(results), summary_table(results), "\n".join(problems(results)))
        print("\n\n".join(filter(None, parts)))
    if args.csv is not None:
        try:
            args.csv.write_text(table_csv(results), encoding="utf-8", newline="")
        except OSError as failure:
            raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(args.csv)) from None
    if args.plot is not None:
        maps = MapLibrary(kept.parent / "maps")
        places = {place.id: place for place in maps.places(what.tour.map)}
        stops = [places[stop.place] for stop in what.tour.stops if not stop.left_out]
        plot(results[0], maps.grid(what.tour.map), stops, args.plot)
    print(f"kept: {kept}", file=sys.stderr)
