"""Set-up behind the Makefile: what is done once, and what a person reads when it cannot be done."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

#: What is asked of pip after the locks.
LOCKED = ("--no-build-isolation", "-e", ".")
LOCKED_TEST = ("--no-build-isolation", "-e", ".[test]")


class Programs:
    """Replaces subprocess.run: notes the commands and answers for them."""

    def __init__(self, status: int = 0, output: str = "") -> None:
        self.commands: list[list[str]] = []
        self.status = status
        self.output = output

    def __call__(self, command: list[object], **_: Any) -> SimpleNamespace:
        self.commands.append([str(word) for word in command])
        return SimpleNamespace(returncode=self.status, stdout=self.output, stderr="")


@pytest.fixture
def checkout(dev: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with an environment that holds nothing yet."""
    venv = tmp_path / ".venv"
    (venv / "bin").mkdir(parents=True)
    (venv / "bin" / "python").write_text("")
    (tmp_path / "requirements").mkdir()
    for name in ("pyproject.toml", "hatch_build.py", "requirements/run.lock"):
        (tmp_path / name).write_text(name)
    for name, value in {
        "ROOT": tmp_path,
        "VENV": venv,
        "STAMP": venv / "installed.json",
        "PYTHON": venv / "bin" / "python",
    }.items():
        monkeypatch.setattr(dev, name, value)
    return tmp_path


def use(dev: ModuleType, monkeypatch: pytest.MonkeyPatch, programs: Programs) -> Programs:
    monkeypatch.setattr(dev.subprocess, "run", programs)
    return programs


class Pip:
    """Replaces ``installing.install`` and ``install_locked``: notes what they are asked for, and fails.

    ``failure`` is raised by the first, ``unlike`` by the second.
    """

    def __init__(self, failure: Exception | None = None, unlike: Exception | None = None) -> None:
        self.asked: list[tuple[str, ...]] = []
        self.locked: list[list[str]] = []
        self.failure = failure
        self.unlike = unlike

    def __call__(self, _python: Path, *arguments: str, **_: Any) -> None:
        self.asked.append(arguments)
        if self.failure is not None:
            raise self.failure

    def install_locked(self, _python: Path, _root: Path, needs: list[str], **_: Any) -> None:
        self.locked.append(needs)
        if self.unlike is not None:
            raise self.unlike


def use_pip(dev: ModuleType, monkeypatch: pytest.MonkeyPatch, pip: Pip) -> Pip:
    monkeypatch.setattr(dev.installing, "install", pip)
    monkeypatch.setattr(dev.installing, "install_locked", pip.install_locked)
    monkeypatch.setattr(dev.installing, "not_covered", lambda: None)
    return pip


