"""A replay that the console starts: ``python -m app.console.replay_process ARGUMENTS`` is ``hbba replay ARGUMENTS``,
but ends with the console, however that ends, and takes its token from the environment, which no other user can read."""

from __future__ import annotations

import ctypes
import os
import runpy
import signal
import sys

TOKEN = "HBBA_REPLAY_TOKEN"
_PR_SET_PDEATHSIG = 1


def main(arguments: list[str]) -> None:
    """Become ``hbba replay``; ends by SystemExit."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if str(os.getppid()) != arguments[0]:
        return  # the console ended before we asked to be told
    token = os.environ.pop(TOKEN, None)
    sys.argv = ["hbba", "replay", *arguments[1:], *(() if token is None else ("--token", token))]
    runpy.run_module("app.cli", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])
