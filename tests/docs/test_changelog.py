"""CHANGELOG.md is in the format of Keep a Changelog, and the program's version is one of it."""

from __future__ import annotations

import re
import tomllib
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
KINDS = ["Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"]
RELEASE = re.compile(r"## \[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d\d-\d\d)")
HEADINGS = re.findall(r"^##+ .*$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)


def releases() -> list[tuple[tuple[int, ...], date]]:
    found = [RELEASE.fullmatch(heading) for heading in HEADINGS if re.match(r"## \[\d", heading)]
    assert all(found), "a release is headed ## [1.2.3] - 2026-11-22"
    return [(tuple(map(int, one.groups()[:3])), date.fromisoformat(one[4])) for one in found if one is not None]


def test_versions_are_listed_newest_first() -> None:
    assert HEADINGS[0] == "## [Unreleased]"
    assert releases() == sorted(releases(), reverse=True)


def test_changes_are_grouped_by_kind_in_one_order() -> None:
    groups: list[list[str]] = []
    for heading in HEADINGS:
        if heading.startswith("## "):
            groups.append([])
        elif heading.startswith("### "):
            groups[-1].append(heading.removeprefix("### "))
    assert all(group == [kind for kind in KINDS if kind in group] for group in groups)


def test_the_programs_version_is_the_newest_or_one_in_progress() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    released, _, progress = version.partition(".dev")
    number = tuple(map(int, released.split(".")))
    newest = releases()[0][0]
    assert number > newest if progress else number == newest
