"""The program's configuration: what cannot be is named with file, line and key, before anything is built."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.messages import LaserScan
from app.program.config import Configuration, load_configuration
from app.runtime.graph import Graph
from app.runtime.module import Module

PROGRAM = """\
robot: robot.yaml
channels: channels.yaml
strategies: [strategies.yaml]
modules:
  Echo:
    class: tests.program.test_config:Echo
    inputs: {}
"""


class Echo(Module):
    """A module without ports."""


@dataclass(frozen=True, slots=True)
class Bell:
    """A message of another package."""

    stamp: float
    strokes: int


def written(folder: Path, program: str = PROGRAM, channels: str = "scan: {type: LaserScan, rate_hz: 40}\n") -> Path:
    """A program's files in ``folder``."""
    for name, text in {
        "program.yaml": program,
        "channels.yaml": channels,
        "robot.yaml": "",
        "strategies.yaml": "",
    }.items():
        (folder / name).write_text(text)
    return folder / "program.yaml"


def refused(folder: Path, program: str = PROGRAM, channels: str | None = None) -> ConfigError:
    """The error that loading raises."""
    path = written(folder, program) if channels is None else written(folder, program, channels)
    with pytest.raises(ConfigError) as raised:
        load_configuration(path)
    return raised.value


def test_the_lab_is_in_order() -> None:
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    assert {"Kinect", "Teleop", "MobileBaseControl"} <= set(configuration.program.modules)
    assert configuration.channels["scan"].rate_hz == 40
    assert configuration.path(configuration.program.robot).is_file()


def test_every_module_of_the_lab_has_a_budget() -> None:
    modules = load_configuration(paths.config_dir() / "lab.yaml").program.modules
    assert [name for name, spec in modules.items() if spec.cpu_budget is None] == []


def test_a_misspelt_key_is_found_at_its_line(tmp_path: Path) -> None:
    error = refused(tmp_path, PROGRAM.replace("    inputs: {}", "    input: {}"))
    assert (error.line, error.key) == (7, "modules.Echo.input")
    assert "inputs" in error.message


def test_a_missing_file_is_named_where_it_is_asked_for(tmp_path: Path) -> None:
    error = refused(tmp_path, PROGRAM.replace("[strategies.yaml]", "[strategies.yaml, more.yaml]"))
    assert error.line == 3
    assert "more.yaml" in error.message


def test_a_channel_that_cannot_be_is_found_in_its_own_file(tmp_path: Path) -> None:
    error = refused(tmp_path, channels="scan:\n  type: LaserScan\n  rate_hz: -1\n")
    assert (Path(error.file).name, error.line) == ("channels.yaml", 3)
    assert "greater than 0" in error.message


@pytest.mark.parametrize(
    ("program", "channels", "file", "line", "words"),
    [
        (PROGRAM.replace(":Echo", ":Ecco"), "{}", "program.yaml", 6, "is not a module class"),
        (PROGRAM.replace("inputs: {}", "inputs: {ear: scan}"), "{}", "program.yaml", 7, "no input 'ear'"),
        (PROGRAM, "scan:\n  type: LaserScam\n", "channels.yaml", 2, "LaserScam"),
    ],
)
def test_a_wiring_mistake_is_found_in_its_file(
    tmp_path: Path, program: str, channels: str, file: str, line: int, words: str
) -> None:
    configuration = load_configuration(written(tmp_path, program, channels))
    with pytest.raises(ConfigError) as raised:
        built(configuration)
    assert (Path(raised.value.file).name, raised.value.line) == (file, line)
    assert words in raised.value.message


def built(configuration: Configuration) -> Graph:
    """The graph of a configuration."""
    from app.runtime.clock import RealClock

    return Graph(
        clock=RealClock(),
        channels=configuration.channels,
        modules=configuration.program.modules,
        services={},
        error=configuration.wiring_error,
    )


def test_a_program_has_several_tables_of_channels_and_files_of_packages(tmp_path: Path) -> None:
    program = PROGRAM.replace(
        "channels: channels.yaml", "channels: [package:hbba/channels.yaml, channels.yaml]"
    ).replace("[strategies.yaml]", "[package:hbba/strategies/lab.yaml]")
    configuration = load_configuration(written(tmp_path, program, "bells:\n  type: tests.program.test_config:Bell\n"))
    assert configuration.channels["bells"].message_type is Bell
    assert configuration.channels["scan"].message_type is LaserScan
    assert configuration.path(configuration.program.strategies[0]) == paths.config_dir() / "strategies" / "lab.yaml"


def test_a_channel_of_two_tables_is_refused(tmp_path: Path) -> None:
    error = refused(tmp_path, PROGRAM.replace("channels.yaml", "[package:hbba/channels.yaml, channels.yaml]"))
    assert (Path(error.file).parent, error.line) == (tmp_path, 1)
    assert error.message.startswith("channel 'scan' is already in ")


@pytest.mark.parametrize(
    ("named", "words"),
    [
        ("package:zeppelins/a.yaml", "there is no package 'zeppelins' installed"),
        ("package:hbba/strategies/nowhere.yaml", "there is no file package:hbba/strategies/nowhere.yaml"),
    ],
)
def test_a_missing_file_of_a_package_is_named_where_it_is_asked_for(tmp_path: Path, named: str, words: str) -> None:
    error = refused(tmp_path, PROGRAM.replace("[strategies.yaml]", f"[{named}]"))
    assert error.line == 3
    assert words in error.message


@pytest.mark.parametrize(
    ("written", "closed", "costs"),
    [("on", True, True), ("off", False, False), ("{costs: false}", True, False), ("null", False, False)],
)
def test_the_closed_loop_is_on_or_off(tmp_path: Path, written: str, closed: bool, costs: bool) -> None:
    path = written_program(tmp_path, f"attention: {{closed_loop: {written}}}\n")
    loop = load_configuration(path).program.attention.closed_loop
    assert (loop is not None, loop is not None and loop.costs) == (closed, costs)


def test_a_closed_loop_that_cannot_be_is_found_at_its_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as refusal:
        load_configuration(written_program(tmp_path, "attention: {closed_loop: {least_share: 0}}\n"))
    assert refusal.value.key == "attention.closed_loop.least_share"


def written_program(folder: Path, more: str) -> Path:
    """The program with ``more`` in its file."""
    return written(folder, PROGRAM + more)
