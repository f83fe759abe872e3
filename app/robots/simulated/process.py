"""The link's process: ``python -m app.robots.simulated.process SOCKET MEMORY`` (two inherited file descriptors).

It ends by a Stop message, when the other end of the socket closes, or when the program dies.
"""

from __future__ import annotations

import os
import signal
import sys

from app.base.child_processes import end_with_parent


def main(arguments: list[str]) -> int:
    """Run the link; 0 after a stop or the program's end, 1 after a failure (message on standard error)."""
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process of a terminal; the program sends Stop
    end_with_parent()
    if parent != os.getppid():
        return 0

    from app.runtime.allocator import share_arenas  # imported late, so that the lines above hold from the first moment
    from app.runtime.realtime import garbage_held

    share_arenas()
    with garbage_held():
        from app.robots.simulated.serve import serve

        return serve(int(arguments[0]), int(arguments[1]))


if __name__ == "__main__":
    status = main(sys.argv[1:])
    sys.stderr.flush()
    os._exit(status)  # no cleanup is needed, and OpenGL's exit handlers have been seen to hang
