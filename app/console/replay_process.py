"""A replay that the console starts: ``python -m app.console.replay_process ARGUMENTS`` is ``hbba replay ARGUMENTS``,
but ends with the console, however that ends, and takes its token from the environment, which no other user can read."""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import MutableMapping, Sequence

from app.children import end_with_parent

TOKEN = "HBBA_REPLAY_TOKEN"


def main(arguments: list[str]) -> None:
    """Become ``hbba replay``: the console's process id, then its arguments. Ends by SystemExit."""
    console, *rest = arguments
    end_with_parent()
    if str(os.getppid()) != console:
        return  # it ended before we asked to be told
    sys.argv = command_line(rest, os.environ)
    runpy.run_module("app.cli", run_name="__main__", alter_sys=True)


def command_line(arguments: Sequence[str], environment: MutableMapping[str, str]) -> list[str]:
    """``hbba replay`` as it would have been typed; takes the token out of ``environment``."""
    token = environment.pop(TOKEN, None)
    return ["hbba", "replay", *(() if token is None else ("--token", token)), *arguments]


if __name__ == "__main__":
    main(sys.argv[1:])
