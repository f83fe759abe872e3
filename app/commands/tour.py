"""``hbba tour``: lists and checks guided tours, and prints their posters."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.commands import tour_rehearse
from app.commands.arguments import add_config, file_named
from app.commands.output import add_json, aligned, check_writable, print_json
from app.commands.packaged import program_named
from app.commands.printable import one_line, printable
from app.tours.paper import PAPERS

if TYPE_CHECKING:
    from app.base.yaml_source import Document
    from app.tours.checks import Surroundings
    from app.tours.library import TourLibrary
    from app.tours.model import Tour
    from app.tours.problems import TourProblem


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "tour",
        help="list and check guided tours, and print their posters",
        description="Manage guided tours (docs/guided-tours.md). TOUR is a file, or the id of a tour of yours or of "
        "one that comes with the program. Without anything, list them.",
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION")
    add_json(parser)
    listing = actions.add_parser("list", help="list all tours", description="List all tours by id.")
    add_json(listing, default=argparse.SUPPRESS)
    check = actions.add_parser(
        "check",
        help="find what is wrong with a tour, and what it lacks to run",
        description="Say each problem as FILE:LINE: severity: field: message. Exit code 2 for what is no tour, 1 for "
        "one that cannot run here, 0 for one that can, with warnings or without.",
    )
    check.add_argument("tours", nargs="+", metavar="TOUR", help="a file, or a tour's id")
    add_config(check)
    add_json(check, default=argparse.SUPPRESS)
    schema = actions.add_parser(
        "schema", help="print the JSON Schema of a tour", description="Print the JSON Schema of a tour."
    )
    add_json(schema, "for uniformity: it is one anyway", default=argparse.SUPPRESS)
    tour_rehearse.add_parser(actions)
    posters = actions.add_parser(
        "posters",
        help="print posters of a tour's stops",
        description="Write a PDF with a poster a page, of all stops that have one or of those that are named.",
    )
    posters.add_argument("tour", metavar="TOUR", help="a file, or a tour's id")
    posters.add_argument("stops", nargs="*", metavar="STOP", help="ids of stops; none: all")
    posters.add_argument("--out", type=file_named, metavar="FILE", help="the PDF (default: ID-posters.pdf)")
    posters.add_argument("--paper", choices=list(PAPERS), default="a4", help="a4 (the usual one) or letter")
    posters.add_argument("--language", metavar="TAG", help="of the titles, as fr (default: the tour's first)")
    add_json(posters, default=argparse.SUPPRESS)


def run(args: argparse.Namespace) -> int:
    """Do it. Raises ConfigError for a person's mistake."""
    match args.action:
        case "check":
            return _check(args)
        case "posters":
            return _posters(args)
        case "rehearse":
            tour, _ = _load(_file(_library(), args.tour))
            return tour_rehearse.run(args, tour)
        case "schema":
            from app.tours.model import tour_schema

            print_json(tour_schema())
            return 0
    return _list(args)


def _list(args: argparse.Namespace) -> int:
    library = _library()
    found: list[dict[str, Any]] = []
    for name in library.names():
        about: dict[str, Any] = {"id": name, "title": {}, "map": "", "stops": 0, "shipped": False, "problem": None}
        try:
            tour = library.read(name)
        except (ConfigError, OSError, ValueError) as damage:
            found.append(about | {"problem": str(damage)})
            continue
        stops = sum(not stop.left_out for stop in tour.stops)
        shipped = library.is_shipped(name)
        found.append(about | {"title": tour.title, "map": tour.map, "stops": stops, "shipped": shipped})
    if args.json:
        print_json({"folder": library.folder, "tours": found})
        return 0
    rows = [("ID", "TITLE", "MAP", "STOPS", "")]
    for each in found:
        title = next(iter(each["title"].values()), "")
        of = each["problem"] or ("comes with the program" if each["shipped"] else "")
        rows.append((each["id"], one_line(title), one_line(each["map"]), str(each["stops"]), one_line(of)))
    print("\n".join(aligned(rows, (3,))) if found else f"no tours in {library.folder}")
    return 0


