"""The microphones' process: ``python -m app.robots.simulated.acoustics.process SOCKET SETUP`` (inherited descriptors).

A separate process, because sound takes a third of a core in bursts of milliseconds, and the control loop must decide
about the wheels every 4 ms. It ends when the other end of the socket closes or its parent dies.
"""

from __future__ import annotations

import os
import signal
import sys

from app.base.child_processes import end_with_parent


def main(arguments: list[str]) -> int:
    """Run the microphones until the end; returns 0."""
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(signal.SIGKILL)
    if sys.platform == "linux":
        if os.getpriority(os.PRIO_PROCESS, 0) < 0:  # this priority is for the control loop alone
            os.setpriority(os.PRIO_PROCESS, 0, 0)
    if parent != os.getppid():
        return 0

    from app.robots.simulated.acoustics.rendering_loop import serve

    serve(int(arguments[0]), int(arguments[1]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
