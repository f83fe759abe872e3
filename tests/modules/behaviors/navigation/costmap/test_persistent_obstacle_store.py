"""What the camera knows of a place goes with its map."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import Files, MapService, MapUnavailable
from app.messages import Zone
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import PersistentObstacleLayer
from app.modules.behaviors.navigation.costmap.persistent_obstacle_store import OBSTACLES_FILE, PersistentObstacleStore
from tests.modules.behaviors.driven_world import box, mapped
from tests.modules.behaviors.navigation.maps import ROUND

GRID = mapped(box(0.1, 0.1, 3.9, 3.9), (0.0, 0.0, 4.0, 4.0))


class FakeMapServer:
    """Keeps maps in ``library`` and does nothing else."""

    def __init__(self, library: MapLibrary) -> None:
        self.library = library
        self.name = ""

    async def save(self, name: str, others: Files | None = None) -> None:
        await compute(self.library.keep, name, GRID, (), others, self.name)
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


def layer_of(things: PersistentObstacleLayer, library: MapLibrary) -> PersistentObstacleStore:
    return PersistentObstacleStore(things, library, compute, compute, logging.getLogger("test"))


def there(x: float, y: float) -> PersistentObstacleLayer:
    things = PersistentObstacleLayer(ROUND, 1.4)
    things.add_contacts(np.array([[x, y]]), 1.0)
    return things


async def test_it_is_kept_loaded_and_forgotten_with_the_map(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    library, control = MapLibrary(tmp_path), MapService()
    control.attach(FakeMapServer(library))
    things = PersistentObstacleLayer(ROUND, 1.4)
    leave = await control.add(layer_of(things, library))
    things.add_contacts(np.array([[1.0, 2.0]]), 1.0)
    await control.server.save("hall")
    await control.server.begin()
    assert not len(things.points)
    await control.server.save("empty")
    with pytest.raises(MapUnavailable, match="attic"):
        await control.server.load("attic")
    await control.server.load("hall")
    assert things.points == pytest.approx(np.array([[1.0, 2.0]]), abs=0.05)
    await control.server.load("empty")
    assert not len(things.points)
    await compute((library.path("hall") / OBSTACLES_FILE).write_bytes, b"broken")
    await control.server.load("hall")
    assert control.server.name == "hall"
    leave()
    things.add_contacts(np.array([[1.0, 2.0]]), 1.0)
    await control.server.begin()
    assert len(things.points), "who left is asked no more"
    assert "low obstacles on the map hall are not known" in caplog.text


async def test_after_a_restart_it_is_read_again_in_either_order(tmp_path: Path) -> None:
    library = MapLibrary(tmp_path)
    server = FakeMapServer(library)
    await server.save("hall", await layer_of(there(1.0, 2.0), library).files())
    for server_first in (True, False):
        control, reloaded = MapService(), PersistentObstacleLayer(ROUND, 1.4)
        if server_first:
            await control.resume("hall", same=False)
            control.attach(server)
        await control.add(layer_of(reloaded, library))
        if not server_first:
            await control.resume("hall", same=False)
            control.attach(server)
        assert len(reloaded.points) == 1


async def test_it_is_not_lost_by_saving_without_its_layer_nor_by_a_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library, control = MapLibrary(tmp_path), MapService()
    control.attach(FakeMapServer(library))
    leave = await control.add(layer_of(things := PersistentObstacleLayer(ROUND, 1.4), library))
    things.add_contacts(np.array([[1.0, 2.0]]), 1.0)
    await control.server.save("hall")
    whole = (library.path("hall") / OBSTACLES_FILE).read_bytes()

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("numpy.savez_compressed", full)
        with pytest.raises(OSError, match="No space"):
            await control.server.save("hall")
    assert (library.path("hall") / OBSTACLES_FILE).read_bytes() == whole
    leave()
    await control.server.save("hall")
    await control.server.save("ground-floor")
    assert (library.path("ground-floor") / OBSTACLES_FILE).read_bytes() == whole
    await control.server.begin()
    await control.server.save("hall")
    assert not (library.path("hall") / OBSTACLES_FILE).exists(), "it is another map"
