"""The link's process: ``python -m app.robots.simulated.process SOCKET MEMORY`` (two inherited file descriptors).

It ends when it is told to, when the other end of the socket closes, or when the program dies in any other way.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import socket
import sys
import time

_PR_SET_PDEATHSIG = 1


def main(arguments: list[str]) -> int:
    """Run the link; 0 when told to stop or left alone, 1 when something failed (said on standard error)."""
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process of a terminal; the program tells us
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if parent != os.getppid():
        return 0
    started = time.monotonic()
    sys.setswitchinterval(0.001)
    # Imported here, so that the lines above hold from the first moment
    from app.errors import ConfigError
    from app.robots.simulated.gl import check_gl
    from app.robots.simulated.wire import Ready, Socket, Start
    from app.robots.simulated.world_loop import WorldLoop

    sock = Socket(socket.socket(fileno=int(arguments[0])))
    start = _wait_start(sock, Start)
    if start is None:
        return 0
    if start.robot.streams.kinect is not None and (problem := check_gl()):
        print(problem, file=sys.stderr)
        return 1
    try:
        loop = WorldLoop(start, sock, int(arguments[1]))
    except ConfigError as failure:
        print(failure, file=sys.stderr)
        return 1
    signal.signal(signal.SIGTERM, lambda *_: loop.end())
    gc.collect()
    gc.freeze()  # the world stays: later collections need not look at it again
    sock.send(Ready(setup_s=time.monotonic() - started))
    loop.run()
    return 0


def _wait_start(sock: Socket, kind: type[Start]) -> Start | None:  # type: ignore[name-defined]  # noqa: F821
    import select

    while not sock.closed:
        select.select([sock], [], [])
        for frame in sock.receive():
            if isinstance(frame, kind):
                return frame
    return None


if __name__ == "__main__":
    status = main(sys.argv[1:])
    sys.stderr.flush()
    os._exit(status)  # nothing here is worth waiting for, and OpenGL's exit handlers have been seen to hang
