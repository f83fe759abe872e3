from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from app.errors import ConfigError
from app.npz_source import read_arrays


def test_arrays_by_name(tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    np.savez_compressed(path, a=np.arange(3), b=np.eye(2))
    arrays = read_arrays(path, "the file")
    assert sorted(arrays) == ["a", "b"]
    assert arrays["a"].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    "header", [b"{'descr': '<f8", b"{(", b"'''", b"{'descr': '<f8', 'fortran_order': False, 'shape': 3}", b"\xff"]
)
def test_a_broken_header_is_told(header: bytes, tmp_path: Path) -> None:
    path = tmp_path / "some.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(ConfigError, match="the file is damaged") as damage:
        read_arrays(path, "the file")
    assert damage.value.file == str(path)


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="the file cannot be read: No such file"):
        read_arrays(tmp_path / "none.npz", "the file")


def test_python_objects_are_told_by_their_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "some.npz", a=np.arange(3), b=np.array([{}], dtype=object))
    with pytest.raises(ConfigError, match=r"the file has Python objects in `b`, .* save plain arrays of numbers"):
        read_arrays(tmp_path / "some.npz", "the file")
