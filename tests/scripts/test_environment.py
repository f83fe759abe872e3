"""The environment in ``.venv``: what is done once, and what a person reads when it cannot be done."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.scripts.stand_ins import Pip, Programs, use, use_pip

#: What is asked of pip after the locks.
LOCKED = ("--no-build-isolation", "-e", ".")
LOCKED_TEST = ("--no-build-isolation", "-e", ".[test]")


def test_packages_are_installed_once_and_again_when_the_project_asks_for_others(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pip = use_pip(environment.installing, monkeypatch, Pip())
    environment.install(set())
    environment.install(set())
    assert pip.asked == [LOCKED]
    environment.install({"test"})
    environment.install(set())
    assert pip.asked == [LOCKED, LOCKED_TEST]
    (checkout / "pyproject.toml").write_text("changed")
    environment.install(set())
    assert pip.asked == [LOCKED, LOCKED_TEST, LOCKED_TEST]
    (checkout / "requirements" / "run.lock").write_text("changed")
    environment.install(set())
    assert len(pip.asked) == 4
    assert pip.locked == [["build", "run"], *([["build", "run", "test"]] * 3)]


def test_another_computer_gets_what_the_project_allows(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pip = use_pip(environment.installing, monkeypatch, Pip())
    monkeypatch.setattr(environment.installing, "not_covered", lambda: "Darwin on arm64")
    environment.install({"test"})
    assert pip.locked == []
    assert pip.asked == [("-e", ".[test]")]
    assert "the locked versions are not for Darwin on arm64: installing what pyproject.toml" in capsys.readouterr().out


def test_another_index_gives_what_the_project_allows(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pip = use_pip(environment.installing, monkeypatch, Pip(unlike=environment.installing.NotAsLocked("other hashes")))
    environment.install(set())
    assert pip.asked == [("-e", ".")]
    assert "the package index serves other files than the locked ones" in capsys.readouterr().out


def test_an_index_out_of_reach_ends_the_set_up(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pip = use_pip(
        environment.installing, monkeypatch, Pip(unlike=environment.installing.PipFailed("cannot be reached"))
    )
    with pytest.raises(environment.SetupFailed, match="cannot be reached"):
        environment.install(set())
    assert pip.asked == []


def test_a_failed_installation_is_tried_again(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_pip(environment.installing, monkeypatch, Pip(environment.installing.PipFailed("conflicting dependencies")))
    with pytest.raises(environment.SetupFailed, match="conflicting dependencies"):
        environment.install(set())
    pip = use_pip(environment.installing, monkeypatch, Pip())
    environment.install(set())
    assert len(pip.asked) == 1


def test_no_venv_module_is_one_sentence(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    environment.PYTHON.unlink()
    use(monkeypatch, Programs(1, "ensurepip is not available"))
    with pytest.raises(environment.SetupFailed, match="apt-get install python3-venv"):
        environment.make_environment()


def test_an_environment_made_elsewhere_is_replaced(
    environment: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_pip(environment.installing, monkeypatch, Pip())
    programs = use(monkeypatch, Programs())
    environment.install(set())
    environment.make_environment()
    assert programs.commands == []
    monkeypatch.setattr(environment, "ROOT", checkout / "moved")
    environment.make_environment()
    assert programs.commands == [[sys.executable, "-m", "venv", "--clear", str(environment.VENV)]]


@pytest.mark.parametrize(("unwanted", "folder"), [("", None), ("1", "bytecode")])
def test_bytecode_is_kept_though_not_beside_the_sources_where_that_is_unwanted(
    environment: ModuleType, monkeypatch: pytest.MonkeyPatch, unwanted: str, folder: str | None
) -> None:
    monkeypatch.setenv("PYTHONPYCACHEPREFIX", "")
    monkeypatch.delenv("PYTHONPYCACHEPREFIX")
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", unwanted)
    environment.keep_bytecode()
    kept = dict(os.environ)
    assert "PYTHONDONTWRITEBYTECODE" not in kept
    assert kept.get("PYTHONPYCACHEPREFIX") == (folder and str(environment.VENV / folder))
