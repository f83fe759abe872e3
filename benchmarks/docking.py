"""How exactly the robot docks: in the simulated lab, from five poses, by its true pose once it charges.

The poses are in the south corridor: near and far from the dock, looking at it, away from it and aside. In lockstep,
without cameras and people. The tests dock from three such poses (``tests/modules/behaviors/docking/``).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

from app.base import compiled
from app.base.geometry import Pose2
from app.experiments.world_run import WorldRun
from benchmarks.report import Row, benchmark_main, row
from tests.scenery.docking_lab import ME, errors, in_the_lab

POSES = (
    Pose2(11.0, 4.6, math.pi / 2),
    Pose2(11.1, 2.2, -math.pi / 2),
    Pose2(11.6, 1.6, 0.0),
    Pose2(11.5, 3.6, math.pi),
    Pose2(11.4, 2.0, -2.4),
)
LIMIT_S = 120.0


async def docked(run: WorldRun) -> tuple[float, float, float]:
    """How far the docked robot is from where it should be: along the dock's axis, beside it (m), turned (degrees)."""
    clock, channel = run.system.clock, run.system.graph.channels["docking"]
    run.system.workspace.add("Dock", intensity=5, utility=1, source=ME)
    end = clock.now() + LIMIT_S
    while channel.latest is None or channel.latest.state != "docked":
        if clock.now() > end:
            raise RuntimeError(f"it has not docked within {LIMIT_S:g} s: {channel.latest}")
        await clock.sleep(0.1)
    await clock.sleep(2.0)
    return errors(run.link.true_pose())


def measure(quick: bool) -> Sequence[Row]:
    """Dock from each pose."""
    compiled.make_ready()
    found = [in_the_lab(pose, docked) for pose in (POSES[1:3] if quick else POSES)]
    along, aside, turned = ([abs(value) for value in column] for column in zip(*found, strict=True))
    case = f"from {len(found)} poses"
    return [
        row("docking", case, "along", "mm", [1000 * value for value in along]),
        row("docking", case, "aside", "mm", [1000 * value for value in aside]),
        row("docking", case, "most aside", "mm", [1000 * max(aside)]),
        row("docking", case, "turned", "deg", turned),
        row("docking", case, "most turned", "deg", [max(turned)]),
    ]


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
