"""The file of low things comes back as it was written; a damaged one is refused in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base.errors import ConfigError
from app.modules.behaviors.navigation.costmap.persistent_obstacle_file import (
    PersistentObstacles,
    read_obstacles,
    write_obstacles,
)

RNG = np.random.default_rng(0)
OBSTACLES_FILE = PersistentObstacles(RNG.integers(-200, 200, (40, 2)), RNG.integers(1, 999, 40).astype(np.uint16))


def test_it_is_read_as_it_was_written_and_none_is_nothing(tmp_path: Path) -> None:
    file = tmp_path / "obstacles.npz"
    write_obstacles(file, OBSTACLES_FILE, 0.05)
    back = read_obstacles(file, 0.05)
    assert (back.cells == OBSTACLES_FILE.cells).all()
    assert (back.bands == OBSTACLES_FILE.bands).all()
    assert not len(read_obstacles(tmp_path / "none.npz", 0.05).cells)
    with pytest.raises(ConfigError, match=r"obstacles\.npz.*another version"):
        read_obstacles(file, 0.1)


def test_whatever_byte_is_wrong_it_is_read_or_refused_in_words(tmp_path: Path) -> None:
    file = tmp_path / "obstacles.npz"
    write_obstacles(file, OBSTACLES_FILE, 0.05)
    whole, refused = file.read_bytes(), 0
    for at in range(0, len(whole), 5):
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :])
        try:
            read_obstacles(file, 0.05)
        except ConfigError:
            refused += 1
    assert refused > 50


@pytest.mark.parametrize(
    "wrong",
    [
        {"cells": np.zeros((3, 2), dtype=np.float64)},
        {"cells": np.zeros((2, 2), dtype=np.int32)},
        {"cells": np.zeros(6, dtype=np.int32)},
        {"bands": np.zeros((3, 1), dtype=np.uint16)},
        {"version": np.array([1, 1])},
        {
            "cells": np.stack((np.arange(20_000, dtype=np.int32) * 64,) * 2, axis=1),
            "bands": np.ones(20_000, dtype=np.uint16),
        },
    ],
)
def test_arrays_that_cannot_be_are_refused(wrong: dict[str, Any], tmp_path: Path) -> None:
    arrays: dict[str, Any] = {
        "version": 1, "resolution_m": 0.05, "cells": np.zeros((3, 2), np.int32), "bands": np.ones(3, np.uint16),
    }  # fmt: skip
    np.savez(tmp_path / "right.npz", **arrays)
    assert len(read_obstacles(tmp_path / "right.npz", 0.05).cells) == 3
    np.savez(tmp_path / "wrong.npz", **(arrays | wrong))
    with pytest.raises(ConfigError, match=r"wrong\.npz"):
        read_obstacles(tmp_path / "wrong.npz", 0.05)
