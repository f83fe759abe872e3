"""The tasks behind the Makefile."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.scripts.stand_ins import Pip, Programs, use, use_pip


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


@pytest.mark.parametrize("has_node", [True, False])
def test_an_unbuilt_page_does_not_stop_the_robot(
    has_node: bool,
    dev: ModuleType,
    page: ModuleType,
    checkout: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    use(monkeypatch, Programs())
    use_pip(dev.installing, monkeypatch, Pip())

    found = page.Node(checkout / "node", ("npm",)) if has_node else None
    monkeypatch.setattr(dev.page, "find_node", lambda *_: found)

    def no_registry(node: object) -> None:
        assert node is found
        raise page.PageFailed("The npm registry cannot be reached: connect this computer to the network.")

    monkeypatch.setattr(dev.environment, "build_page", no_registry)
    dev.set_up(set())
    assert "npm registry cannot be reached" in capsys.readouterr().err


def test_a_failing_step_fails_the_whole_though_the_others_run(
    dev: ModuleType, checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    programs = use(monkeypatch, Programs())
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

    monkeypatch.setattr(dev.environment, "node_or_install", lambda: page.Node(Path("node"), ("npm",)))
    monkeypatch.setattr(dev.page, "install_packages", lambda node: None)
    monkeypatch.setattr(dev.page, "run_npm", run_npm)
    assert dev.web_script("lint", "test") == 0
    assert dev.web_script("lint", "broken", "test") == 1
    assert run == ["run lint", "run test", "run lint", "run broken"]
    written = capsys.readouterr()
    assert written.out == " 3 passed (3)\n"
    assert "src/a.ts:1:1" in written.err
