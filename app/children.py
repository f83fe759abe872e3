"""Child processes: more interpreters like this one, that run this program's code and do not outlive it."""

from __future__ import annotations

import ctypes
import signal
import sys

_PR_SET_PDEATHSIG = 1


def python(*arguments: str) -> list[str]:
    """The command that runs this interpreter with ``arguments``, as ``python("-m", "app.compiled")``.

    ``-P``: else a folder ``app``, or a file named as one of the standard library, in the folder that a person works in
    would be imported instead of what is installed. PYTHONPATH holds as ever.
    """
    return [sys.executable, "-P", *arguments]


def end_with_parent(number: int = signal.SIGTERM) -> None:
    """From now on this process gets the signal ``number`` when the thread that started it ends; on Linux alone.

    A parent that has ended before is not noticed: compare ``os.getppid()`` with what it was.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, number)
