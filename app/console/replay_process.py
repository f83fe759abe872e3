"""A replay that the console starts: ``python -m app.console.replay_process ARGUMENTS`` is ``hbba replay ARGUMENTS``,
but ends with the console, however that ends."""

from __future__ import annotations

import ctypes
import os
import runpy
import signal
import sys

_PR_SET_PDEATHSIG = 1


def main(arguments: list[str]) -> None:
    """Become ``hbba replay``: the console's process id, then its arguments. Ends by SystemExit."""
    console, *rest = arguments
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if str(os.getppid()) != console:
        return  # it ended before we asked to be told
    sys.argv = ["hbba", "replay", *rest]
    runpy.run_module("app.cli", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])
