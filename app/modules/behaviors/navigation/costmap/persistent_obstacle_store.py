"""Saving of persistent obstacles with their map: ``obstacles.npz`` in the map's folder."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from app.base.errors import ConfigError
from app.maps.library import MapLibrary
from app.maps.map_service import Files
from app.modules.behaviors.navigation.costmap.persistent_obstacle_file import (
    PersistentObstacles,
    read_obstacles,
    write_obstacles,
)
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import PersistentObstacleLayer

OBSTACLES_FILE = "obstacles.npz"


class PersistentObstacleStore:
    """Implements :class:`app.maps.map_service.MapLayer` for a layer that one thread uses: ``compute`` calls in that
    thread, ``behind`` in another, where the disk may block."""

    def __init__(
        self,
        layer: PersistentObstacleLayer,
        library: MapLibrary,
        compute: Callable[..., Awaitable[Any]],
        behind: Callable[..., Awaitable[Any]],
        log: logging.Logger | logging.LoggerAdapter[logging.Logger],
    ) -> None:
        self._layer = layer
        self._library = library
        self._compute = compute
        self._behind = behind
        self._log = log
        self._one = asyncio.Lock()

    async def files(self) -> Files:
        """The layer's file, for the folder of the map."""
        async with self._one:
            obstacles: PersistentObstacles = await self._compute(self._layer.snapshot)
        return {
            OBSTACLES_FILE: partial(
                write_obstacles, obstacles=obstacles, resolution_m=self._layer.settings.resolution_m
            )
        }

    async def load(self, name: str) -> None:
        """Load the obstacles of map ``name``. A damaged or missing file is logged, and the map is used without. Raises
        MapUnavailable where there is no such map."""
        async with self._one:
            # The map changed, whether or not its file can be read.
            await self._compute(self._layer.clear)
            try:
                obstacles = await self._behind(self._read, name)
            except (ConfigError, OSError) as failure:
                self._log.warning("low obstacles on the map %s are not known: %s", name, failure)
                return
            await self._compute(self._layer.take, obstacles)

    async def clear(self) -> None:
        """Drop all obstacles, for an empty map."""
        async with self._one:
            await self._compute(self._layer.clear)

    def _read(self, name: str) -> PersistentObstacles:
        return read_obstacles(self._library.existing(name) / OBSTACLES_FILE, self._layer.settings.resolution_m)
