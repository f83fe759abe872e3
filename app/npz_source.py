"""Arrays from a numpy archive that anybody may have written or damaged."""

from __future__ import annotations

import struct
import tokenize
import zipfile
import zlib
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
            return {name: archive[name] for name in archive.files}
    except OSError as failure:
        raise ConfigError(f"{what} cannot be read: {failure.strerror or failure}", str(path)) from None
    except _DAMAGE as damage:
        raise ConfigError(f"{what} is damaged: {damage}", str(path)) from None
