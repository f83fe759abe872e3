"""Work for child processes, which import it by its full name."""

from __future__ import annotations

import os


def tripled(number: int) -> tuple[int, int]:
    if number == 13:
        raise ValueError("thirteen")
    if number == 99:
        os._exit(1)
    return 3 * number, os.getpid()
