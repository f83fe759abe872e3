"""PlaceKeeper: keeps the named places of the map in use.

    ┌──────────────────────────────────────────────────────────────────────────────────────────┐
    │ PlaceKeeper    in   landmarks  Landmarks: posters that places follow, once on the map     │
    │                in   map        OccupancyGrid of the map, when it changes                  │
    │                in   zones      Zones of the map, when one changes                         │
    │                out  places     Places of the map, when one changes                        │
    │                is the PlaceServer, and a MapLayer: places.yaml beside the map             │
    └──────────────────────────────────────────────────────────────────────────────────────────┘

A place in front of a poster follows it as the map is corrected (``app/maps/poster_places.py``). Each place says whether
the robot could stand there, by the map and its zones (``app/maps/place_checks.py``). It keeps no source awake.
"""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any

from pydantic import Field

from app.maps.library import MapLibrary
from app.maps.map_service import MapService
from app.maps.place_book import PlaceBook
from app.maps.place_checks import Surroundings, inscribed_radius_m, judged
from app.maps.place_service import PlaceService
from app.maps.poster_places import STAND_OFF_M, Poster, posters_of
from app.messages import Landmarks, OccupancyGrid, Place, Places, Zone, Zones
from app.modules.stream_module import robot_link
from app.runtime.module import Input, Module, ModuleContext, Settings

#: Key of the map's name and the places that the next instance takes over.
_KEPT = "places"


class PlaceKeeperSettings(Settings):
    stand_off_m: float = Field(STAND_OFF_M, ge=0.3, le=5, description="how far from a poster a place in front of it is")


class PlaceKeeper(Module):
    title = "Places"
    Settings = PlaceKeeperSettings
    settings: PlaceKeeperSettings

    _book: PlaceBook

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._posters: tuple[Poster, ...] | None = None
        self._grid: OccupancyGrid | None = None
        self._zones: tuple[Zone, ...] = ()
        self._radius_m = 0.0
        self._stack = ExitStack()
        self.landmarks = self.input("landmarks", Landmarks, wants="never")
        self.map = self.input("map", OccupancyGrid, wants="never")
        self.zones = self.input("zones", Zones, wants="never")
        self.places = self.output("places", Places)
        self.on(self.landmarks, self._take_landmarks)
        self.on(self.map, self._take_map)
        self.on(self.zones, self._take_zones)

    async def start(self) -> None:
        """Take the places of the map in use, and offer them to others."""
        self._radius_m = inscribed_radius_m(robot_link(self).description.footprint)
        maps = self.service(MapService)
        self._book = PlaceBook(
            self.service(MapLibrary),
            in_use=lambda: maps.server.name if maps.available else "",
            behind=self.compute_background,
            judge=self._judge,
            changed=self._publish,
            log=self.log,
            former=self._former(),
        )
        self._take(_latest(self.landmarks), _latest(self.map), _latest(self.zones))
        self._stack.callback(maps.on_change(self._book.leave))
        self._stack.callback(await maps.add(self._book))
        self._stack.callback(self.service(PlaceService).attach(self._book))

    async def stop(self) -> None:
        """Offer them no more."""
        self._stack.close()

    def _former(self) -> tuple[str | None, tuple[Place, ...]] | None:
        """The places before a failure, or, where a recording jumps, those that were recorded."""
        former: tuple[str | None, tuple[Place, ...]] | None = self.persistent.get(_KEPT)
        recorded: Places | None = None if self.places.channel is None else self.places.channel.latest
        return former if former is not None or recorded is None else (None, recorded.places)

    async def _take_landmarks(self, landmarks: Landmarks) -> None:
        self._take(landmarks, None, None)
        await self._book.revise()

    async def _take_map(self, grid: OccupancyGrid) -> None:
        self._take(None, grid, None)
        await self._book.revise()

    async def _take_zones(self, zones: Zones) -> None:
        self._take(None, None, zones)
        await self._book.revise()

    def _take(self, landmarks: Landmarks | None, grid: OccupancyGrid | None, zones: Zones | None) -> None:
        if landmarks is not None:
            self._posters = posters_of(landmarks)
            self._book.posters = self._posters or ()
        if grid is not None:
            self._grid = grid
        if zones is not None:
            self._zones = zones.zones

    async def _judge(self, places: tuple[Place, ...]) -> tuple[Place, ...]:
        surroundings = Surroundings(
            self._posters, self._grid, self._zones, radius_m=self._radius_m, stand_off_m=self.settings.stand_off_m
        )
        return await self.compute(judged, places, surroundings)

    def _publish(self, name: str, places: tuple[Place, ...]) -> None:
        self.persistent[_KEPT] = name, places
        self.places.publish(Places(self.clock.now(), places))


def _latest(port: Input[Any]) -> Any:
    return None if port.channel is None else port.channel.latest
