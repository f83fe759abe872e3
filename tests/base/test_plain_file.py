"""Files of unknown origin: regular ones are read, and nothing else is waited for."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from app.base.plain_file import check_plain, open_plain, read_plain


def test_a_file_and_a_link_to_one_are_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"content")
    (tmp_path / "link").symlink_to("file")
    for name in ("file", "link"):
        with open_plain(tmp_path / name) as file:
            assert (file.read(3), file.read()) == (b"con", b"tent")
        assert read_plain(tmp_path / name, 7) == b"content"
        check_plain(tmp_path / name)


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(str(path))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_pipe, "is a pipe, no regular file"),
        (_endless, "is a device, no regular file"),
        (_socket, "socket|No such device"),
        (Path.mkdir, "Is a directory"),
        (lambda path: None, "No such file"),
    ],
)
def test_anything_else_is_refused_at_once(
    make: Callable[[Path], None], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # a socket's whole path may be too long
    path = Path("it")
    make(path)
    for read in (open_plain, check_plain, lambda path: read_plain(path, 10)):
        with pytest.raises(OSError, match=words) as refusal:
            read(path)
        assert refusal.value.strerror


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "file"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # no disk space is used, and no memory would hold it
    with pytest.raises(OSError, match="more than 2 MB, the most that is read"):
        read_plain(path, 2_000_000)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")
def test_a_file_that_says_it_is_empty_is_bounded_all_the_same() -> None:
    with pytest.raises(OSError, match="the most that is read"):
        read_plain("/proc/self/status", 10)
