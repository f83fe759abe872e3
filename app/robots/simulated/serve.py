"""Main function of the link's process: read the Start message, build the world, run it to the end."""

from __future__ import annotations

import select
import signal
import socket
import sys
import time

import cv2

from app.base.errors import ConfigError
from app.robots.simulated.camera_models import picture_formats
from app.robots.simulated.gl import GlUnavailable, check_gl
from app.robots.simulated.link_protocol import Ready, Socket, Start
from app.runtime.realtime import tune_for_latency


def serve(link_descriptor: int, memory_descriptor: int) -> int:
    """Serve one program over the inherited descriptors; returns the process's exit status.

    An error that a person can fix is one sentence on standard error; any other leaves a traceback there.
    """
    sock = Socket(socket.socket(fileno=link_descriptor))
    start = _wait_start(sock)
    if start is None:
        return 0
    began = time.monotonic()
    if picture_formats(start.robot) and (problem := check_gl()):
        return _refuse(problem)

    from app.robots.simulated.realtime_loop import (
        RealtimeLoop,  # MuJoCo looks for its OpenGL library when it is imported
    )

    try:
        loop = RealtimeLoop(start, sock, memory_descriptor)
    except (ConfigError, GlUnavailable) as failure:
        return _refuse(str(failure))
    signal.signal(signal.SIGTERM, lambda *_: loop.end())
    tune_for_latency()
    cv2.setNumThreads(1)  # a pool would only fight the program's threads for the cores
    sock.send(Ready(setup_s=time.monotonic() - began))
    loop.run()
    return 0


def _refuse(sentence: str) -> int:
    print(sentence, file=sys.stderr)
    return 1


def _wait_start(sock: Socket) -> Start | None:
    while not sock.closed:
        select.select([sock.fileno()], [], [])
        for frame in sock.receive():
            if isinstance(frame, Start):
                return frame
    return None
