"""What the camera knows of a place goes with its map."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.geometry import Pose2
from app.maps.control import MapControl, MapUnavailable
from app.maps.library import MapLibrary
from app.messages import Zone
from app.modules.behaviors.navigation.memory import ThingsMemory
from app.modules.behaviors.navigation.things_kept import THINGS, ThingsKept

from ..driven_world import box, mapped
from .maps import ROUND

GRID = mapped(box(0.1, 0.1, 3.9, 3.9), (0.0, 0.0, 4.0, 4.0))


class Keeper:
    """Keeps maps in ``library`` and does nothing else."""

    def __init__(self, library: MapLibrary) -> None:
        self.library = library
        self.name = ""

    async def save(self, name: str) -> None:
        await compute(self.library.keep, name, GRID)
        self.name = name

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        if name not in await compute(self.library.names):
            raise MapUnavailable(f"there is no map {name}")
        self.name = name

    async def begin(self) -> None:
        self.name = ""

    async def place(self, X_MB: Pose2) -> None: ...

    async def search(self) -> None: ...

    async def mark(self, zones: tuple[Zone, ...]) -> None: ...


async def compute(function: Callable[..., Any], *args: Any) -> Any:
    return await asyncio.to_thread(function, *args)


def test_it_is_kept_loaded_and_forgotten_with_the_map(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    library, control = MapLibrary(tmp_path), MapControl()
    control.attach(Keeper(library))
    things = ThingsMemory(ROUND, 1.4)
    leave = control.add(ThingsKept(things, library, compute, logging.getLogger("test")))

    async def live() -> None:
        things.felt(np.array([[1.0, 2.0]]), 1.0)
        await control.keeper.save("hall")
        await control.keeper.begin()
        assert not len(things.points)
        await control.keeper.save("empty")
        with pytest.raises(MapUnavailable, match="attic"):
            await control.keeper.load("attic")
        await control.keeper.load("hall")
        assert things.points == pytest.approx(np.array([[1.0, 2.0]]), abs=0.05)
        await control.keeper.load("empty")
        assert not len(things.points)
        await compute((library.path("hall") / THINGS).write_bytes, b"broken")
        await control.keeper.load("hall")
        assert control.keeper.name == "hall"
        leave()
        things.felt(np.array([[1.0, 2.0]]), 1.0)
        await control.keeper.begin()
        assert len(things.points), "who left is asked no more"

    asyncio.run(live())
    assert "low things on the map hall are not known" in caplog.text


def test_after_a_restart_it_is_read_again(tmp_path: Path) -> None:
    library, control = MapLibrary(tmp_path), MapControl()
    keeper = Keeper(library)
    control.attach(keeper)
    things = ThingsMemory(ROUND, 1.4)
    things.felt(np.array([[1.0, 2.0]]), 1.0)
    layer = ThingsKept(things, library, compute, logging.getLogger("test"))

    async def live() -> None:
        await keeper.save("hall")
        await layer.save("hall")
        anew = ThingsMemory(ROUND, 1.4)
        await ThingsKept(anew, library, compute, logging.getLogger("test")).resume(control)
        assert len(anew.points) == 1

    asyncio.run(live())