def _check(args: argparse.Namespace) -> int:
    from app.program.config import load_configuration
    from app.program.desire_classes import desire_classes
    from app.program.recognizer import recognizer_of
    from app.tours.checks import check

    library = _library()
    configuration = load_configuration(program_named(args.config or "lab") or Path())
    classes, recognizer = desire_classes(configuration), recognizer_of(configuration)
    results: list[dict[str, Any]] = []
    worst = 0
    for named in args.tours:
        problems: Sequence[TourProblem] = ()
        mistake = None
        try:
            file = _file(library, named)
            tour, document = _load(file)
        except ConfigError as failure:
            mistake = str(failure)
            print(printable(mistake), file=sys.stderr)
            worst = 2
        else:
            problems = check(tour, _around(tour, file, library, classes=classes, recognizer=recognizer))
            runs = all(problem.severity == "warning" for problem in problems)
            worst = max(worst, 0 if runs else 1)
            if not args.json:
                _report(file, document, problems, runs)
        results.append(
            {
                "tour": named,
                "mistake": mistake,
                "problems": [{"field": p.field, "message": p.message, "severity": p.severity} for p in problems],
            }
        )
    if args.json:
        print_json({"tours": results})
    return worst


def _report(file: Path, document: Document, problems: Sequence[TourProblem], runs: bool) -> None:
    from app.base.yaml_source import dotted

    for problem in problems:
        where = f"{file}:{document.line(problem.path)}"
        print(printable(f"{where}: {problem.severity}: {dotted(problem.path)}: {problem.message}"))
    print(printable(f"{file}: {'can run' if runs else 'cannot run'} here"))


def _posters(args: argparse.Namespace) -> int:
    from app.tours.posters import NoPosters, posters_of, posters_pdf, reach_m

    check_writable(args.out)
    tour, _ = _load(_file(_library(), args.tour))
    try:
        posters = posters_of(tour, args.language, args.stops or None)
    except NoPosters as refusal:
        raise ConfigError(str(refusal)) from None
    out = args.out or Path(f"{tour.id}-posters.pdf")
    try:
        out.write_bytes(posters_pdf(posters, args.paper, next(iter(tour.title.values()))))
    except OSError as failure:
        raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(out)) from None
    if args.json:
        rows = [{"number": p.number, "title": p.title, "code": p.code, "read_from_m": reach_m(p.code)} for p in posters]
        print_json({"file": out, "posters": rows})
        return 0
    for poster in posters:
        print(
            printable(
                f"{poster.number}  {one_line(poster.title)}: {poster.code}, read from {reach_m(poster.code):.1f} m"
            )
        )
    print(f"{out}: {len(posters)} page{'s' * (len(posters) > 1)}")
    return 0


def tour_named(named: str) -> Tour:
    """The tour of a file, or of an id. Raises ConfigError."""
    tour, _ = _load(_file(_library(), named))
    return tour


def _library() -> TourLibrary:
    from app.base import paths
    from app.tours.library import TourLibrary, default_folder

    return TourLibrary(default_folder(), paths.config_dir() / "tours")


def _file(library: TourLibrary, named: str) -> Path:
    """The file that people mean: a path, or a tour's id. Raises ConfigError."""
    from app.tours.library import UnknownTour

    path = Path(named)
    if path.is_file():
        return path
    try:
        return library.file(named)
    except (UnknownTour, ValueError) as refusal:
        raise ConfigError(f"there is no file {named}; {refusal}") from None


def _load(file: Path) -> tuple[Tour, Document]:
    from app.tours.tour_file import load_tour

    return load_tour(file)


def _around(tour: Tour, file: Path, library: TourLibrary, **program: Any) -> Surroundings:
    """Media lie beside the file, or in the folders of tours."""
    from app.maps.library import MapLibrary, default_folder
    from app.tours.surroundings import surroundings

    folders = (file.resolve().parent, *library.folders)
    return surroundings(tour, maps=MapLibrary(default_folder()), folders=folders, **program)
