"""How well a person is followed: a walk of 10 m through a hall, with turns and a pause, by the true places.

In virtual time, on a body without physics (docs/bodies.md), with the program's own tracker of persons, which is given
the legs in the laser and true faces. Distances are from middle to middle, from the first step on.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from app.base import compiled
from app.robots.simulated.scenery.scenario_config import StepConfig
from benchmarks.report import Row, benchmark_main, row
from tests.scenery.followed_walk import Moment, followed, walk

WAY: tuple[tuple[float, float] | float, ...] = ((3.0, 0.0), (3.0, 3.2), 8.0, (7.0, 3.2), (7.0, 1.5), 6.0)
WAY_M = 10.3
ROUND_A_WALL: tuple[tuple[float, float] | float, ...] = (
    (3.0, 0.0),
    (3.2, 2.3),
    (5.2, 2.3),
    (5.2, 0.0),
    (7.0, -1.0),
    6.0,
)
#: People look at the robot for 4 s before they walk (m/s).
BEGIN_S = 5.0
SPEEDS = (0.2, 0.3, 0.36)


def played(script: tuple[StepConfig, ...], seconds: float, **params: object) -> list[Moment]:
    """The moments of one walk."""
    with tempfile.TemporaryDirectory() as folder:
        return followed(Path(folder), script, seconds, **params)


def rows(case: str, moments: Sequence[Moment]) -> list[Row]:
    """The figures of a walk that is followed to its end."""
    walked = [moment for moment in moments if moment.at_s >= BEGIN_S]
    distances, last = [moment.distance_m for moment in walked], moments[-1]
    return [
        row("following", case, "distance", "m", distances),
        row("following", case, "least distance", "m", [min(distances)]),
        row("following", case, "greatest distance", "m", [max(distances)]),
        row("following", case, "at the end", "m", [last.distance_m]),
        row("following", case, "turned aside at the end", "deg", [math.degrees(last.turned_rad)]),
        row("following", case, "touches", "1", [last.touches]),
    ]


def measure(quick: bool) -> Sequence[Row]:
    """Follow at several speeds, round a wall, and approach from the front."""
    compiled.make_ready()
    found = []
    for speed_mps in SPEEDS[1:2] if quick else SPEEDS:
        seconds = 4.0 + WAY_M / speed_mps + 8.0 + 10.0
        found += rows(f"at {speed_mps:g} m/s", played(walk(speed_mps, *WAY), seconds))
    if not quick:
        found += rows("round a wall, at 0.3 m/s", played(walk(0.3, *ROUND_A_WALL), 48.0))
        last = played(walk(0.8, (2.6, 0.0), (2.6, 0.6), 60.0), 30.0, side="front")[-1]
        found += [
            row("following", "from the front", "at the end", "m", [last.distance_m]),
            row("following", "from the front", "aside of where they look", "deg", [math.degrees(last.aside_rad)]),
        ]
    return found


if __name__ == "__main__":
    sys.exit(benchmark_main(__doc__, measure))
