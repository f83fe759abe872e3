"""The MapServer of a module that localizes on its maps: saves, loads and begins them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from app.base.geometry import Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import MapUnavailable
from app.maps.zones import checked
from app.messages import Zone

if TYPE_CHECKING:  # kernels are compiled or loaded on import
    from app.modules.perception.slam_2d import SLAM2D


class SlamMapServer:
    """Implements :class:`app.maps.map_service.MapServer`: one operation at a time, in the order of the calls."""

    def __init__(self, host: SLAM2D, library: MapLibrary) -> None:
        self._host = host
        self._library = library
        self._one = asyncio.Lock()

    @property
    def name(self) -> str:
        return self._host.map_name

    async def save(self, name: str, others: Mapping[str, Callable[[Path], None]] | None = None) -> None:
        from app.modules.perception.slam.map_session import keep

        host = self._host
        self._checked(name)
        async with self._one:
            session = host.session
            await host.finish(session)
            grid = session.grid
            if grid is None or not (grid.cells >= 0).any():
                raise MapUnavailable("there is nothing to keep yet: let the robot see something with SLAM in force")
            state = await host.compute(session.state)
            await host.compute_background(
                keep, self._library, name, grid, host.known_zones, state, others or {}, host.map_name
            )
            host.call(name)

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        from app.modules.perception.slam.map_session import stored_map

        host = self._host
        self._checked(name)
        async with self._one:
            kept = await host.compute_background(stored_map, self._library, name)
            if extend and kept.state is None:
                raise MapUnavailable(
                    f"the map {name!r} was kept without its graph: the robot can find itself on it, but it cannot grow"
                )
            X_MO = None if X_MB is None else X_MB @ host.X_OB.inverse()
            session = await host.compute_background(host.new_session, kept, X_MO, extend)
            host.use(session, name, kept.zones)

    async def begin(self) -> None:
        async with self._one:
            X_MO = self._host.X_OB.inverse()
            session = await self._host.compute_background(self._host.new_session, None, X_MO, True)
            self._host.use(session, "", ())

    async def place(self, X_MB: Pose2) -> None:
        async with self._one:
            session = self._host.session
            if session.grid is None:
                raise MapUnavailable("there is no map yet to place the robot on: drive a little first, or load one")
            await self._host.compute(session.place, X_MB @ self._host.X_OB.inverse())
            self._host.placed()

    async def search(self) -> None:
        async with self._one:
            session = self._host.session
            if session.grid is None:
                raise MapUnavailable("there is no map yet to look on: drive a little first, or load one that was kept")
            await self._host.compute(session.lose)
            self._host.search()

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        try:
            zones = checked(zones)
        except ValueError as mistake:
            raise MapUnavailable(f"these zones cannot be: {mistake}") from None
        async with self._one:
            name = self._host.map_name
            if name:
                try:
                    await self._host.compute_background(self._library.keep_zones, name, zones)
                except OSError as failure:
                    raise MapUnavailable(f"the disk refuses the zones: {failure.strerror or failure}") from None
            self._host.mark(zones)

    def _checked(self, name: str) -> None:
        try:
            self._library.path(name)
        except ValueError as mistake:
            raise MapUnavailable(str(mistake)) from None
