"""``hbba new``: what it writes works as it is: its test passes, its configuration is in order, its body is found."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from app import cli
from app.commands.new import KINDS, TEMPLATES
from app.program.config import load_configuration
from app.program.module_meter import role_of
from app.program.system import System
from tests.distributions import announce
from tests.patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
NAMES = {"module": "DoorDetector", "motivation": "NearWatch", "behavior": "WallApproach", "body": "LookoutPost"}


@pytest.fixture(params=KINDS)
def package(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Iterator[Path]:
    """A package of each kind, just written and on the import path."""
    kind = request.param
    assert cli.main(["new", kind, NAMES[kind], "--in", str(tmp_path)]) == 0
    (folder,) = tmp_path.iterdir()
    assert capsys.readouterr().out.startswith(f"{folder}: {kind} {NAMES[kind]}. Next:\n")
    announce(folder)
    monkeypatch.syspath_prepend(str(folder))
    yield folder
    imported = folder.name.replace("-", "_")
    for name in [name for name in sys.modules if name.partition(".")[0] == imported]:
        del sys.modules[name]


@pytest.mark.slow
def test_its_own_test_passes_and_its_style_is_right(package: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(package), str(ROOT)))}
    for command in (
        ["pytest", "-q", "-p", "no:cacheprovider", str(package)],
        ["ruff", "check", "--no-cache", str(package)],
        ["ruff", "format", "--no-cache", "--check", str(package)],
    ):
        done = subprocess.run(
            [sys.executable, "-m", *command],
            env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE_S,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr


def test_its_configuration_is_in_order(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = package.name.removeprefix("hbba-").replace("-", "_")
    files = sorted(map(str, (package / f"hbba_{name}").glob("*.yaml")))
    assert cli.main(["check", name, *files]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.count(", no mistake found") == len(files) + 1
    system = System(load_configuration(package / f"hbba_{name}" / f"{name}.yaml"))
    assert system.cautions == ()
    columns = {"DoorDetector": "perception", "NearWatch": "motivations", "WallApproach": "behaviors"}
    roles = {module: role_of(slot.module_class) for module, slot in system.graph.modules.items()}
    assert roles["Hokuyo"] == "sensors"
    assert all(roles[module] == column for module, column in columns.items() if module in roles)
    assert "other" not in roles.values()


def test_a_class_that_no_strategy_serves_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "motivation", "NearWatch", "--in", str(tmp_path)]) == 0
    package = tmp_path / "hbba-near-watch"
    monkeypatch.syspath_prepend(str(package))
    file = package / "hbba_near_watch" / "near_watch.yaml"
    strategies = file.with_name("strategies.yaml")
    lines = strategies.read_text().splitlines(keepends=True)
    strategies.write_text("".join(line for line in lines if "FindQRCodes" not in line))
    capsys.readouterr()
    assert cli.main(["check", str(file)]) == 0
    said = capsys.readouterr()
    assert "no mistake found, 1 warning" in said.out
    assert "no strategy serves FindQRCodes, a class of QRCodeDetector and NearWatch: a desire of it" in said.err
    del sys.modules["hbba_near_watch"]


def test_what_it_declares_can_be_desired(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cli.main(["new", "module", "GateDetector", "--in", str(tmp_path)]) == 0
    monkeypatch.syspath_prepend(str(tmp_path / "hbba-gate-detector"))
    system = System(load_configuration(tmp_path / "hbba-gate-detector" / "hbba_gate_detector" / "gate_detector.yaml"))
    assert system.classes["GateDetector"].validated({"within_m": 3}) == {"within_m": 3.0}
    assert [strategy.name for strategy in system.table.strategies] == [
        "drive-by-hand",
        "gate-detector-1",
        "gate-detector-4",
    ]
    del sys.modules["hbba_gate_detector"]


def test_programs_read_what_was_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", "motivation", "NearWatch", "--in", str(tmp_path), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["folder"], said["configuration"]) == (str(tmp_path / "hbba-near-watch"), "near_watch")
    assert "hbba_near_watch/near_watch.py" in said["files"]
    assert all((tmp_path / "hbba-near-watch" / file).is_file() for file in said["files"])


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("door_detector", "is no name of a class: 2 to 40 letters and digits, each word with a capital"),
        ("Door-Detector", "is no name of a class"),
        ("../Door", "is no name of a class"),
        ("Tür", "is no name of a class"),
        ("D" * 41, "is no name of a class"),
        ("LaserScan", "the program itself has something called LaserScan"),
        ("Hokuyo", "the program itself has something called Hokuyo"),
        ("GoTo", "the program itself has something called GoTo"),
        ("Module", "the program itself has something called Module"),
        ("Lab", "there is a configuration or a channel called lab"),
        ("Scan", "there is a configuration or a channel called scan"),
    ],
)
def test_a_name_that_cannot_be_is_refused(
    name: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "behavior", name, "--in", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("hbba new: NAME: ")
    assert said in error
    assert not list(tmp_path.iterdir())


def test_nothing_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    there = tmp_path / "hbba-door-detector" / "mine.txt"
    there.parent.mkdir()
    there.write_text("mine")
    assert cli.main(["new", "module", "DoorDetector", "--in", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"hbba new: {there.parent}: is there already; nothing is overwritten\n"
    assert list(there.parent.iterdir()) == [there]


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").touch()
    assert cli.main(["new", "module", "DoorDetector", "--in", str(tmp_path / "file")]) == 2
    assert "cannot be written: Not a directory" in capsys.readouterr().err


def test_every_kind_has_templates() -> None:
    assert {folder.name for folder in TEMPLATES.iterdir()} == {"common", *KINDS}
