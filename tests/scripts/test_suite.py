"""Every test file runs once: in the browser, with the hurried ones, or with the patient ones."""

from __future__ import annotations

import subprocess
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from app.base.paths import checkout_dir

PYTHON = Path("python")


def asked(command: list[object]) -> list[str]:
    """The files and folders of tests that pytest is given."""
    return [str(word) for word in command if str(word).startswith("tests")]


def test_what_is_against_the_clock_exists_and_is_left_out_of_the_patient_ones(suite: ModuleType) -> None:
    root = checkout_dir()
    assert root is not None
    against_the_clock = [*asked(suite.browser(PYTHON)), *asked(suite.hurried(PYTHON))]
    assert [name for name in against_the_clock if not (root / name).exists()] == []
    patient = suite.patient(PYTHON, 2)
    assert asked(patient) == ["tests"]
    assert patient[: len(suite.GIVING_WAY)] == list(suite.GIVING_WAY)
    ignored = [word.removeprefix("--ignore=") for word in map(str, patient) if word.startswith("--ignore=")]
    assert ignored == against_the_clock
    files = {path for name in against_the_clock for path in (root / name).rglob("test_*.py")}
    files |= {root / name for name in against_the_clock if name.endswith(".py")}
    counted = sum(len(list((root / name).rglob("test_*.py"))) or 1 for name in against_the_clock)
    assert len(files) == counted, "none runs twice"


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch, failing: str | None) -> list[list[str]]:
    """What is run instead of tests; a command with the word ``failing`` fails."""
    ran: list[list[str]] = []

    def run(command: list[str], **_: object) -> SimpleNamespace:
        ran.append(command)
        return SimpleNamespace(returncode=int(failing in command))

    monkeypatch.setattr(subprocess, "run", run)
    return ran


@pytest.mark.parametrize(("failing", "status"), [(None, 0), ("tests/runtime/test_clock.py", 1), ("ros", 1)])
def test_robots_over_ros_2_go_after_the_hurried_ones_where_their_wheels_are(
    dev: ModuleType, commands: list[list[str]], status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dev.ros_environment, "python_with_ros", lambda *_: Path("ros"))
    assert dev.test_hurried() == status
    hurried, driven = commands
    assert "nice" not in hurried, "they are against the clock"
    assert driven[0] == "ros"


@pytest.mark.parametrize("failing", [None])
def test_without_their_wheels_robots_over_ros_2_are_left_out(
    dev: ModuleType, commands: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dev.ros_environment, "python_with_ros", lambda *_: None)
    assert dev.test_hurried() == 0
    assert len(commands) == 1
