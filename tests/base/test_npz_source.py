from __future__ import annotations

import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from app.base.errors import ConfigError
from app.base.npz_source import read_arrays


def test_arrays_by_name(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    np.savez_compressed(path, a=np.arange(3), b=np.eye(2))
    arrays = read_arrays(path, "the file")
    assert sorted(arrays) == ["a", "b"]
    assert arrays["a"].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    "header", [b"{'descr': '<f8", b"{(", b"'''", b"{'descr': '<f8', 'fortran_order': False, 'shape': 3}", b"\xff"]
)
def test_a_broken_header_is_reported(header: bytes, tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(ConfigError, match="the file is damaged") as damage:
        read_arrays(path, "the file")
    assert damage.value.file == str(path)


def head(shape: tuple[int, ...], descr: str = "|u1") -> bytes:
    """The head of an array of this shape."""
    literal = repr({"descr": descr, "fortran_order": False, "shape": shape}).encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + len(literal).to_bytes(2, "little") + literal


@pytest.fixture
def nothing_is_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(np, "load", None)


@pytest.mark.usefixtures("nothing_is_unpacked")
@pytest.mark.parametrize(
    ("shape", "descr"),
    [((1 << 32,), "|u1"), ((200, 1_000_000), "<f8"), ((1 << 40, 1 << 40), "<f8"), ((2,), "|S999999999")],
)
def test_an_array_that_says_it_is_gigabytes_is_not_unpacked(shape: tuple[int, ...], descr: str, tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.npy", head(shape, descr))
    with pytest.raises(ConfigError, match="the file has arrays of more than 1 GB, the most that are read") as refusal:
        read_arrays(path, "the file")
    assert refusal.value.file == str(path)


@pytest.mark.usefixtures("nothing_is_unpacked")
def test_a_file_of_more_than_may_be_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    with path.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(ConfigError, match="the file has more than 1 GB"):
        read_arrays(path, "the file")


@pytest.mark.usefixtures("nothing_is_unpacked")
def test_members_that_are_large_together_are_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(11):
            archive.writestr(f"{number}.npy", head((100_000_000,)))
    with pytest.raises(ConfigError, match="more than 1 GB"):
        read_arrays(path, "the file")
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(1_001):
            archive.writestr(f"{number}.npy", head((0,)))
    with pytest.raises(ConfigError, match="1001 arrays; at most 1000 are read"):
        read_arrays(path, "the file")


@pytest.mark.usefixtures("nothing_is_unpacked")
def test_what_is_packed_beyond_what_an_array_says_counts_too(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("a.npy", "w") as member:
        member.write(head((3,)))
        for _ in range(1_001):
            member.write(bytes(1_000_000))
    assert path.stat().st_size < 2_000_000
    with pytest.raises(ConfigError, match="more than 1 GB"):
        read_arrays(path, "the file")


@pytest.mark.parametrize("size", [16, 0xFFFFFFF0])
def test_an_archive_that_lies_of_its_size_unpacks_no_more_than_it_says(size: int, tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    np.savez_compressed(path, a=np.zeros(1_000_000))
    data = bytearray(path.read_bytes())
    entry = data.index(b"PK\x01\x02")
    data[entry + 24 : entry + 28] = size.to_bytes(4, "little")  # the directory's word on the size unpacked
    path.write_bytes(bytes(data))
    with pytest.raises(ConfigError, match=r"damaged|more than 1 GB"):
        read_arrays(path, "the file")


def test_a_pipe_in_its_place_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "some.npz")
    with pytest.raises(ConfigError, match="cannot be read: is a pipe"):
        read_arrays(tmp_path / "some.npz", "the file")


def test_a_missing_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="the file cannot be read: No such file"):
        read_arrays(tmp_path / "none.npz", "the file")


def test_python_objects_are_reported_by_their_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "some.npz", a=np.arange(3), b=np.array([{}], dtype=object))
    with pytest.raises(ConfigError, match=r"the file has Python objects in `b`, .* save plain arrays of numbers"):
        read_arrays(tmp_path / "some.npz", "the file")
