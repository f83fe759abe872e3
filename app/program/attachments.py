"""The program's files and facts as they are now, to be attached to every recording: a log is replayable alone."""

from __future__ import annotations

import mimetypes
import os
import posixpath
import subprocess
from dataclasses import replace
from pathlib import Path, PurePath

from app.attention.calibration import calibration_file
from app.attention.problem import SelectionProblem
from app.attention.proof.statement import TABLE_FILE, table_data
from app.base import paths
from app.base.errors import ConfigError
from app.base.extensions import ATTACHED, split_package_file
from app.logs.manifest import JSON, YAML, AttachedFile, Manifest
from app.program.config import Configuration
from app.robots.config import RobotConfig
from app.robots.factory import Body, load_body
from app.runtime.graph import Graph


def snapshot(configuration: Configuration, graph: Graph, robot: str, body: Body | None = None) -> Manifest:
    """All files from which the program was built; ``robot`` is the body's name. Reads files.

    ``body`` is the body that ran, if it differs from its file (in another scenario, for instance).
    """
    program = configuration.program
    folder = configuration.folder
    document = Path(configuration.program_document.file).resolve()
    files = {
        document.name: document,
        # Another body may replace the one that the program's file names.
        **dict(
            _named(configuration, file)
            for file in (
                *program.channels,
                *program.strategies,
                *program.rules,
                Path(configuration.program_document.data["robot"]),
            )
        ),
    }
    robot_name, robot_file = _named(configuration, program.robot)
    files[robot_name] = robot_file
    for part in dict.fromkeys((*_body_files(robot_file), *(() if body is None else body.files))):
        files.setdefault(_of_body(part, configuration), part)
    host = paths.host_name()
    if (measured := calibration_file(configuration.path(program.calibration), host)).is_file():
        files[_name(measured.resolve(), folder)] = measured.resolve()
    facts = {
        "program": document.name,
        "robot": robot,
        "body": robot_name,
        "version": paths.version(),
        "commit": _commit(),
        "host": host,
    }
    if isinstance(body, RobotConfig):
        facts["scenario"] = "" if body.scenario is None else _of_body(body.scenario, configuration)
    facts.update(stream_facts(graph))
    return Manifest(tuple(_attached(name, file) for name, file in files.items()), facts)


def with_table(manifest: Manifest, problem: SelectionProblem) -> Manifest:
    """``manifest`` with the table of ``problem`` as attention has it: with calibrated costs, and without what the
    program leaves out. Selections in the recording are checked with it."""
    return replace(manifest, files=(*manifest.files, AttachedFile(TABLE_FILE, JSON, table_data(problem))))


def _named(configuration: Configuration, path: Path) -> tuple[str, Path]:
    """A path of the configuration: what it is called in a recording, and the file."""
    file = configuration.path(path).resolve()
    if inside := split_package_file(path):
        return PurePath(ATTACHED, *inside).as_posix(), file
    return _name(file, configuration.folder), file


def _of_body(file: Path, configuration: Configuration) -> str:
    """The name in a recording of a file that the body's own names: its path relative to that."""
    named = configuration.program.robot
    if split_package_file(named) is None:
        return _name(file, configuration.folder)
    robot_name, robot_file = _named(configuration, named)
    return posixpath.normpath(posixpath.join(posixpath.dirname(robot_name), _name(file, robot_file.parent)))


def _body_files(robot_file: Path) -> list[Path]:
    """Files that describe the body; none where the body's file names none, since the link was given by the caller."""
    try:
        return [*load_body(robot_file).files]
    except ConfigError:
        return []


def stream_facts(graph: Graph) -> dict[str, str]:
    """``stream.<name>``: the channel that the body's stream is published on."""
    return {
        f"stream.{stream}": slot.spec.outputs[port]
        for slot in graph.modules.values()
        for port, stream in slot.module_class.streams.items()
        if port in slot.spec.outputs
    }


def _attached(name: str, file: Path) -> AttachedFile:
    media_type = YAML if file.suffix in (".yaml", ".yml") else mimetypes.guess_type(file.name)[0]
    return AttachedFile(name, media_type or "application/octet-stream", file.read_bytes())


def _name(file: Path, folder: Path) -> str:
    return PurePath(os.path.relpath(file, folder)).as_posix()


def _commit() -> str:
    root = paths.checkout_dir()
    if root is None:
        return ""
    try:
        done = subprocess.run(
            ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12"],
            capture_output=True, text=True, check=False, timeout=2,
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
