"""A replay that the console starts: ``python -m app.console.replay_process ARGUMENTS`` is ``hbba replay ARGUMENTS``,
but ends with the console, however that ends."""

from __future__ import annotations

import os
import runpy
import sys

from app.base.child_processes import end_with_parent


def main(arguments: list[str]) -> None:
    """Become ``hbba replay``: the console's process id, then its arguments. Ends by SystemExit."""
    console, *rest = arguments
    end_with_parent()
    if str(os.getppid()) != console:
        return  # it ended before its end could be watched
    sys.argv = ["hbba", "replay", *rest]
    runpy.run_module("app.cli", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])
