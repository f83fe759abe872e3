"""The share of the examples that are tried: fewer where many tests run, in each run others."""

from __future__ import annotations

import os

EXAMPLES = float(os.environ.get("HBBA_EXAMPLES") or 1)


def fewer(examples: int) -> int:
    """So many, of ``examples``, are tried: at least three; more than there are, if more are asked for."""
    return max(round(EXAMPLES * examples), 3)
