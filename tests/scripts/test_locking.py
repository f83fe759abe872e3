"""The locks: what pyproject.toml asks for, in one allowed version each, with hashes and without an index."""

from __future__ import annotations

import re
import tomllib
from importlib import metadata
from pathlib import Path
from types import ModuleType

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
NEEDS = ["build", "run", "test", "bench", "docs"]


@pytest.fixture
def pinned(locking: ModuleType) -> dict[str, list[Requirement]]:
    """By need, what its lock pins; those of extras stand on that of ``run``."""
    found = {}
    for need in NEEDS:
        text = (ROOT / "requirements" / f"{need}.lock").read_text(encoding="utf-8")
        lines = re.findall(r"^([A-Za-z0-9][^\\\n]+)", text, re.MULTILINE)
        found[need] = [Requirement(line.strip()) for line in lines]
    return found


def asked(need: str) -> list[Requirement]:
    if need == "build":
        return [Requirement(text) for text in PROJECT["build-system"]["requires"]]
    project = PROJECT["project"]
    return [
        Requirement(x) for x in (project["dependencies"] if need == "run" else project["optional-dependencies"][need])
    ]


@pytest.mark.parametrize("need", NEEDS)
def test_the_locks_are_of_the_project_as_it_is(pinned: dict[str, list[Requirement]], need: str) -> None:
    base = [] if need == "build" else pinned["run"]
    for requirement in asked(need):
        versions = [
            next(iter(pin.specifier)).version
            for pin in (*base, *pinned[need])
            if canonicalize_name(pin.name) == canonicalize_name(requirement.name)
        ]
        assert versions, f"{requirement} is not locked: make lock"
        assert all(version in requirement.specifier for version in versions), (
            f"{requirement}, not {versions}: make lock"
        )


@pytest.mark.parametrize("need", NEEDS)
def test_everything_is_pinned_with_hashes_and_no_index_is_named(need: str) -> None:
    text = (ROOT / "requirements" / f"{need}.lock").read_text(encoding="utf-8")
    assert "://" not in text
    assert "--index" not in text
    for line in re.split(r"\n(?=\S)", text.strip()):
        if not line.startswith("#"):
            assert re.match(r"[\w.-]+==[\w.+!]+( ; .*)? \\\n", line)
            assert "--hash=sha256:" in line


def test_what_packages_ask_for_themselves_is_locked_too(pinned: dict[str, list[Requirement]]) -> None:
    names = {canonicalize_name(pin.name) for pin in (*pinned["run"], *pinned["test"])}
    installed = {canonicalize_name(distribution.name) for distribution in metadata.distributions()}
    assert len(names & installed) > 50
    missing = set()
    for pin in (*pinned["run"], *pinned["test"]):
        other = pin.marker is not None and not pin.marker.evaluate()
        if other or canonicalize_name(pin.name) not in installed:  # a lock of today, an environment of yesterday
            continue
        for text in metadata.requires(pin.name) or []:
            asked_for = Requirement(text)
            wanted = asked_for.marker is None or asked_for.marker.evaluate({"extra": ""})
            if wanted and canonicalize_name(asked_for.name) not in names:
                missing.add(f"{asked_for.name}, of {pin.name}")
    assert not missing


def test_pins_of_one_package_are_for_pythons_that_differ(pinned: dict[str, list[Requirement]]) -> None:
    for need in NEEDS:
        for minor in ("3.11.9", "3.12.9", "3.13.2", "3.14.0"):
            environment = {"python_full_version": minor, "python_version": minor[:4]}
            here = [pin.name for pin in pinned[need] if pin.marker is None or _holds(pin.marker, environment)]
            assert len(here) == len(set(here))


def _holds(marker: Marker, environment: dict[str, str]) -> bool:
    return marker.evaluate(environment)


def test_a_lock_is_read_package_by_package(locking: ModuleType) -> None:
    lock = "# made\na==1 \\\n    --hash=sha256:00\nb-c==2 ; python_version < '3' \\\n    --hash=sha256:01\n"
    assert locking.blocks(lock) == {
        "a": "a==1 \\\n    --hash=sha256:00\n",
        "b-c": "b-c==2 ; python_version < '3' \\\n    --hash=sha256:01\n",
    }


def test_a_failure_of_uv_changes_no_lock(
    locking: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "pyproject.toml").write_text("[build-system]\nrequires = []\n", encoding="utf-8")
    uv = tmp_path / "uv"
    uv.write_text("#!/bin/sh\necho no solution >&2; exit 1\n")
    uv.chmod(0o755)
    assert locking.main(uv, tmp_path, []) == 1
    assert "uv cannot lock the packages (pip compile): no solution" in capsys.readouterr().err
    assert not (tmp_path / "requirements").exists()
