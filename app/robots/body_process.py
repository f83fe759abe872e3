"""What the processes of bodies at real ports or in a real graph share, from their first line to their loop."""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from app.base.child_processes import end_with_parent

if TYPE_CHECKING:
    from app.robots.link_protocol import Socket


class Unavailable(Exception):
    """The robot, or a part that driving requires, is not there, not as it is described, or began again; the message is
    for people."""


class BodyLoop(Protocol):
    """The loop of a body, with its guard."""

    def run(self) -> None:
        """Run until the end. Raises Unavailable, having stopped the base."""

    def end(self) -> None:
        """Have it end soon; may be called from a signal handler."""


Loaded: TypeAlias = "tuple[type[Any], Callable[[Any, Socket], BodyLoop]]"
"""The message that starts a body, and its loop, made of that message and of the program's socket."""


def run_body(arguments: list[str], load: Callable[[], Loaded]) -> int:
    """Run the body's loop for the program at the other end of the socket whose descriptor is the first argument.

    ``load`` imports what the body needs, once a signal or the program's end can do no harm; it may raise Unavailable.
    Returns 0 after a stop or the program's end, REFUSED after a sentence for people on standard error.
    """
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches every process of a terminal; the program sends Stop
    end_with_parent()
    if parent != os.getppid():
        return 0

    from app.robots.link_process import REFUSED
    from app.robots.link_protocol import Socket
    from app.runtime.realtime import garbage_held, tune_for_latency

    try:
        with garbage_held():
            start_type, make = load()
        sock = Socket(socket.socket(fileno=int(arguments[0])))
        while not sock.closed:
            select.select([sock.fileno()], [], [])
            for start in sock.receive():
                if isinstance(start, start_type):
                    loop = make(start, sock)
                    signal.signal(signal.SIGTERM, lambda *_, loop=loop: loop.end())
                    tune_for_latency()
                    loop.run()
                    return 0
    except Unavailable as failure:
        print(failure, file=sys.stderr, flush=True)
        return REFUSED
    return 0
