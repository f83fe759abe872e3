"""The two visitors of the tour experiment: both follow the robot, one lags and pauses, one asks. By the seed."""

from __future__ import annotations

import numpy as np

from app.base.geometry import Pose2
from app.maps.grid_rays import GridRays
from app.rehearsal.visitors import visitors
from app.robots.simulated.scenery.scenario_config import ScenarioConfig, StepConfig

#: How the one who lags follows: m behind, s late; and how long (s) they follow, and then look at something else.
LAGS_M, LAGS_S, FOLLOWS_S, PAUSES_S = (1.6, 2.4), (1.0, 2.5), (12.0, 30.0), (6.0, 20.0)
_PAUSES = 8
#: The robot begins so far (m, rad) from where it should.
START_M, START_RAD = 0.1, 0.3
#: Visitors reply after so long (s).
REPLIES_S = (1.0, 6.0)


def start_of(place: Pose2, seed: int) -> Pose2:
    """Where the robot begins: not quite at ``place``."""
    x, y, turn = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, 3)
    return Pose2(place.x + START_M * x, place.y + START_M * y, place.theta + START_RAD * turn)


def two_visitors(start: Pose2, rays: GridRays, seed: int) -> ScenarioConfig:
    """The one who lags, and the one who asks, around the robot at ``start``."""
    both = visitors(2, start, rays, seed)
    rng = np.random.default_rng([seed, 2])
    steps: list[StepConfig] = []
    for _ in range(_PAUSES):
        distance, lag = float(rng.uniform(*LAGS_M)), float(rng.uniform(*LAGS_S))
        follow, pause = float(rng.uniform(*FOLLOWS_S)), float(rng.uniform(*PAUSES_S))
        steps += [
            StepConfig(follow=round(follow, 1), distance=distance, lag=lag, look="robot", speed=1.0),
            StepConfig(wait=round(pause, 1)),
        ]
    lagging = both.people[0].model_copy(update={"name": "one who lags", "script": tuple(steps), "repeat": True})
    asking = both.people[1].model_copy(update={"name": "one who asks"})
    return both.model_copy(update={"name": "one who lags, and one who asks", "people": (asking, lagging)})
