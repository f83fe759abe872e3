"""The command as a person meets it."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from app.commands import COMMANDS
from app.commands.completion import leaves
from app.commands.parser import build_parser
from tests.patience import PATIENCE_S

HBBA = Path(sys.executable).with_name("hbba")


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main(["--help"])
    assert left.value.code == 0
    shown = capsys.readouterr().out
    assert set(COMMANDS) <= {line.split()[0] for line in shown.splitlines() if line.startswith("    ")}


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_explains_itself(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main([command, "--help"])
    assert left.value.code == 0
    assert f"usage: hbba {command}" in capsys.readouterr().out


def test_linear_algebra_computes_in_the_calling_thread_unless_configured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    monkeypatch.setenv("MKL_NUM_THREADS", "")  # so that it is put back
    monkeypatch.delenv("MKL_NUM_THREADS")
    with pytest.raises(SystemExit):
        cli.main(["--version"])
    assert (os.environ["OPENBLAS_NUM_THREADS"], os.environ["MKL_NUM_THREADS"]) == ("3", "1")
    code = "import sys; import app.cli; app.commands.parser.build_parser(); sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=Path(cli.__file__).parents[1], check=False).returncode == 0


def test_a_damaged_picture_is_no_line_of_opencv(tmp_path: Path) -> None:
    code = (
        "import sys; from app import cli\n"
        "try: cli.main(['--version'])\n"
        "except SystemExit: pass\n"
        "import cv2, numpy\n"
        "whole = cv2.imencode('.png', numpy.zeros((64, 64, 3), numpy.uint8))[1]\n"
        "cv2.imdecode(whole[:60], cv2.IMREAD_COLOR)\n"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENCV_LOG_LEVEL"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment, cwd=tmp_path
    )
    assert done.stderr == ""


def test_version_is_the_distributions(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["--version"])
    assert capsys.readouterr().out == f"hbba {version('hbba')}\n"


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "required: COMMAND"),
        (["dance"], "invalid choice: 'dance' (choose from run, replay, log,"),
        (["slove", "x.yaml"], "argument COMMAND: invalid choice: 'slove'; did you mean solve? (choose from run,"),
        (
            ["detect", "face", "x.jpg"],
            "invalid choice: 'face'; did you mean faces? (choose from faces, qr, voices, noises)",
        ),
        (["log", "exprot", "tour", "png"], "invalid choice: 'exprot'; did you mean export?"),
        (["run", "--port", "70000"], "a port is a number from 0 to 65535, not '70000'"),
        (["run", "--port", "http"], "a port is a number from 0 to 65535, not 'http'"),
        (["run", "--token-file", ""], "the name of a file is empty"),
        (
            ["run", "--host-name", "http://robot"],
            "a host name is one as robot.example, without a port, not 'http://robot'",
        ),
        (["run", "--host-name", "robot:80"], "a host name is one as robot.example, without a port, not 'robot:80'"),
        (["run", "--log-level", "loud"], "invalid choice: 'loud'"),
    ],
)
def test_a_wrong_command_line_is_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    assert left.value.code == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "usage", "sentence"),
    [
        (
            ["experiment", "goals", "--goals", "0"],
            "hbba experiment goals",
            "error: unrecognized arguments: --goals 0\n",
        ),
        (["run", "--prot=80"], "hbba run", "--prot=80; did you mean --port?"),
        (["log", "info", "a.mcap", "b.mcap"], "hbba log info", "unrecognized arguments: b.mcap\n"),
    ],
)
def test_an_unknown_argument_is_reported_with_the_commands_own_usage(
    arguments: list[str], usage: str, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    said = capsys.readouterr().err
    assert left.value.code == 2
    assert said.startswith(f"usage: {usage} [-h]")
    assert sentence in said


@pytest.mark.parametrize("command", list(leaves(build_parser())), ids=lambda parser: parser.prog)
def test_json_means_the_same_in_every_command_that_reports(command: argparse.ArgumentParser) -> None:
    reports = command.prog.removeprefix("hbba ") not in (
        "run", "node", "completion", "password", "log rerun", "body show", "ros package",
    )  # fmt: skip
    options = {option: action for action in command._actions for option in action.option_strings}
    assert ("--json" in options) == reports
    if reports:
        assert options["--json"].nargs == 0


def test_a_configuration_that_is_not_there_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "--config", "nowhere.yaml", "--port", "0"]) == 2
    error = "hbba run: --config: there is no program nowhere.yaml; a file, or one of: jackal, lab, serial_base, "
    error += "stretch, turtlebot4, webcam; those of a package are known once it is installed\n"
    assert capsys.readouterr().err == error


def test_a_reader_that_leaves_early_is_no_error() -> None:
    world = str(paths.config_dir() / "worlds" / "lab.yaml")
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run(
            [HBBA, "check", world], stdout=writing, stderr=subprocess.PIPE, timeout=PATIENCE_S, check=False
        )
    finally:
        os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
