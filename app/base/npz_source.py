"""Arrays from a numpy archive of unknown origin, which may be damaged.

The declared sizes of its arrays are checked before any is unpacked: an archive of 4 MB can hold gigabytes of zeros.
"""

from __future__ import annotations

import math
import os
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.plain_file import open_plain

#: All arrays of an archive together take no more bytes of memory,
MOST_BYTES = 1_000_000_000
#: nor are there more of them.
MOST_ARRAYS = 1_000
#: An array's header, which is Python text, is no longer: numpy's own bound.
_LONGEST_HEADER = 10_000

#: Exceptions from a damaged archive: NotImplementedError and RuntimeError for impossible flags, SyntaxError and
#: TokenError where an array's header is no Python literal.
_DAMAGE = (
    ValueError, EOFError, KeyError, OverflowError, MemoryError, NotImplementedError, RuntimeError, SyntaxError,
    tokenize.TokenError, struct.error, zlib.error, zipfile.BadZipFile,
)  # fmt: skip


def read_arrays(path: Path, what: str) -> dict[str, NDArray[Any]]:
    """The arrays of the .npz file ``path``, by name; pickles are not opened.

    Raises ConfigError, in which ``what`` names what the file is, for one that cannot be read or is damaged, and for
    more than ``MOST_BYTES`` or ``MOST_ARRAYS``.
    """
    try:
        with open_plain(path) as file:
            _check_extent(file, path, what)
            file.seek(0)
            with np.load(file, allow_pickle=False) as archive:
                return {name: archive[name] for name in archive.files}
    except OSError as failure:
        raise ConfigError(f"{what} cannot be read: {failure.strerror or failure}", str(path)) from None
    except _DAMAGE as damage:
        raise ConfigError(f"{what} is damaged: {damage}", str(path)) from None


def checked_array(
    arrays: Mapping[str, NDArray[Any]], name: str, dtype: type[np.generic], shape: tuple[int, ...]
) -> NDArray[Any]:
    """The array ``name``, of this kind and shape (-1: any length), every number finite.

    Raises ValueError, and KeyError where there is none of that name.
    """
    array = arrays[name]
    if array.dtype != dtype or array.ndim != len(shape):
        raise ValueError(f"{name} has {array.ndim} dimensions of {array.dtype}")
    if any(wanted not in (-1, there) for wanted, there in zip(shape, array.shape, strict=True)):
        raise ValueError(f"{name} has the shape {array.shape}")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise ValueError(f"{name} has numbers that are not finite")
    return array


def joined(parts: Sequence[NDArray[Any]], empty: tuple[int, ...], dtype: type[np.generic]) -> NDArray[Any]:
    """``parts`` one after another, of ``dtype``; an array of the shape ``empty`` where there are none."""
    return np.concatenate(parts).astype(dtype, copy=False) if parts else np.zeros(empty, dtype)


def _check_extent(file: BinaryIO, path: Path, what: str) -> None:
    """Raise ConfigError for arrays that are not to be unpacked; what reading damage raises for what are none."""
    if file.seek(0, os.SEEK_END) > MOST_BYTES:
        raise ConfigError(f"{what} has more than {MOST_BYTES / 1e9:g} GB, the most that is read", str(path))
    total = 0
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        if len(members) > MOST_ARRAYS:
            raise ConfigError(f"{what} has {len(members)} arrays; at most {MOST_ARRAYS} are read", str(path))
        for member in members:
            with archive.open(member) as stream:
                shape, dtype = _header(stream)
            if dtype.hasobject:
                name = member.filename.removesuffix(".npy")
                raise ConfigError(
                    f"{what} has Python objects in `{name}`, which are not opened here: save plain arrays of numbers",
                    str(path),
                )
            # numpy allocates the size in the header; zipfile unpacks no more than the size in the archive.
            total += max(member.file_size, math.prod(shape) * dtype.itemsize)
            if total > MOST_BYTES:
                raise ConfigError(
                    f"{what} has arrays of more than {MOST_BYTES / 1e9:g} GB, the most that are read", str(path)
                )


def _header(stream: Any) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = npy.read_magic(stream)
    read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}.get(version)
    if read is None:
        raise ValueError(f"an array is of format {version[0]}.{version[1]}; 1.0 and 2.0 are read")
    shape, _, dtype = read(stream, max_header_size=_LONGEST_HEADER)
    if any(length < 0 for length in shape):
        raise ValueError(f"an array has the shape {shape}")
    return shape, dtype
