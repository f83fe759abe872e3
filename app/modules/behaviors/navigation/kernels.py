"""Loading what is compiled before a robot waits for it: numba takes seconds to wake, and more to compile."""

from __future__ import annotations

import importlib

from app.base.compiled import make_ready

_NAMES = (
    "costmap.clearance_kernels",
    "costmap.cost_kernels",
    "costmap.depth_kernels",
    "costmap.raytrace_kernels",
    "planning.astar_kernels",
    "planning.path_kernels",
    "tracking.rollout_kernels",
)


def load_kernels() -> None:
    """Load all kernels of this room, compiled before in a process of its own where they are not yet; blocks."""
    make_ready()
    for name in _NAMES:
        importlib.import_module(f"app.modules.behaviors.navigation.{name}")
