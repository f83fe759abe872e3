"""Removes the modules that a failed import leaves in ``sys.modules``, so that the next import can succeed.

Python forgets a package whose import failed, but keeps those of its modules that were imported already. The next import
finds these, does not tie them to the new package, and fails in another way for as long as the process runs: "partially
initialized module 'numba.core.types' has no attribute 'misc'".
"""

from __future__ import annotations

import importlib
import sys


def forget_half_imports() -> list[str]:
    """Remove all imported modules whose package, or a package above it, is not imported; returns their names.

    May be called in any thread during other imports: a package counts as imported as soon as its import starts.
    """
    names = set(sys.modules)
    half = sorted(name for name in names if any(above not in names for above in _above(name)))
    for name in half:
        sys.modules.pop(name, None)
    if half:
        importlib.invalidate_caches()
    return half


def _above(name: str) -> list[str]:
    parts = name.split(".")
    return [".".join(parts[:end]) for end in range(1, len(parts))]
