"""Loading of the compiled kernels at the start: numba takes seconds to load and more to compile."""

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
    """Load all kernels of navigation, compiling those that are missing in a process of their own; blocks."""
    make_ready()
    for name in _NAMES:
        importlib.import_module(f"app.modules.behaviors.navigation.{name}")
