"""A log's files put back on disk, and nowhere else."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.logs.log import LogError
from app.logs.manifest import AttachedFile, Manifest
from app.logs.replay.unpack_attachments import extract


def manifest(*names: str) -> Manifest:
    return Manifest(tuple(AttachedFile(name, "text/plain", name.encode()) for name in names), {})


def test_files_lie_to_each_other_as_they_did(tmp_path: Path) -> None:
    home = extract(manifest("lab.yaml", "robots/one.yaml", "../worlds/hall.yaml", "../../shared/x.urdf"), tmp_path)
    assert (home / "lab.yaml").read_text() == "lab.yaml"
    assert (home / "robots" / "one.yaml").is_file()
    assert (home / "../worlds/hall.yaml").read_text() == "../worlds/hall.yaml"
    assert (home / "../../shared/x.urdf").read_text() == "../../shared/x.urdf"


@pytest.mark.parametrize("name", ["/etc/passwd", "", "..", ".", "a/..", "../" * 40 + "x", "..\\x", "x\0y", "../.."])
def test_names_that_may_not_be(tmp_path: Path, name: str) -> None:
    with pytest.raises(LogError, match="carries a file named"):
        extract(manifest("good.yaml", name), tmp_path / "inside")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


PARTS = st.lists(st.sampled_from(["..", ".", "a", "b", "", "c.yaml"]), min_size=1, max_size=8).map("/".join)


@given(st.lists(PARTS, min_size=1, max_size=4))
def test_nothing_is_ever_written_outside(tmp_path_factory: pytest.TempPathFactory, names: list[str]) -> None:
    outside = tmp_path_factory.mktemp("outside")
    folder = outside / "deep" / "inside"
    with contextlib.suppress(LogError, OSError):  # OSError: a file in the place of another's folder
        extract(manifest(*names), folder)
    assert all(path.is_relative_to(folder) for path in outside.rglob("*") if path.is_file())
