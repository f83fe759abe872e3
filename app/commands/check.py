"""``hbba check FILE…``: is this configuration right, and if not, where is the mistake; is what was proven so."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.check_proofs import check_proofs
from app.commands.output import add_json, print_json
from app.commands.packaged import config_file

#: Raises ConfigError for a mistake; returns warnings, if there can be any.
_Check = Callable[[Path], "tuple[str, ...] | None"]


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "check",
        help="validate configuration files; check what attention proved",
        description="Validate configuration: programs, robots, worlds, strategies, channels, problems to solve. "
        "Each mistake is said as FILE:LINE: what is wrong and what is allowed. Exit code 2 if there is any. "
        "A certificate of `hbba solve --certificate` is checked without the solver; so is each proven selection of a "
        "recording, once it is certified.",
    )
    parser.add_argument("files", nargs="+", metavar="FILE", help="a file, or a name as jackal or robots/webcam")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Check each file; say all mistakes, not only the first file's."""
    results: list[dict[str, object]] = []
    for named in args.files:
        kind = mistake = None
        result = ""
        warnings: list[str] = []
        path = Path(named)
        try:
            path = config_file(named, "configuration")
            proofs = check_proofs(path)
            if proofs is not None:
                kind, result, warnings = proofs.kind, proofs.result, list(proofs.cautions)
            else:
                kind, cautions = check_file(path)
                result, warnings = "no mistake found", list(cautions)
        except ConfigError as failure:
            mistake = str(failure)
            print(mistake, file=sys.stderr)
        if kind is not None and not args.json:
            print(f"{path}: {kind}, {result}{_counted(warnings)}{_packages(path, kind)}")
        for warning in warnings:
            print(warning, file=sys.stderr)
        results.append({"file": str(path), "kind": kind, "mistake": mistake, "warnings": warnings})
    if args.json:
        print_json({"files": results})
    return 2 if any(result["mistake"] for result in results) else 0


def _counted(cautions: Sequence[str]) -> str:
    return f", {len(cautions)} warning{'s' * (len(cautions) > 1)}" if cautions else ""


def _packages(path: Path, kind: str) -> str:
    """The packages of others whose modules and files a program uses, for people."""
    from app.base.extensions import split_package_file
    from app.base.yaml_source import load_yaml
    from app.program.config import ProgramConfig

    if kind != "program":
        return ""
    program = load_yaml(path).validate(ProgramConfig)
    named = [spec.class_path.partition(":")[0].partition(".")[0] for spec in program.modules.values()]
    files = [split_package_file(file) for file in (program.robot, *program.channels, *program.strategies)]
    others = sorted({*named, *(inside[0] for inside in files if inside)} - {"app", "hbba"})
    return f"; it uses {', '.join(others)}" if others else ""


def check_file(path: Path) -> tuple[str, Sequence[str]]:
    """Validate one file, and everything it names; return the kind of configuration, and warnings in sentences. Raises
    ConfigError."""
    from app.base.yaml_source import load_yaml

    if path.suffix == ".urdf":
        return _robot_model(path), ()
    document = load_yaml(path)
    if not isinstance(document.data, Mapping):
        raise document.error("is no configuration: it must be a mapping")
    kind, check = _kind_of(document.data)
    if check is None:
        raise document.error(f"is no known kind of configuration; it must have the keys of {kind}")
    return kind, check(path) or ()


def _kind_of(data: Mapping[Any, Any]) -> tuple[str, _Check | None]:
    """The kind of file by the keys that only this kind has, with its check; or all kinds for people, and None."""
    # A channel may have the name of another kind's key.
    if data and all(isinstance(row, Mapping) and "type" in row for row in data.values()):
        return "channels", _channels
    for kind, keys, check in _KINDS:
        if keys & data.keys():
            return kind, check
    kinds = [f"{kind} ({', '.join(sorted(keys))})" for kind, keys, _ in _KINDS]
    return f"{', '.join(kinds)} or channels (a `type` each)", None


def _program(path: Path) -> tuple[str, ...]:
    """Read the whole program and wire it, without starting anything; return its cautions."""
    from app.program.config import load_configuration
    from app.program.system import System

    configuration = load_configuration(path)
    _robot(configuration.path(configuration.program.robot))
    return tuple(str(caution) for caution in System(configuration, nodes=True).cautions)


def _robot(path: Path) -> None:
    from app.robots.config import RobotConfig
    from app.robots.factory import load_body

    robot = load_body(path)
    _robot_model(robot.model)
    if isinstance(robot, RobotConfig):
        _world(robot.world)
        if robot.scenario is not None:
            _scenario(robot.scenario)


def _robot_model(path: Path) -> str:
    from app.base.kinematic_model import load_model

    load_model(path)
    return "robot model"


