"""``hbba tour rehearse``: a tour played on its map, without the robot."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands.arguments import add_config, whole
from app.commands.output import add_json, print_json
from app.commands.packaged import program_named
from app.commands.printable import one_line, printable

if TYPE_CHECKING:
    from app.rehearsal.result import Rehearsal
    from app.tours.model import Tour


def add_parser(actions: Any) -> None:
    parser = actions.add_parser(
        "rehearse",
        help="play a tour on its map, without the robot",
        description="Play a tour on the map that was kept, many times faster than life: the program's own guide, "
        "planner and attention lead simulated visitors, who follow. Say what was said, in which state, and each "
        "problem. Exit code 1 for a tour that cannot be led as it is written.",
    )
    parser.add_argument("tour", metavar="TOUR", help="a file, or a tour's id")
    parser.add_argument("--language", metavar="TAG", help="of the visitors, as fr (default: the tour's first)")
    parser.add_argument("--people", type=whole(0, 8), default=2, metavar="N", help="visitors (default 2)")
    parser.add_argument("--seed", type=whole(0), default=1, metavar="S", help="of how they follow (default 1)")
    add_config(parser)
    add_json(parser, default=argparse.SUPPRESS)


def run(args: argparse.Namespace, tour: Tour) -> int:
    """Rehearse ``tour``. Raises ConfigError for a person's mistake."""
    from app.base import logging_setup
    from app.commands.progress import shown
    from app.maps.library import MapLibrary, default_folder
    from app.program.config import load_configuration
    from app.rehearsal.rehearse import RehearsalRequest, rehearse

    language = args.language or tour.languages[0]
    if language not in tour.languages:
        raise ConfigError(f"{tour.id} is not in {language!r}; there are: {', '.join(tour.languages)}", "--language")
    logging_setup.configure("error", as_json=False)
    configuration = load_configuration(program_named(args.config or "lab") or Path())
    request = RehearsalRequest(
        tour, configuration, MapLibrary(default_folder()), language, people=args.people, seed=args.seed
    )
    with shown("rehearsal") as progress:

        def played(seconds: float, stop: str) -> None:
            number = next((n for n, each in enumerate(tour.stops) if each.id == stop), 0)
            progress(number, len(tour.stops), f"{seconds / 60:.1f} min{f', {stop}' if stop else ''}")

        rehearsal = rehearse(request, played)
    if args.json:
        print_json(asdict(rehearsal))
    else:
        print("\n".join(printable(line) for line in report(rehearsal)))
    return 0 if rehearsal.can_be_led else 1


def report(rehearsal: Rehearsal) -> list[str]:
    """What happened, in order, and the problems, a line each."""
    lines = [
        (state.at_s, f"{state.state.replace('_', ' ')}{_of(state.stop)}{_why(state.reason)}")
        for state in rehearsal.states
    ]
    lines += [(said.at_s, f"    “{one_line(' '.join(said.text.split()))}”") for said in rehearsal.subtitles]
    story = [f"{_clock(at_s)}  {text}" for at_s, text in sorted(lines, key=lambda line: line[0])]
    problems = [
        f"{problem.severity}: {'' if problem.at_s is None else f'{_clock(problem.at_s)}: '}{one_line(problem.message)}"
        for problem in rehearsal.problems
    ]
    whole_way = f"{rehearsal.tour}: {_clock(rehearsal.duration_s)} min, {rehearsal.driven_m:.0f} m"
    return [*story, *problems, f"{whole_way}, stops presented: {len(rehearsal.stops)}; {one_line(rehearsal.outcome)}"]


def _clock(seconds: float) -> str:
    return f"{int(seconds // 60)}:{int(seconds % 60):02}"


def _of(stop: str) -> str:
    return f" ({stop})" if stop else ""


def _why(reason: str) -> str:
    return f": {one_line(reason)}" if reason else ""
