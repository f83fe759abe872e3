"""Loading what is compiled before a robot waits for it: numba takes seconds to wake, and more to compile."""
compiled."""

from __future__ import annotations

import importlib

from app.compiled import make_ready

_NAMES = ("costing", "depth", "lines", "rays", "rollouts", "search", "touching")


def load_kernels() -> None:
    """Compile, in a process of its own, what is not compiled yet, and load all kernels of this room; blocks
    meanwhile."""
    make_ready()
    for name in _NAMES:
        importlib.import_module(f"app.modules.behaviors.navigation.{name}")
