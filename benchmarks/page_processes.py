"""CPU time of a browser's processes, by kind."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import psutil

#: Renderers draw pages (the 3D view has one of its own), the GPU process puts their pictures on the screen.
KINDS = ("renderer", "gpu-process")


def cpu_seconds() -> Mapping[str, float]:
    """What the browsers started by this process have used so far (s), by kind of process."""
    spent: dict[str, float] = defaultdict(float)
    for process in psutil.Process().children(recursive=True):
        try:
            kind = next((word.removeprefix("--type=") for word in process.cmdline() if word.startswith("--type=")), "")
            times = process.cpu_times()
        except (psutil.NoSuchProcess, psutil.ZombieProcess):
            continue
        if kind in KINDS:
            spent[kind] += times.user + times.system
    return spent
