"""``hbba check``: each kind of file, and mistakes named by file and line."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from app import cli
from app.base import paths
from tests.patience import PATIENCE_S

CONFIG = paths.config_dir()
FILES = sorted([*CONFIG.rglob("*.yaml"), *CONFIG.rglob("*.urdf")])


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """A copy of the configuration, to make mistakes in."""
    return Path(shutil.copytree(CONFIG, tmp_path / "config"))


def replace(file: Path, old: str, new: str) -> int:
    """Put a mistake into ``file``; returns its line."""
    text = file.read_text(encoding="utf-8")
    assert text.count(old) >= 1, f"{old!r} is not in {file.name}"
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    return text[: text.index(old)].count("\n") + 1


@pytest.mark.parametrize("file", FILES, ids=lambda file: str(file.relative_to(CONFIG)))
def test_what_the_project_ships_is_right(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", str(file)]) == 0, capsys.readouterr().err
    assert capsys.readouterr().out.endswith("no mistake found\n")


def test_what_this_computer_lacks_is_no_result(capfd: pytest.CaptureFixture[str]) -> None:
    """The file is looked at, not the computer: that is what `hbba doctor` is for."""
    code = "import sys; sys.modules['sounddevice'] = None; from app.cli import main; sys.exit(main(sys.argv[1:]))"
    files = [str(CONFIG / name) for name in ("webcam.yaml", "robots/webcam.yaml", "channels.yaml")]
    done = subprocess.run([sys.executable, "-c", code, "check", *files], timeout=PATIENCE_S, check=False)
    out, err = capfd.readouterr()
    assert (done.returncode, err) == (0, "")
    assert [line.split(":")[0] for line in out.splitlines()] == files


def test_each_files_kind_or_mistake_is_printed_for_programs(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = replace(config / "lab.yaml", "  port: 8080", "  port: 80800")
    files = [str(config / name) for name in ("lab.yaml", "worlds/lab.yaml")]
    assert cli.main(["check", "--json", *files]) == 2
    out, err = capsys.readouterr()
    wrong, right = json.loads(out)["files"]
    assert wrong["kind"] is None
    assert wrong["mistake"].startswith(f"{files[0]}:{line}: ")
    assert err == wrong["mistake"] + "\n"
    assert right == {"file": files[1], "kind": "world", "mistake": None, "warnings": []}


def kind(file: Path, capsys: pytest.CaptureFixture[str]) -> str:
    cli.main(["check", str(file)])
    return capsys.readouterr().out.split(": ")[1].split(",")[0]


def test_kinds_are_recognised_by_their_keys(capsys: pytest.CaptureFixture[str]) -> None:
    assert [
        kind(CONFIG / name, capsys)
        for name in ("lab.yaml", "channels.yaml", "robots/irl1_tr.yaml", "robots/irl1_tr.urdf", "worlds/lab.yaml")
    ] == ["program", "channels", "robot", "robot model", "world"]


def test_a_problem_to_solve_is_a_kind_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "problem.yaml"
    file.write_text("desires: [{class: GoTo, intensity: 1}]\nstrategies: [{name: go, class: GoTo, utility: 8}]\n")
    assert kind(file, capsys) == "problem"
    file.write_text("desires: [{class: GoTo, intensity: much}]\n")
    assert cli.main(["check", str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"{file}:1: ")


@pytest.mark.parametrize(
    ("name", "old", "new", "sentence"),
    [
        ("lab.yaml", "inputs: {images: kinect", "inputs: {imagse: kinect", "imagse"),
        ("lab.yaml", "outputs: {images: kinect}", "outputs: {images: kinekt}", "kinekt"),
        ("lab.yaml", "app.modules.sensors.kinect:Kinect", "app.modules.sensors.kinect:Kinekt", "is not a module class"),
        ("lab.yaml", "  port: 8080", "  port: 80800", "65535"),
        ("channels.yaml", "type: LaserScan", "type: LaserScam", "LaserScam"),
        ("channels.yaml", "rate_hz: 15", "rate_hz: fast", "number"),
        ("robots/irl1_tr.yaml", "limits:\n  linear_mps: 0.40", "limits:\n  linear_mps: -1", "greater than 0"),
        ("worlds/lab.yaml", "wall_height: 2.7", "wall_height: tall", "number"),
        ("strategies/lab.yaml", "class: ", "class: No", "unknown class"),
    ],
)
def test_a_mistake_is_named_by_file_and_line(
    name: str, old: str, new: str, sentence: str, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = replace(config / name, old, new) + (old.count("\n"))
    assert cli.main(["check", str(config / name)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"{config / name}:{line}: "), error
    assert sentence in error


def test_a_strategys_filters_are_checked_against_the_program_that_uses_it(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = config / "strategies" / "lab.yaml"
    line = replace(file, "QRCodeDetector.images", "QRCodeDetector.imagse")
    assert cli.main(["check", str(file)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"{file}:{line}: ")
    assert "did you mean 'images'" in error


def test_all_files_are_checked_not_only_the_first_that_is_wrong(
    config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = tmp_path / "broken.yaml"
    broken.write_text("a: [1\n", encoding="utf-8")
    poem = tmp_path / "poem.yaml"
    poem.write_text("roses: red\n", encoding="utf-8")
    assert cli.main(["check", str(broken), str(poem), str(config / "worlds" / "lab.yaml")]) == 2
    out, err = capsys.readouterr()
    assert [line.split(":")[0] for line in err.splitlines()] == [str(broken), str(poem)]
    assert "is no known kind of configuration" in err
    assert out.startswith(str(config / "worlds" / "lab.yaml"))


def test_a_base_without_scans_is_a_mistake_and_one_without_its_monitor_a_warning(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = config / "lab.yaml"
    base = file.read_text(encoding="utf-8").splitlines().index("  MobileBaseControl:") + 1
    replace(file, "      scans: scan\n", "")
    assert cli.main(["check", str(file)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"{file}:{base + 2}: "), "at its inputs"
    assert "say `collision_monitor: off`" in error
    replace(file, "    settings:\n      behaviors:", "    settings:\n      collision_monitor: off\n      behaviors:")
    assert cli.main(["check", str(file)]) == 0
    said = capsys.readouterr()
    assert said.err.startswith(f"{file}:{base}: IRL-1/TR runs with its collision monitor switched off")
    assert said.out.endswith("no mistake found, 1 warning\n")
    replace(file, "collision_monitor: off", "collision_monitor: perhaps")
    assert cli.main(["check", str(file)]) == 2
    assert "'on' or 'off'" in capsys.readouterr().err


def test_an_output_that_can_move_the_robot_and_is_only_ever_closed_is_a_warning(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replace(config / "strategies" / "lab.yaml", "GoToward.twist: 1", "GoToward.twist: off")
    file = config / "lab.yaml"
    text = file.read_text(encoding="utf-8")
    line = text[: text.index("toward_twist, status: going_toward")].count("\n") + 1
    assert cli.main(["check", str(file)]) == 0
    assert capsys.readouterr().err.startswith(f"{file}:{line}: no strategy opens GoToward.twist, which leads to")


def test_a_table_that_no_program_names_is_checked_by_itself_and_said_so(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alone = config / "alone" / "strategies.yaml"
    alone.parent.mkdir()
    alone.write_text("strategies: [{name: fly, class: Fly, utility: 8}]\n")
    assert cli.main(["check", str(alone)]) == 0
    said = capsys.readouterr()
    assert said.out == f"{alone}: strategies, no mistake found, 1 warning\n"
    assert said.err == (
        f"{alone}: no program beside it names this file: desire classes, modules and ports are not checked\n"
    )


def test_a_file_that_a_program_names_by_its_package_is_checked_with_it(
    config: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    package = config.parent / "kites_k"
    config.rename(package)
    (package / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(package.parent))
    replace(package / "lab.yaml", "- strategies/lab.yaml", "- package:kites_k/strategies/lab.yaml")
    replace(package / "strategies" / "lab.yaml", "class: FindQRCodes", "class: FindQRCades")
    assert cli.main(["check", str(package / "strategies" / "lab.yaml")]) == 2
    assert "unknown class 'FindQRCades'" in capsys.readouterr().err
