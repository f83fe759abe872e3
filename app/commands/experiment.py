"""``hbba experiment``: the thesis's experiments, our own and those of packages, unattended.

An experiment is what an entry point of the group ``hbba.experiments`` names: a module (or object) with ``add_parser``
and ``run``, as each command has them. The parser has the entry point's name.
"""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from app.base.errors import ConfigError
from app.base.extensions import Extension, extensions
from app.commands.parser import Parser

if TYPE_CHECKING:
    from app.experiments.results_store import ResultsStore


def add_parser(subparsers: Any) -> None:
    parser: Parser = subparsers.add_parser(
        "experiment",
        help="run an experiment and report it",
        description="Run an experiment in the simulated world, unattended, and report it as a table and a picture.",
    )
    experiments = parser.add_subparsers(dest="experiment", metavar="EXPERIMENT", required=True)
    # Packages are imported only for those who ask for experiments.
    parser.filler = lambda: _fill(parser, experiments)


def run(args: argparse.Namespace) -> int:
    """Run the experiment that ``args`` name. Raises ConfigError."""
    import cv2

    from app.experiments.pool import TrialLost
    from app.experiments.script import ScriptBlocked
    from app.link import LinkFailed
    from app.maps.map_service import MapUnavailable

    cv2.setNumThreads(1)
    try:
        code: int = args.run_experiment(args)
        return code
    except (LinkFailed, MapUnavailable, ScriptBlocked, TrialLost) as failure:
        print(f"hbba experiment {args.experiment}: {failure}", file=sys.stderr)
        return 1


def open_results(args: argparse.Namespace, of: dict[str, object]) -> ResultsStore:
    """The store of the experiment's results of the identity ``of``; says so if it moved others aside.

    Raises ConfigError.
    """
    from app.experiments.results_store import ResultsStore, default_folder

    kept = ResultsStore(args.out or default_folder(args.experiment), of, fresh=args.fresh)
    if kept.moved and not args.fresh:
        said = f"other results were there; they are in {kept.moved} now"
        print(f"hbba experiment {args.experiment}: {said}", file=sys.stderr)
    return kept


def _fill(parser: Parser, experiments: Any) -> None:
    """Declare every experiment; one that cannot be used says so when it is asked for."""
    try:
        found = extensions("hbba.experiments")
    except ConfigError as failure:
        parser.error(str(failure))
    for name, extension in found.items():
        try:
            _declare(experiments, extension)
        except ConfigError as failure:
            parser = experiments.choices.get(name) or experiments.add_parser(name, help="cannot be used")
            parser.set_defaults(run_experiment=_refusing(failure))


def _declare(experiments: Any, extension: Extension) -> None:
    command: Any = extension.load()
    if not (callable(getattr(command, "add_parser", None)) and callable(getattr(command, "run", None))):
        raise ConfigError(f"{extension.value} of {extension.distribution} has no add_parser and run")
    command.add_parser(experiments)
    if extension.name not in experiments.choices:
        raise ConfigError(f"add_parser of {extension.value} declares no experiment {extension.name!r}")
    experiments.choices[extension.name].set_defaults(run_experiment=command.run)


def _refusing(failure: ConfigError) -> Any:
    def refuse(args: argparse.Namespace) -> int:
        raise failure

    return refuse