def test_packages_are_installed_once_and_again_when_the_project_asks_for_others(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pip = use_pip(dev, monkeypatch, Pip())
    dev.install(set())
    dev.install(set())
    assert pip.asked == [LOCKED]
    dev.install({"test"})
    dev.install(set())
    assert pip.asked == [LOCKED, LOCKED_TEST]
    (checkout / "pyproject.toml").write_text("changed")
    dev.install(set())
    assert pip.asked == [LOCKED, LOCKED_TEST, LOCKED_TEST]
    (checkout / "requirements" / "run.lock").write_text("changed")
    dev.install(set())
    assert len(pip.asked) == 4
    assert pip.locked == [["build", "run"], *([["build", "run", "test"]] * 3)]


def test_another_computer_gets_what_the_project_allows(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pip = use_pip(dev, monkeypatch, Pip())
    monkeypatch.setattr(dev.installing, "not_covered", lambda: "Darwin on arm64")
    dev.install({"test"})
    assert pip.locked == []
    assert pip.asked == [("-e", ".[test]")]
    assert "the locked versions are not for Darwin on arm64: installing what pyproject.toml" in capsys.readouterr().out


def test_another_index_gives_what_the_project_allows(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pip = use_pip(dev, monkeypatch, Pip(unlike=dev.installing.NotAsLocked("other hashes")))
    dev.install(set())
    assert pip.asked == [("-e", ".")]
    assert "the package index serves other files than the locked ones" in capsys.readouterr().out


def test_an_index_out_of_reach_ends_the_set_up(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pip = use_pip(dev, monkeypatch, Pip(unlike=dev.installing.PipFailed("cannot be reached")))
    with pytest.raises(dev.SetupFailed, match="cannot be reached"):
        dev.install(set())
    assert pip.asked == []


def test_a_failed_installation_is_tried_again(dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    use_pip(dev, monkeypatch, Pip(dev.installing.PipFailed("conflicting dependencies")))
    with pytest.raises(dev.SetupFailed, match="conflicting dependencies"):
        dev.install(set())
    pip = use_pip(dev, monkeypatch, Pip())
    dev.install(set())
    assert len(pip.asked) == 1


def test_no_venv_module_is_one_sentence(dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dev.PYTHON.unlink()
    use(dev, monkeypatch, Programs(1, "ensurepip is not available"))
    with pytest.raises(dev.SetupFailed, match="apt-get install python3-venv"):
        dev.make_environment()


def test_an_environment_made_elsewhere_is_replaced(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_pip(dev, monkeypatch, Pip())
    programs = use(dev, monkeypatch, Programs())
    dev.install(set())
    dev.make_environment()
    assert programs.commands == []
    monkeypatch.setattr(dev, "ROOT", checkout / "moved")
    dev.make_environment()
    assert programs.commands == [[sys.executable, "-m", "venv", "--clear", str(dev.VENV)]]


def on_a_bare_debian(dev: ModuleType, monkeypatch: pytest.MonkeyPatch, uid: int) -> Programs:
    monkeypatch.delenv("HBBA_CHROMIUM", raising=False)
    monkeypatch.setattr(dev.shutil, "which", lambda name: "/usr/bin/apt-get" if name == "apt-get" else None)
    monkeypatch.setattr(dev.ctypes.util, "find_library", lambda name: None)
    monkeypatch.setattr(dev.os, "geteuid", lambda: uid)
    return use(dev, monkeypatch, Programs())


def test_root_gets_the_missing_debian_packages(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    apt = on_a_bare_debian(dev, monkeypatch, uid=0)
    dev.install_debian_packages()
    assert apt.commands[0][-1] == "update"
    assert {"chromium", "libegl1"} <= set(apt.commands[1])
    # Another distribution may lack these, and its apt-get would then install none of all that it is asked for.
    assert apt.commands[2][-2:] == ["firefox-esr", "xvfb"]
    assert len(apt.commands) == 3


def test_who_runs_the_robot_gets_no_browser_for_tests(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    apt = on_a_bare_debian(dev, monkeypatch, uid=0)
    dev.install_debian_packages(browser=False)
    assert "libegl1" in apt.commands[1]
    assert len(apt.commands) == 2
    assert "chromium" not in apt.commands[1]


def test_make_run_installs_what_the_camera_needs(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, Any]] = []

    def become_hbba(arguments: list[str]) -> None:
        assert arguments == ["--port", "8081"]
        raise SystemExit

    monkeypatch.setattr(dev, "set_up", lambda extras, **options: asked.append(options))
    monkeypatch.setattr(dev, "run_hbba", become_hbba)
    monkeypatch.setattr(dev.os, "chdir", lambda folder: None)
    monkeypatch.setattr(sys, "argv", ["dev.py", "run", "--port", "8081"])
    with pytest.raises(SystemExit):
        dev.main()
    assert asked == [{"debian": True, "browser": False}]


def test_without_root_the_missing_packages_are_named(
    dev: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    apt = on_a_bare_debian(dev, monkeypatch, uid=1000)
    dev.install_debian_packages()
    assert apt.commands == []
    assert "as root, apt-get install chromium libegl1" in capsys.readouterr().err


@pytest.mark.parametrize("has_node", [True, False])
def test_an_unbuilt_page_does_not_stop_the_robot(
    has_node: bool,
    dev: ModuleType,
    page: ModuleType,
    checkout: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    use(dev, monkeypatch, Programs())
    use_pip(dev, monkeypatch, Pip())

    found = page.Node(checkout / "node", ("npm",)) if has_node else None
    monkeypatch.setattr(dev.page, "find_node", lambda *_: found)

    def no_registry(node: object) -> None:
        assert node is found
        raise page.PageFailed("The npm registry cannot be reached: connect this computer to the network.")

    monkeypatch.setattr(dev, "build_page", no_registry)
    dev.set_up(set())
    assert "npm registry cannot be reached" in capsys.readouterr().err


def test_a_failing_step_fails_the_whole_though_the_others_run(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    programs = use(dev, monkeypatch, Programs())
    of_the_page: list[tuple[str, ...]] = []
    page_status = 0

    def web_script(*scripts: str) -> int:
        of_the_page.append(scripts)
        return page_status

    monkeypatch.setattr(dev, "web_script", web_script)
    assert dev.lint() == 0
    assert len(programs.commands) == 5
    programs.status = 3
    assert dev.lint() == 3
    assert len(programs.commands) == 10
    programs.status, page_status = 0, 1
    assert dev.lint() == 1
    assert of_the_page == [("lint", "check")] * 3


def test_the_page_s_scripts_run_one_after_another_until_one_fails(
    dev: ModuleType, page: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run: list[str] = []

    def run_npm(node: object, verb: str, script: str) -> str:
        run.append(f"{verb} {script}")
        if script == "broken":
            raise page.PageFailed("npm run broken failed in web/: src/a.ts:1:1 lint/style/useConst")
        return " 3 passed (3)\n" if script == "test" else "quiet\n"

    monkeypatch.setattr(dev, "node_or_install", lambda: page.Node(Path("node"), ("npm",)))
    monkeypatch.setattr(dev.page, "install_packages", lambda node: None)
    monkeypatch.setattr(dev.page, "run_npm", run_npm)
    assert dev.web_script("lint", "test") == 0
    assert dev.web_script("lint", "broken", "test") == 1
    assert run == ["run lint", "run test", "run lint", "run broken"]
    written = capsys.readouterr()
    assert written.out == " 3 passed (3)\n"
    assert "src/a.ts:1:1" in written.err


@pytest.mark.parametrize(("unwanted", "folder"), [("", None), ("1", "bytecode")])
def test_bytecode_is_kept_though_not_beside_the_sources_where_that_is_unwanted(
    dev: ModuleType, monkeypatch: pytest.MonkeyPatch, unwanted: str, folder: str | None
) -> None:
    monkeypatch.setenv("PYTHONPYCACHEPREFIX", "")
    monkeypatch.delenv("PYTHONPYCACHEPREFIX")
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", unwanted)
    dev.keep_bytecode()
    environment = dict(os.environ)
    assert "PYTHONDONTWRITEBYTECODE" not in environment
    assert environment.get("PYTHONPYCACHEPREFIX") == (folder and str(dev.VENV / folder))
