"""The visitors of a rehearsal: they stand before the robot at the begin, and follow it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from app.base.geometry import Pose2
from app.maps.grid_rays import GridRays
from app.robots.simulated.scenery.faces import FACES
from app.robots.simulated.scenery.scenario_config import PersonConfig, ScenarioConfig, StepConfig

#: They stand so far (m) from the robot, so far (rad) from one another as it sees them, and so far from walls (m);
#: in a narrow place, in a second row.
AWAY_M, APART_RAD, CLEAR_M = 1.5, 0.45, 0.3
_SECOND_ROW_M = 2.2
#: Longer than any rehearsal (s).
_ALL_DAY_S = 86_400.0


def visitors(count: int, start: Pose2, rays: GridRays, seed: int = 1) -> ScenarioConfig:
    """``count`` visitors around the robot at ``start`` on the map, ahead of it where there is room; fewer where there
    is too little."""
    places = itertools.islice(_places(start, rays), count)
    people = tuple(
        PersonConfig(
            name=f"visitor {number + 1}",
            face=tuple(FACES)[number % len(FACES)],
            at=place,
            heading_deg=math.degrees(math.atan2(start.y - place[1], start.x - place[0])),
            script=(StepConfig(follow=_ALL_DAY_S, look="robot", speed=1.2),),
        )
        for number, place in enumerate(places)
    )
    return ScenarioConfig(name="visitors", seed=seed, people=people)


def _places(start: Pose2, rays: GridRays) -> Iterator[tuple[float, float]]:
    """Free places in sight of ``start``, those ahead first."""
    turns = math.ceil(math.pi / APART_RAD)
    for away_m, step in itertools.product((AWAY_M, _SECOND_ROW_M), range(2 * turns)):
        side = -1 if step % 2 else 1
        direction = start.theta + side * (step + 1) // 2 * APART_RAD
        place = start.x + away_m * math.cos(direction), start.y + away_m * math.sin(direction)
        if rays.clear_m(*place) >= CLEAR_M and rays.sees((start.x, start.y), place):
            yield place
