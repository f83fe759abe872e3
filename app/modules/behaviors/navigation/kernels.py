"""Loading what is compiled before a robot waits for it: numba takes seconds to wake, and more to compile."""

from __future__ import annotations

import importlib

from app.compiled import make_ready

_NAMES = ("costing", "depth", "lines", "rays", "rollouts", "search", "touching")


def load_kernels() -> None:
    """Load all kernels of this room, compiled before in a process of its own where they are not yet; blocks."""
    make_ready()
    for name in _NAMES:
        importlib.import_module(f"app.modules.behaviors.navigation.{name}")
