"""Files of unknown origin: a pipe or a device in a file's place is refused, not waited for.

Code that reads a file which a person or another program may have made opens it here.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

#: Kinds of files that are not regular: the test that recognizes each, and its name.
_OTHERS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def open_plain(path: Path | str) -> BinaryIO:
    """Open the regular file ``path``, or the one that a link of this name leads to, for reading bytes.

    Never waits. Raises OSError, whose ``strerror`` is for people, for anything else of this name.
    """
    # Without O_NONBLOCK, opening a pipe without a writer would wait for ever; on a regular file it has no effect.
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        _check(os.fstat(number).st_mode, path)
        return os.fdopen(number, "rb")
    except BaseException:
        os.close(number)
        raise


def check_plain(path: Path | str) -> None:
    """Raise OSError as :func:`open_plain` does: for libraries that open a file by its name."""
    _check(os.stat(path).st_mode, path)


def read_plain(path: Path | str, most: int) -> bytes:
    """The content of the regular file ``path``. Raises OSError as :func:`open_plain`, and for over ``most`` bytes."""
    with open_plain(path) as file:
        # One byte more than allowed: a file of /proc has size 0, and a file may grow while it is read.
        size = os.fstat(file.fileno()).st_size
        if size <= most and len(data := file.read(most + 1)) <= most:
            return data
    raise OSError(errno.EFBIG, f"has more than {megabytes(most)}, the most that is read", str(path))


def megabytes(size: int) -> str:
    """``size`` (bytes) in words, such as ``10 MB``."""
    return f"{size / 1e6:g} MB"


def _check(mode: int, path: Path | str) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(mode):
        what = next((name for holds, name in _OTHERS if holds(mode)), "something else")
        raise OSError(errno.EINVAL, f"is {what}, no regular file", str(path))