def _world(path: Path) -> None:
    from app.base.yaml_source import parse
    from app.robots.simulated.world_config import WorldConfig

    parse(path, WorldConfig)


def _scenario(path: Path) -> None:
    from app.robots.simulated.scenery.scenario_config import load_scenario

    load_scenario(path)


def _array(path: Path) -> None:
    from app.modules.perception.voices.microphone_array import load_array

    load_array(path)


def _tour(path: Path) -> None:
    from app.tours.tour_file import load_tour

    load_tour(path)


def _problem(path: Path) -> None:
    from app.attention.problem_file import read_problem
    from app.base.yaml_source import load_yaml

    read_problem(load_yaml(path), path.resolve().parent)


def _strategies(path: Path) -> tuple[str, ...]:
    """Check a table by itself, then every program in the folder above that uses it, for its classes and ports."""
    from app.attention.strategy_file import load_strategies

    load_strategies([path], classes=None)
    programs = _programs_naming(path)
    if not programs:
        return (f"{path}: no program beside it names this file: desire classes, modules and ports are not checked",)
    return _programs(programs)


def _rules(path: Path) -> tuple[str, ...]:
    """Check a file of rules by itself, then every program in the folder above that goes by it."""
    from app.attention.rule_book import load_rules

    load_rules([path], None)
    programs = _programs_naming(path)
    if not programs:
        return (f"{path}: no program beside it names this file: desire classes, channels and events are not checked",)
    return _programs(programs)


def _remap(path: Path) -> None:
    from app.logs.importers.remap import load_remap

    load_remap(path)


def _channels(path: Path) -> tuple[str, ...]:
    """Check a table by itself, then every program beside it that uses it."""
    from app.base.yaml_source import load_yaml
    from app.program.config import ChannelTableFile

    document = load_yaml(path)
    for name, spec in document.validate(ChannelTableFile).root.items():
        try:
            _ = spec.message_type
        except KeyError:
            raise document.error(f"{name}.type: {spec.no_message()}", (name, "type")) from None
        except ConfigError as failure:
            raise document.error(f"{name}.type: {failure.message}", (name, "type")) from failure
    return _programs(_programs_naming(path))


def _programs(programs: Sequence[Path]) -> tuple[str, ...]:
    return tuple(caution for program in programs for caution in _program(program))


def _programs_naming(path: Path) -> list[Path]:
    """The programs, beside ``path`` or in the folder above, that name this file."""
    from app.base.yaml_source import load_yaml

    wanted = path.resolve()
    found = []
    for folder in (wanted.parent, wanted.parent.parent):
        for candidate in sorted(folder.glob("*.yaml")):
            try:
                data = load_yaml(candidate).data
            except ConfigError:
                continue  # another file has the mistake; the check is about this one
            if not isinstance(data, Mapping) or "modules" not in data:
                continue
            channels = data.get("channels")
            tables = channels if isinstance(channels, list) else [channels]
            named = [*tables, *(data.get("strategies") or ()), *(data.get("rules") or ())]
            if wanted in [_named_file(str(name), folder) for name in named if name]:
                found.append(candidate)
    return found


def _named_file(name: str, folder: Path) -> Path | None:
    """The file that a program in ``folder`` names; None for one of a package that is not installed."""
    from app.base.extensions import package_file

    try:
        return package_file(name, folder).resolve()
    except ConfigError:
        return None  # the program's own check says so


def _calibration(path: Path) -> None:
    from app.attention.calibration import CostCalibration
    from app.base.yaml_source import parse

    parse(path, CostCalibration)


def _play(path: Path) -> None:
    """Check a play of the body experiment against the desire classes of the lab's program."""
    from app.base import paths
    from app.experiments.body.play import load_play
    from app.program.config import load_configuration
    from app.program.system import System

    load_play(path, set(System(load_configuration(paths.config_dir() / "lab.yaml")).classes))


#: Kind, the keys by which it is known, its check.
_KINDS: tuple[tuple[str, frozenset[str], _Check], ...] = (
    ("program", frozenset({"modules", "robot"}), _program),
    ("robot", frozenset({"model", "world", "base", "kind"}), _robot),
    ("scenario", frozenset({"people", "sounds", "drive"}), _scenario),
    ("array of microphones", frozenset({"positions"}), _array),
    ("problem", frozenset({"desires"}), _problem),
    ("calibration", frozenset({"relations"}), _calibration),
    ("world", frozenset({"walls", "materials", "wall_height"}), _world),
    ("strategies", frozenset({"strategies", "resources"}), _strategies),
    ("remap", frozenset({"channels", "frames"}), _remap),
    ("play", frozenset({"cues"}), _play),
    ("tour", frozenset({"stops"}), _tour),
    ("rules", frozenset({"rules"}), _rules),
)
