"""Work for child processes, which import it by its full name."""

from __future__ import annotations

import os
from collections.abc import Callable


def tripled(number: int, give: Callable[[tuple[int, int]], None]) -> None:
    if number == 13:
        raise ValueError("thirteen")
    if number == 99:
        os._exit(1)
    give((3 * number, os.getpid()))


def multiples(number: int, give: Callable[[int], None]) -> None:
    for factor in range(1, 4):
        give(factor * number)
    if number == 13:
        raise ValueError("thirteen")
