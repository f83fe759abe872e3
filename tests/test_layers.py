"""The rooms are layered as ARCHITECTURE.md says: imports point down (the contracts are in pyproject.toml)."""

from __future__ import annotations

import ast
import logging
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from importlinter import cli as import_linter

from app.runtime.digraph import find_cycle

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture
def _logging_survives() -> Iterator[None]:
    """import-linter's set-up of logging disables every logger there is, and the tests after it would hear nothing."""
    yield
    for logger in logging.root.manager.loggerDict.values():
        if isinstance(logger, logging.Logger):
            logger.disabled = False


@pytest.mark.usefixtures("_logging_survives")
def test_every_room_imports_only_rooms_below_it(capsys: pytest.CaptureFixture[str]) -> None:
    status = import_linter.lint_imports(str(ROOT / "pyproject.toml"), no_cache=True)
    assert status == import_linter.EXIT_STATUS_SUCCESS, capsys.readouterr().out


def test_the_pages_files_import_each_other_in_no_circle() -> None:
    source = ROOT / "web" / "src"
    imports: dict[str, set[str]] = {}
    for path in sorted([*source.rglob("*.ts"), *source.rglob("*.tsx")]):
        named = re.findall(r"""(?:from|import) ["'](\.[^"']+)["']""", path.read_text("utf-8"))
        beside = [(path.parent / name).resolve() for name in named]
        there = [base.with_name(base.name + end) for base in beside for end in (".ts", ".tsx", "")]
        imports[str(path)] = {str(found) for found in there if found.is_file()}
    assert sum(map(len, imports.values())) > 100
    assert find_cycle(imports) is None


def imports_of(folder: str, package: str) -> dict[str, set[str]]:
    """By file below ``folder``: the modules of ``package`` that it imports."""
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / folder).rglob("*.py")):
        names: set[str] = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                names |= {f"{node.module}.{alias.name}" for alias in node.names}
        found[str(path.relative_to(ROOT))] = {name for name in names if name.split(".")[0] == package}
    return found


#: What benchmarks use of tests beside their scenery: what starts a robot, for a browser and over ROS 2.
STARTED = ("tests.scenery.", "tests.browser.running.", "tests.robots.ros2.robot.")


def test_tests_use_no_benchmark_but_those_of_benchmarks() -> None:
    """What both need is in ``tests/scenery``; of the others, benchmarks use what starts a robot for a browser."""
    of_tests = {file: names for file, names in imports_of("tests", "benchmarks").items() if names}
    assert of_tests
    assert all(file.startswith("tests/benchmarks/") for file in of_tests), of_tests
    of_benchmarks = {name for names in imports_of("benchmarks", "tests").values() for name in names}
    assert of_benchmarks
    assert all(name.startswith(STARTED) for name in of_benchmarks), of_benchmarks


#: What must not be paid for by a person who only asks for help.
HEAVY = {"cv2", "fastapi", "mujoco", "numpy", "ortools", "psutil", "pydantic", "scipy", "uvicorn", "viser", "yaml"}


def test_commands_import_what_is_heavy_only_when_they_run() -> None:
    """All of them, in folders too: what the parser of the whole command line brings along."""
    code = "import sys; from app.cli import build_parser; build_parser(); print(*sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    loaded = set(ran.stdout.split())
    assert {"app.commands.slam", "app.commands.detect"} <= loaded
    assert {name.split(".")[0] for name in loaded} & HEAVY == set()
