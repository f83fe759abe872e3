"""The process of a robot of parts: ``python -m app.robots.drivers.process SOCKET`` (an inherited file descriptor).

It ends by a Stop message, when the other end of the socket closes, or when the program dies; its last word to the base
is zero.
"""

from __future__ import annotations

import sys

from app.robots.body_process import Loaded, run_body


def load() -> Loaded:
    """What a robot of parts needs."""
    from app.robots.drivers.body_loop import BodyLoop
    from app.robots.drivers.protocol import Start

    return Start, BodyLoop


if __name__ == "__main__":
    sys.exit(run_body(sys.argv[1:], load))
