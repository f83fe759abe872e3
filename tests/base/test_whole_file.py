"""Files that are written wholly or not at all: content, permissions, and what is left by a failure."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from app.base.whole_file import write_synced, write_whole


def permissions(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_a_file_is_made_and_replaced_with_its_permissions(tmp_path: Path) -> None:
    file = tmp_path / "file.yaml"
    write_whole(file, b"first")
    file.chmod(0o640)
    (tmp_path / ".file.yaml.new").write_bytes(b"what a program that was killed has left")
    write_whole(file, b"second")
    assert (file.read_bytes(), permissions(file)) == (b"second", 0o640)
    write_whole(file, b"a secret", mode=0o600)
    assert (file.read_bytes(), permissions(file)) == (b"a secret", 0o600)
    assert os.listdir(tmp_path) == ["file.yaml"]


def test_a_failure_leaves_what_was_there_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "file.yaml"
    write_whole(file, b"first")

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_whole(file, b"second")
    assert file.read_bytes() == b"first"
    assert os.listdir(tmp_path) == ["file.yaml"]


def test_what_is_there_already_is_not_written_to(tmp_path: Path) -> None:
    (tmp_path / "target").write_bytes(b"kept")
    (tmp_path / "link").symlink_to("target")
    with pytest.raises(FileExistsError):
        write_synced(tmp_path / "link", b"other")
    assert (tmp_path / "target").read_bytes() == b"kept"
