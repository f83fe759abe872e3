"""Places of the map in use: kept with it, loaded with it, judged by it, and moved with their posters."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.maps.library import PLACES, MapLibrary
from app.maps.map_service import Files, MapService, MapUnavailable
from app.maps.place_service import PlaceService
from app.maps.places import places_text, with_pose
from app.maps.poster_places import in_front_of
from app.messages import Landmark, Landmarks, OccupancyGrid, Place, Places, Zone, Zones, read_only
from app.runtime.clock import run_virtual
from tests.maps.grids import room
from tests.modules.fakes import Bench

MODULE = "app.modules.perception.place_keeper:PlaceKeeper"
INPUTS = {"landmarks": Landmarks, "map": OccupancyGrid, "zones": Zones}
DOCK = Place("dock", "Dock", 0.4, 3.6, 0.0)
POSTER = Landmark("tour:lab", (0.4, 4.2, 1.4), 0.05, 3, 1.0, 2.0, heading=-np.pi / 2, heading_sigma=0.1, id=4)


class FakeMapServer:
    """Keeps maps in ``library`` and does nothing else."""

    def __init__(self, library: MapLibrary, name: str = "") -> None:
        self.library = library
        self.name = name

    async def save(self, name: str, others: Files | None = None) -> None:
        await asyncio.to_thread(self.library.keep, name, room(), (), others, self.name)
        self.name = name

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        await asyncio.to_thread(self.library.existing, name)
        self.name = name

    async def begin(self) -> None:
        self.name = ""

    async def place(self, X_MB: Pose2) -> None: ...

    async def search(self) -> None: ...

    async def mark(self, zones: tuple[Zone, ...]) -> None: ...


class Kept:
    """The module, and a map without a name that it is loaded for."""

    def __init__(self, folder: Path) -> None:
        self.library = MapLibrary(folder)
        self.maps, self.service = MapService(), PlaceService()
        services = {MapLibrary: self.library, MapService: self.maps, PlaceService: self.service}
        self.bench = Bench(MODULE, inputs=INPUTS, outputs={"places": Places}, services=services)

    async def __aenter__(self) -> Kept:
        await self.bench.__aenter__()
        self.maps.attach(FakeMapServer(self.library))
        await self.maps.resume("", same=False)
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.bench.__aexit__(*error)

    async def edit(self, change: Callable[[tuple[Place, ...]], Iterable[Place]]) -> tuple[Place, ...]:
        return await self.service.server.edit(change)

    async def feed(self, port: str, message: object) -> None:
        self.bench.feed(port, message)
        await self.bench.settle()

    async def on_disk(self, name: str) -> tuple[Place, ...]:
        return await asyncio.to_thread(self.library.places, name)

    @property
    def published(self) -> tuple[Place, ...]:
        latest = self.bench.graph.channel("places").latest
        assert isinstance(latest, Places)
        return latest.places


def kept(folder: Path, run: Callable[[Kept], Any]) -> None:
    async def main() -> None:
        async with Kept(folder) as keeper:
            await run(keeper)

    run_virtual(main())


def test_they_go_with_their_map(tmp_path: Path) -> None:
    async def run(kept: Kept) -> None:
        assert await kept.edit(lambda places: (*places, DOCK)) == (DOCK,)
        assert kept.published == kept.service.server.places == (DOCK,)
        await kept.maps.server.save("lab")
        assert await kept.on_disk("lab") == (DOCK,)
        # Of a map with a name, every edit is on the disk at once.
        window = Place("window", "Window", -0.4, 3.0, 1.0)
        await kept.edit(lambda places: (*places, window))
        assert await kept.on_disk("lab") == (DOCK, window)
        await kept.maps.server.begin()
        assert kept.published == ()
        await kept.maps.server.save("hall")
        await kept.maps.server.load("lab")
        assert kept.published == (DOCK, window)
        await kept.maps.server.save("copy")
        assert await kept.on_disk("copy") == (DOCK, window)

    kept(tmp_path, run)


def test_a_refused_edit_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def run(kept: Kept) -> None:
        await kept.edit(lambda _: (DOCK,))
        with pytest.raises(ValueError, match="two places are called 'Dock'"):
            await kept.edit(lambda places: (*places, Place("other", "Dock", 0, 0, 0)))
        with pytest.raises(ValueError, match="x: should be less than or equal to 1000, not 2000"):
            await kept.edit(lambda places: [with_pose(place, Pose2(2000, 0, 0)) for place in places])
        with pytest.raises(LookupError):
            await kept.edit(lambda _: {}["missing"])  # type: ignore[arg-type]
        await kept.maps.server.save("lab")

        def full(*_: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(kept.library, "keep_places", full)
        with pytest.raises(MapUnavailable, match="the disk refuses the places: No space left on device"):
            await kept.edit(lambda _: ())
        assert kept.service.server.places == kept.published == await kept.on_disk("lab") == (DOCK,)

    kept(tmp_path, run)


def test_a_damaged_file_is_reported_and_survives(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def run(kept: Kept) -> None:
        await kept.maps.server.save("lab")
        damaged = places_text([DOCK]).replace("0.4", "here")
        file = kept.library.path("lab") / PLACES
        await asyncio.to_thread(file.write_text, damaged, encoding="utf-8")
        await kept.maps.server.load("lab")
        assert "places.yaml:5" in caplog.text
        with pytest.raises(MapUnavailable, match=r"cannot be read, and are not overwritten: .*places.yaml:5"):
            await kept.edit(lambda _: (DOCK,))
        await kept.maps.server.save("lab")
        assert await asyncio.to_thread(file.read_text, encoding="utf-8") == damaged
        # Another map is as good as ever.
        await kept.maps.server.begin()
        await kept.edit(lambda _: (DOCK,))

    kept(tmp_path, run)


def test_without_a_map_there_are_none_and_none_can_be_made(tmp_path: Path) -> None:
    async def main() -> None:
        kept = Kept(tmp_path)
        with pytest.raises(MapUnavailable, match="no PlaceKeeper runs"):
            _ = kept.service.server
        async with kept.bench:
            assert kept.service.server.places == ()
            with pytest.raises(MapUnavailable, match="no map in use"):
                await kept.edit(lambda _: (DOCK,))

    run_virtual(main())


def test_the_map_and_its_zones_speak_against_a_place(tmp_path: Path) -> None:
    async def run(kept: Kept) -> None:
        await kept.edit(lambda _: (DOCK,))
        assert kept.published[0].problem == ""
        square = read_only(np.array([[0.0, 3.0], [1.0, 3.0], [1.0, 4.0], [0.0, 4.0]]))
        await kept.feed("zones", Zones(0.0, (Zone("stairs", "keep_out", square, 1.0),)))
        assert kept.published[0].problem == "it is in the keep-out zone stairs"
        await kept.feed("zones", Zones(0.0, ()))
        assert kept.published[0].problem == ""
        await kept.feed("map", room())
        edited = await kept.edit(lambda places: [with_pose(place, Pose2(0.1, 3.2, 0)) for place in places])
        assert edited[0].problem == "it is in an obstacle of the map"

    kept(tmp_path, run)


def test_a_place_in_front_of_a_poster_moves_with_it(tmp_path: Path) -> None:
    async def run(kept: Kept) -> None:
        await kept.feed("landmarks", Landmarks(0.0, (POSTER,), "map"))
        poster = kept.service.server.posters[0]
        await kept.edit(lambda _: (in_front_of(DOCK, poster),))
        first = kept.published[0]
        assert (first.x, first.y, first.heading) == pytest.approx((0.4, 3.0, np.pi / 2), abs=1e-4)
        corrected = Landmark("tour:lab", (0.6, 4.2, 1.4), 0.05, 4, 1.0, 3.0, heading=-np.pi / 2, id=4)
        await kept.feed("landmarks", Landmarks(1.0, (corrected,), "map"))
        assert kept.published[0].x == pytest.approx(0.6)
        await kept.maps.server.save("lab")
        assert (await kept.on_disk("lab"))[0].x == pytest.approx(0.6)
        await kept.feed("landmarks", Landmarks(2.0, (), "map"))
        assert "its poster is not known" in kept.published[0].problem
        # In odom, nothing is known of where it hangs on the map.
        await kept.feed("landmarks", Landmarks(3.0, (POSTER,), "odom"))
        assert kept.service.server.posters == ()
        assert (kept.published[0].x, kept.published[0].problem) == (pytest.approx(0.6), "")

    kept(tmp_path, run)


def test_after_a_failure_the_places_of_a_map_without_a_name_are_there_again(tmp_path: Path) -> None:
    async def run(kept: Kept) -> None:
        await kept.edit(lambda _: (DOCK,))
        before = kept.service.server
        kept.bench.slot.module.fail(RuntimeError("for the test"))
        while not kept.service.available or kept.service.server is before:
            await kept.bench.clock.sleep(1.0)
        assert kept.service.server.places == (DOCK,)
        # That is of this map alone.
        await kept.maps.server.begin()
        assert kept.service.server.places == ()

    kept(tmp_path, run)
