"""Arrays from a numpy archive that anybody may have written or damaged."""

from __future__ import annotations

import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.errors import ConfigError

#: What reading a damaged archive raises: NotImplementedError and RuntimeError where its flags say what cannot be,
#: SyntaxError and TokenError where an array's header, a Python literal, is none.
_DAMAGE = (
    ValueError, EOFError, KeyError, OverflowError, MemoryError, NotImplementedError, RuntimeError, SyntaxError,
    tokenize.TokenError, struct.error, zlib.error, zipfile.BadZipFile,
)  # fmt: skip


def read_arrays(path: Path, what: str) -> dict[str, NDArray[Any]]:
    """The arrays of the .npz file ``path``, by name; pickles are not opened.

    Raises ConfigError, in which ``what`` names what the file is, for one that cannot be read or is damaged.
    """
    try:
        # Opened here: numpy leaves a file open that is no archive.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return {name: _array(archive, name) for name in archive.files}
    except _NotNumbers as name:
        raise ConfigError(
            f"{what} has Python objects in `{name}`, which are not opened here: save plain arrays of numbers", str(path)
        ) from None
    except OSError as failure:
        raise ConfigError(f"{what} cannot be read: {failure.strerror or failure}", str(path)) from None
    except _DAMAGE as damage:
        raise ConfigError(f"{what} is damaged: {damage}", str(path)) from None


class _NotNumbers(Exception):
    """An array of Python objects; the message is its name."""


def _array(archive: Mapping[str, NDArray[Any]], name: str) -> NDArray[Any]:
    try:
        return archive[name]
    except ValueError as failure:
        # Numpy has no class of its own for it.
        if "allow_pickle" in str(failure):
            raise _NotNumbers(name) from None
        raise
