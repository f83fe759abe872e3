"""Installed packages of others, made for a test: files on the import path, and the metadata that announces them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path


def install(site: Path, distribution: str, files: Mapping[str, str], **groups: Mapping[str, str]) -> None:
    """Put ``files`` (path: text) into ``site``, and the entry points of ``groups`` (``bodies`` is ``hbba.bodies``)."""
    for name, text in files.items():
        path = site / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    info = site / f"{distribution.replace('-', '_')}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n", "utf-8")
    lines = [
        line
        for group, points in groups.items()
        for line in (f"[hbba.{group}]", *(f"{name} = {value}" for name, value in points.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join([*lines, ""]), "utf-8")


def announce(folder: Path) -> None:
    """Put the metadata of the package whose project is in ``folder`` beside it, as an installation would."""
    project = tomllib.loads((folder / "pyproject.toml").read_text("utf-8"))["project"]
    groups = {name.removeprefix("hbba."): points for name, points in project["entry-points"].items()}
    install(folder, project["name"], {}, **groups)
