"""Ways through the cylinder fields of the BARN challenge, on maps as a laser would draw them."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.behaviors.navigation.costmap.inflation import cost_field
from app.modules.behaviors.navigation.planning.goal_planning import plan
from tests.modules.behaviors.navigation.maps import OBLONG, grid_of

FOLDER = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[5] / "shared" / "data") / "barn"
RADIUS_M = 0.075


@pytest.fixture(scope="module")
def worlds() -> list[dict[str, Any]]:
    file = FOLDER / "worlds.json"
    if not file.is_file():
        pytest.skip(f"the worlds of BARN are not in {FOLDER} (set HBBA_REFERENCE_DATA)")
    found: list[dict[str, Any]] = json.loads(file.read_text(encoding="utf-8"))["worlds"]
    return found


def test_through_every_field_there_is_a_way_as_short_as_the_published_one_and_wide_enough(
    worlds: list[dict[str, Any]],
) -> None:
    around = np.linspace(0.0, 2.0 * math.pi, 60)
    for world in worlds[::4]:
        cylinders = np.array(world["cylinders"])[:, :2]
        circles = cylinders[:, None] + RADIUS_M * np.stack((np.cos(around), np.sin(around)), axis=-1)
        cells = np.zeros((320, 160), dtype=np.int8)
        grid = grid_of(cells, origin=(-5.3, 0.013))
        found = np.floor((circles.reshape(-1, 2) - np.array(grid.origin)) / 0.05).astype(int)
        inside = ((found >= 0) & (found < (160, 320))).all(axis=1)
        cells[found[inside, 1], found[inside, 0]] = 100
        goal = Pose2(world["goal"][0], world["goal"][1], math.nan)
        way = plan(cost_field(grid, OBLONG), Pose2(*world["start"]), goal)
        assert way.code == "way", world["id"]
        assert way.length_m < 1.03 * world["path_length"]
        nearest = np.linalg.norm(way.poses[:, None, :2] - cylinders[None], axis=-1).min()
        # A cell is 5 cm wide.
        assert nearest - RADIUS_M > OBLONG.inscribed_m - 0.025, world["id"]
