"""Limits how much freed memory the C library keeps in a program of many threads.

glibc gives each thread that allocates beside another a heap of its own (an arena, up to eight for each core), and each
arena may keep the most that its thread ever used. Modules compute in threads of their own, each with its own peaks: the
program can grow in steps until all of them have been reached.
"""

from __future__ import annotations

import ctypes

#: glibc's ``M_ARENA_MAX`` (malloc.h).
_M_ARENA_MAX = -8
#: Number of arenas: one for the event loop, one for all other threads. Modules allocate mostly under the interpreter
#: lock, so they rarely contend.
ARENAS = 2


def share_arenas() -> bool:
    """Have all threads share ``ARENAS`` arenas; call it before there are other threads. False where it is not glibc."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    return mallopt is not None and bool(mallopt(_M_ARENA_MAX, ARENAS))
