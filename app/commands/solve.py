"""``hbba solve``: a selection problem from a file, answered and explained; how people try an idea without a robot."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from app.commands.output import add_json, print_json
from app.errors import ConfigError


def add_parser(subparsers: Any) -> None:
    """Declare ``hbba solve``."""
    parser = subparsers.add_parser(
        "solve",
        help="choose strategies for a problem in a file, and say why",
        description="Read a selection problem (desires, strategies, resources; YAML or JSON) and print which "
        "strategies are selected, what they fulfil, what they use, which filters and parameters they set, and why each "
        "desire gets what it gets. The format is in docs/solve.md.",
    )
    parser.add_argument("file", nargs="?", metavar="FILE", help="the problem; - reads standard input")
    add_json(parser)
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of the problem format and leave")
    parser.add_argument(
        "--time-limit", type=float, default=10.0, metavar="S", help="keep the best found after S seconds (default 10)"
    )


def run(args: argparse.Namespace) -> int:
    """Solve one problem and print the answer. Raises ConfigError for a mistake in the file."""
    from app.attention.problem_file import problem_schema, read_problem
    from app.yaml_source import MOST_BYTES, load_text, load_yaml

    if args.schema:
        print_json(problem_schema())
        return 0
    if args.file is None:
        raise ConfigError("name the file of a problem, or - for standard input (see `hbba solve --help`)")
    if args.time_limit <= 0:
        raise ConfigError(f"--time-limit must be greater than 0 seconds, not {args.time_limit:g}")
    if args.file == "-":
        document, folder = load_text(sys.stdin.read(MOST_BYTES + 1), "<standard input>"), Path.cwd()
    else:
        document, folder = load_yaml(args.file), Path(args.file).resolve().parent
    stated = read_problem(document, folder)

    from app.attention.intention import divisors_of, parameters_of
    from app.attention.reasons import explain
    from app.attention.serialize import selection_to_json
    from app.attention.solver import InvalidProblem, SolverFailed, solve

    try:
        selection = solve(stated.problem, time_limit_s=args.time_limit)
    except InvalidProblem as failure:
        raise document.error(str(failure)) from None
    except SolverFailed as failure:
        print(f"hbba solve: {failure}; try a greater --time-limit", file=sys.stderr)
        return 1
    table = stated.table
    reasons = explain(stated.problem, selection, time_limit_s=args.time_limit, resources=table.resources)
    selection = replace(selection, reasons=reasons)
    chosen = [s for s in table.strategies if s.name in selection.strategies]
    divisors = divisors_of(chosen, table.filters)
    parameters = parameters_of(chosen, stated.problem.desires)
    if args.json:
        answer = selection_to_json(
            selection,
            strategies=table.strategies,
            capacities=stated.problem.capacities,
            resources=table.resources,
            divisors=divisors,
            reasons=reasons,
        )
        print_json({**answer, "parameters": parameters})
    else:
        from app.commands.solve_report import report

        print(report(stated, selection, divisors, parameters, plain=not _speaks_unicode()))
    return 0


def _speaks_unicode() -> bool:
    """Whether standard output can show φ, ∞ and bars."""
    try:
        "Ωφ∞█░".encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
