"""``hbba solve``: a selection problem from a file, answered and explained; how people try an idea without a robot."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from app.base.errors import ConfigError
from app.commands.arguments import number
from app.commands.output import add_json, print_json
from app.commands.printable import printable
from app.commands.time_limit import TimeIsUp, until

if TYPE_CHECKING:
    from app.attention.problem import Selection
    from app.attention.problem_file import StatedProblem
    from app.base.yaml_source import Document

LONGEST_S: Final = 86_400
#: A problem in a file is of no time, and says itself what is desired.
_OF_A_PROGRAM: Final = ("stamp", "desires", "asked", "previous")
MORE_TIME: Final = "try a greater --time-limit"


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "solve",
        help="choose strategies for a problem in a file, and say why",
        description="Read a selection problem (desires, strategies, resources; YAML or JSON) and print which "
        "strategies are selected, what they fulfil, what they use, which filters and parameters they set, and why each "
        "desire gets what it gets. The format is in docs/solve.md.",
    )
    parser.add_argument("file", nargs="?", metavar="FILE", help="the problem; - reads standard input")
    add_json(parser)
    parser.add_argument(
        "--certificate",
        metavar="FILE",
        help="also write the proof that no selection is better, for `hbba check`; - prints it instead of the answer",
    )
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of the problem format and leave")
    parser.add_argument(
        "--time-limit",
        default="10",
        metavar="S",
        help="seconds for reading, solving and explaining together: then the best found is kept (default 10)",
    )


def run(args: argparse.Namespace) -> int:
    """Solve one problem and print the answer. Raises ConfigError for a mistake in the file."""
    from app.attention.problem_file import problem_schema
    from app.base.yaml_source import MOST_BYTES

    if args.schema:
        print_json(problem_schema())
        return 0
    if args.file is None:
        raise ConfigError("name the file of a problem, or - for standard input (see `hbba solve --help`)")
    limit_s = number(args.time_limit)
    if limit_s is None or not 0 < limit_s <= LONGEST_S:
        raise ConfigError(
            f"--time-limit must be a number of seconds greater than 0 and at most {LONGEST_S}, not {args.time_limit!r}"
        )
    # A problem that is typed, or piped in from another program, may take any time to come: no limit is set here.
    text = sys.stdin.read(MOST_BYTES + 1) if args.file == "-" else None
    deadline = time.perf_counter() + limit_s
    try:
        with until(deadline):
            document, stated = _read(args.file, text)
    except TimeIsUp:
        print(printable(f"hbba solve: the time was over before {args.file} was read; {MORE_TIME}"), file=sys.stderr)
        return 1

    from app.attention.solver import InvalidProblem, SolverFailed, solve

    try:
        stated = replace(stated, problem=stated.problem.with_table())
        selection = solve(stated.problem, time_limit_s=deadline - time.perf_counter())
    except InvalidProblem as failure:
        raise document.error(str(failure)) from None
    except SolverFailed as failure:
        print(f"hbba solve: {failure}; {MORE_TIME}", file=sys.stderr)
        return 1
    code = 0
    if args.certificate is not None:
        # First of all: who reads the answer may close it before its end.
        code = _certified(stated, selection, deadline, args.certificate)
        if args.certificate == "-":
            return code
    if args.json:
        print_json(_answer_as_json(stated, selection, deadline))
    else:
        from app.commands.solve_report import report_consequences, report_selection

        plain = not _speaks_unicode()
        # Reasons may take all the remaining time: the selection is printed before.
        print(report_selection(stated, selection, plain=plain), flush=True)
        selection = _explained(stated, selection, deadline)
        print(report_consequences(stated, selection, *_consequences(stated, selection), plain=plain))
    return code


def _read(file: str, text: str | None) -> tuple[Document, StatedProblem]:
    from app.attention.problem_file import read_problem
    from app.base.yaml_source import load_text, load_yaml

    if text is not None:
        document, folder = load_text(text, "<standard input>"), Path.cwd()
    else:
        document, folder = load_yaml(file), Path(file).resolve().parent
    return document, read_problem(document, folder)


def _certified(stated: StatedProblem, selection: Selection, deadline: float, file: str) -> int:
    """Write the certificate to ``file`` (``-``: print it); the exit code. Raises ConfigError if it cannot be
    written."""
    from app.attention.proof.certificate import certify
    from app.attention.proof.prover import NotProven
    from app.attention.proof.statement import claim_of

    if not selection.proven:
        print(f"hbba solve: no certificate: the selection is not proven; {MORE_TIME}", file=sys.stderr)
        return 1
    try:
        text = certify(claim_of(stated.problem, selection), time_limit_s=deadline - time.perf_counter())
    except NotProven as failure:
        print(f"hbba solve: no certificate: {failure}", file=sys.stderr)
        return 1
    if file == "-":
        print(text, end="")
        return 0
    try:
        Path(file).write_text(text, encoding="utf-8")
    except OSError as failure:
        raise ConfigError(f"{file} cannot be written: {failure.strerror}") from None
    return 0


def _explained(stated: StatedProblem, selection: Selection, deadline: float) -> Selection:
    from app.attention.reasons import explain

    left = max(deadline - time.perf_counter(), 0.0)
    reasons = explain(stated.problem, selection, time_limit_s=left, resources=stated.table.resources)
    return replace(selection, reasons=reasons)


def _consequences(stated: StatedProblem, selection: Selection) -> tuple[dict[str, float], dict[str, dict[str, Any]]]:
    """φ of every filter, and the parameters of modules."""
    from app.attention.intention import divisors_of, parameters_of

    names = frozenset(selection.strategies)
    chosen = [s for s in stated.table.strategies if s.name in names]
    return divisors_of(chosen, stated.table.filters), parameters_of(chosen, stated.problem.desires)


def _answer_as_json(stated: StatedProblem, selection: Selection, deadline: float) -> dict[str, object]:
    import msgspec

    from app.attention.intention import Intention
    from app.attention.reports import intention_report
    from app.commands.solve_report import unexplained

    selection = _explained(stated, selection, deadline)
    divisors, parameters = _consequences(stated, selection)
    problem = stated.problem
    intention = Intention(
        stamp=0.0,
        selection=selection,
        strategies=tuple(s for s in stated.table.strategies if s.name in selection.strategies),
        divisors=divisors,
        parameters=parameters,
        reasons=selection.reasons,
        desires=problem.desires,
        capacities=problem.capacities,
    )
    answer: dict[str, object] = msgspec.to_builtins(intention_report(intention, stated.table.resources))
    return {k: v for k, v in answer.items() if k not in _OF_A_PROGRAM} | {"unexplained": unexplained(selection)}


def _speaks_unicode() -> bool:
    """Whether standard output can show φ, ∞ and bars."""
    try:
        "Ωφ∞█░".encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
