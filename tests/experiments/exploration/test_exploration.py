"""The exploration experiment: what counts as mapped, and a small room that is mapped for real."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.paths import config_dir
from app.experiments.exploration.experiment import document, known_share, plan, run, table
from app.experiments.goals.reachable_floor import CELL_M, ReachableFloor
from app.messages import OccupancyGrid
from tests.browser.tour_room import write_program


def test_what_the_map_has_as_free_counts_wherever_the_map_begins() -> None:
    floor = ReachableFloor(np.full((40, 60), 1.0))
    cells = np.ones((40, 60), bool)
    X_WM = Pose2(1.0, 0.5, math.pi / 2)
    grid = OccupancyGrid(0.0, "map", np.full((80, 80), -1, np.int8), CELL_M, (-2.0, -2.0), 1)
    assert known_share(floor, cells, grid, X_WM) == 0.0
    # Of the world x from 0 to 1 m, 2 of its 3 m by 1 of its 2 m: on the map y from 1 m down to 0, x from -0.5 on.
    grid.cells[30:50, 40:60] = 0  # y from -0.5 to 0.5: x of the world from 0.5 to 1.5; x 0 to 1: y from 0.5 to 1.5
    assert known_share(floor, cells, grid, X_WM) == pytest.approx(1.0 / 6.0, rel=0.1)
    grid.cells[:] = 100
    assert known_share(floor, cells, grid, X_WM) == 0.0


def laser_alone(folder: Path) -> Path:
    """A program for the small room that sees by its laser, so that nothing is rendered."""
    write_program(folder, visitors=False)
    body = yaml.safe_load((folder / "robot.yaml").read_text())
    body["streams"] |= {"kinect": None, "panorama": None, "microphones": None}
    body |= {"loudspeaker": None, "guard_log": None}
    (folder / "robot.yaml").write_text(yaml.safe_dump(body))
    config = config_dir()
    program = yaml.safe_load((config / "jackal.yaml").read_text())
    program |= {
        "robot": "robot.yaml",
        "channels": str(config / program["channels"]),
        "strategies": [str(config / file) for file in program["strategies"]],
    }
    (folder / "program.yaml").write_text(yaml.safe_dump(program))
    return folder / "program.yaml"


def test_a_room_is_mapped_wholly_and_nothing_is_touched(tmp_path: Path) -> None:
    shares: list[float] = []
    result = run(plan(laser_alone(tmp_path), None), shares.append)
    assert (result.outcome, result.touched) == ("done", ())
    assert result.share >= 0.95
    assert result.floor_m2 > 20
    assert "| touched | nothing |" in table(result)
    assert document(result)["outcome"] == "done"


def test_a_program_that_does_not_explore_is_refused() -> None:
    with pytest.raises(ConfigError, match="it has no module Curiosity"):
        plan(config_dir() / "webcam.yaml", None)
