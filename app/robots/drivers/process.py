"""The process of a robot of parts: ``python -m app.robots.drivers.process SOCKET`` (an inherited file descriptor).

It ends by a Stop message, when the other end of the socket closes, or when the program dies; its last word to the base
is zero.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys

from app.base.child_processes import end_with_parent


def main(arguments: list[str]) -> int:
    """Run the link; 0 after a stop or the program's end, REFUSED after a sentence for people on standard error."""
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process of a terminal; the program sends Stop
    end_with_parent()
    if parent != os.getppid():
        return 0

    from app.robots.link_process import REFUSED
    from app.robots.link_protocol import Socket
    from app.runtime.realtime import garbage_held, tune_for_latency

    with garbage_held():
        from app.robots.drivers.body_loop import BodyLoop, Unavailable
        from app.robots.drivers.protocol import Start
    sock = Socket(socket.socket(fileno=int(arguments[0])))
    while not sock.closed:
        select.select([sock.fileno()], [], [])
        for start in sock.receive():
            if isinstance(start, Start):
                loop = BodyLoop(start, sock)
                signal.signal(signal.SIGTERM, lambda *_, loop=loop: loop.end())
                tune_for_latency()
                try:
                    loop.run()
                except Unavailable as failure:
                    print(failure, file=sys.stderr, flush=True)
                    return REFUSED
                return 0
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
