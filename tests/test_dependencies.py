"""What the program imports is what it asks for: nothing that another package happens to bring."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
#: Parts of what is asked for: of fastapi, pydantic, numba, rclpy (what its actions are made of) and, before Python 3.14
#: has it itself, rosbags.
PARTS = {
    "starlette", "pydantic-core", "llvmlite", "action-msgs", "unique-identifier-msgs", "backports-zstd", "compression",
}  # fmt: skip

#: Packages of extras that need not be installed, where their name is not that of the import.
GIVEN_BY = {"piper": "piper-tts", "zenoh": "eclipse-zenoh", "foxglove": "foxglove-sdk"} | {
    package: f"ros-jazzy-{package.replace('_', '-')}"
    for package in ("geometry_msgs", "nav_msgs", "rclpy", "rosgraph_msgs", "sensor_msgs")
}


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def named(requirement: str) -> str:
    found = re.match(r"[\w.-]+", requirement)
    assert found is not None
    return normal(found[0])


def imported(folder: Path) -> dict[str, Path]:
    """By package: a file that imports it, anywhere in it."""
    packages: dict[str, Path] = {}
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names = [node.module]
            for name in names:
                packages.setdefault(name.partition(".")[0], path)
    return packages


def test_every_package_that_is_imported_is_asked_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    optional = project["optional-dependencies"]
    used = ("video", "devices", "speech", "piper", "words", "remote", "ros2", "foxglove", "models")
    extras = [requirement for extra in used for requirement in optional[extra]]
    asked = {named(requirement) for requirement in (*project["dependencies"], *extras)} | PARTS
    providers = metadata.packages_distributions()
    strangers = {}
    for package, path in imported(ROOT / "app").items():
        if package in sys.stdlib_module_names or package == "app":
            continue
        known = [GIVEN_BY[package]] if package in GIVEN_BY else providers.get(package, [package])
        given_by = {normal(name) for name in known}
        if not given_by & asked:
            strangers[package] = f"{path.relative_to(ROOT)}, from {', '.join(sorted(given_by))}"
    assert not strangers


def test_every_dependency_is_imported() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    providers = metadata.packages_distributions()
    used = {normal(name) for package in imported(ROOT / "app") for name in providers.get(package, [])}
    idle = {named(requirement) for requirement in project["dependencies"]} - used
    assert not idle
