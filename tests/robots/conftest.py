"""What the tests of bodies share: the real robot's configuration and small worlds to put it in."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import pytest

from app.base.yaml_source import parse
from app.robots.config import RobotConfig, load_robot_config
from app.robots.simulated.gl import check_gl
from app.robots.simulated.world_config import WorldConfig

CONFIG = Path(__file__).parents[2] / "config"
needs_gl = pytest.mark.skipif(check_gl() is not None, reason=check_gl() or "")


@pytest.fixture(scope="session")
def robot() -> RobotConfig:
    """The robot as shipped, with ground truth, alone in the world."""
    config = load_robot_config(CONFIG / "robots" / "irl1_tr.yaml")
    return config.model_copy(update={"ground_truth": True, "scenario": None})


@pytest.fixture(scope="session")
def lab() -> WorldConfig:
    """The laboratory as shipped."""
    return parse(CONFIG / "worlds" / "lab.yaml", WorldConfig)


@pytest.fixture(scope="session")
def hall() -> WorldConfig:
    """An empty hall of 20 x 20 m; its east wall's face lies at x = 19.9."""
    return make_hall()


def make_hall(**more: Any) -> WorldConfig:
    """An empty hall with ``more`` in it."""
    corners = [(0, 0), (20, 0), (20, 20), (0, 20), (0, 0)]
    walls = [{"from": a, "to": b, "material": "wall", "thickness": 0.2} for a, b in itertools.pairwise(corners)]
    return WorldConfig.model_validate(
        {
            "name": "hall",
            "size": (20, 20),
            "floor": "floor",
            "materials": {
                "floor": {"pattern": "tiles", "tile_m": (2, 2)},
                "wall": {"pattern": "plaster", "tile_m": (2, 2)},
            },
            "walls": walls,
            "lights": [{"direction": (0.5, 0.3, -0.8), "strength": 0.3}],
            **more,
        }
    )
