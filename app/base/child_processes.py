"""Child processes: more interpreters like this one, that run this program's code and do not outlive it."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_PR_SET_PDEATHSIG = 1
_SAFE_PATH = "PYTHONSAFEPATH"
_one_at_a_time = threading.Lock()


def python(*arguments: str) -> list[str]:
    """The command that runs this interpreter with ``arguments``, as ``python("-m", "app.base.compiled")``.

    ``-P``: else a folder ``app``, or a file named as one of the standard library, in the folder that a person works in
    would be imported instead of what is installed. PYTHONPATH holds as ever.
    """
    return [sys.executable, "-P", *arguments]


@contextmanager
def safe_path() -> Iterator[None]:
    """Children of ``multiprocessing`` start as safely as with :func:`python`: it takes no options, but the environment.

    The environment is changed only while they start: other programs that this one starts may be scripts that need
    modules beside them.
    """
    with _one_at_a_time:
        before = os.environ.get(_SAFE_PATH)
        os.environ[_SAFE_PATH] = "1"
        try:
            yield
        finally:
            if before is None:
                del os.environ[_SAFE_PATH]
            else:
                os.environ[_SAFE_PATH] = before


def end_with_parent(number: int = signal.SIGTERM) -> None:
    """Have Linux send this process the signal ``number`` when the thread that started it ends; no effect elsewhere.

    A parent that has ended before is not noticed: compare ``os.getppid()`` with its former value.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, number)
