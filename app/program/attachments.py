"""The program's files and facts as they are now, to be attached to every recording: a log is replayable alone."""

from __future__ import annotations

import mimetypes
import os
import subprocess
from pathlib import Path, PurePath

from app.attention.calibration import calibration_file
from app.base import paths
from app.base.errors import ConfigError
from app.logs.manifest import YAML, AttachedFile, Manifest
from app.program.config import Configuration
from app.robots.config import RobotConfig
from app.robots.factory import Body, body_files, load_body
from app.runtime.graph import Graph


def snapshot(configuration: Configuration, graph: Graph, robot: str, body: Body | None = None) -> Manifest:
    """All files from which the program was built; ``robot`` is the body's name. Reads files.

    ``body`` is the body that ran, if it differs from its file (in another scenario, for instance).
    """
    program = configuration.program
    robot_file = configuration.path(program.robot).resolve()
    files = [
        Path(configuration.program_document.file).resolve(),
        configuration.path(program.channels).resolve(),
        *(configuration.path(file).resolve() for file in program.strategies),
        # Another body may replace the one that the program's file names.
        configuration.path(Path(configuration.program_document.data["robot"])).resolve(),
        robot_file,
        *_body_files(robot_file),
        *(() if body is None else body_files(body)),
    ]
    host = paths.host_name()
    if (measured := calibration_file(configuration.path(program.calibration), host)).is_file():
        files.append(measured.resolve())
    folder = configuration.folder
    facts = {
        "program": files[0].name,
        "robot": robot,
        "body": _name(robot_file, folder),
        "version": paths.version(),
        "commit": _commit(),
        "host": host,
    }
    if isinstance(body, RobotConfig):
        facts["scenario"] = "" if body.scenario is None else _name(body.scenario, folder)
    facts.update(stream_facts(graph))
    return Manifest(tuple(_attached(file, folder) for file in dict.fromkeys(files)), facts)


def _body_files(robot_file: Path) -> list[Path]:
    """Files that describe the body; none where the body's file names none, since the link was given by the caller."""
    try:
        return [*body_files(load_body(robot_file))]
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


def _attached(file: Path, folder: Path) -> AttachedFile:
    media_type = YAML if file.suffix in (".yaml", ".yml") else mimetypes.guess_type(file.name)[0]
    return AttachedFile(_name(file, folder), media_type or "application/octet-stream", file.read_bytes())


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
