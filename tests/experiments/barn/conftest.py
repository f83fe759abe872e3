"""A small file of worlds, and a driver that needs no navigation: it knows the truth and follows the file's path."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from app.base.geometry import Pose2, wrap_angle
from app.experiments.world_run import WorldRun
from app.messages import Twist


def posts(x: float, y0: float, y1: float) -> list[list[float]]:
    """A fence of cylinders along y."""
    count = round((y1 - y0) / 0.15)
    return [[x, y0 + 0.15 * number, 0.075] for number in range(count + 1)]


def make_world(number: int, **more: Any) -> dict[str, Any]:
    """A lane of 2 m from (0, 0) northward to (0, 3), open at its end."""
    return {
        "id": number,
        "cylinders": posts(-1.0, -1.0, 3.0) + posts(1.0, -1.0, 3.0),
        "start": [0.0, 0.0, 1.57],
        "goal": [0.0, 3.0],
        "goal_tolerance": 0.5,
        "timeout_s": 8.0,
        "path": [[0.0, 0.0], [0.0, 3.0]],
        "path_length": 3.0,
        "optimal_time": 1.5,
        **more,
    }


def make_file(folder: Path, *worlds: dict[str, Any], **more: Any) -> Path:
    file = folder / "worlds.json"
    file.write_text(json.dumps({"robot": {"name": "any", "max_v": 2.0}, "worlds": worlds, **more}))
    return file


@pytest.fixture
def three(tmp_path: Path) -> Path:
    """An open lane, one with a post in the way, and one whose goal is too far for its time."""
    blocked = make_world(2)
    blocked["cylinders"] = [*blocked["cylinders"], [0.0, 1.5, 0.075]]
    return make_file(tmp_path, make_world(1), blocked, make_world(3, timeout_s=0.5))


async def straight_on(run: WorldRun, goal: Pose2) -> None:
    """Drive straight to the goal on the map at 1 m/s, whatever the obstacles."""
    X_WG = run.link.start_pose @ goal
    while True:
        at = run.link.true_pose()
        error = wrap_angle(math.atan2(X_WG.y - at.y, X_WG.x - at.x) - at.theta)
        run.link.command(Twist(run.system.clock.now(), 1.0, 2.0 * error))
        await run.system.clock.sleep(0.05)
