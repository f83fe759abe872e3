"""What the camera knows of a place, kept with its map: ``things.npz`` in the map's folder."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from app.errors import ConfigError
from app.maps.control import MapControl, MapUnavailable
from app.maps.library import MapLibrary, UnknownMap
from app.modules.behaviors.navigation.memory import ThingsMemory
from app.modules.behaviors.navigation.things_file import read_things, write_things

THINGS = "things.npz"


class ThingsKept:
    """Implements :class:`app.maps.control.MapLayer` for a memory that one thread uses: ``compute`` calls in it."""

    def __init__(
        self,
        things: ThingsMemory,
        library: MapLibrary,
        compute: Callable[..., Awaitable[Any]],
        log: logging.Logger | logging.LoggerAdapter[logging.Logger],
    ) -> None:
        self._things = things
        self._library = library
        self._compute = compute
        self._log = log

    async def resume(self, control: MapControl) -> None:
        """What was kept with the map in use counts: after a failure, or where the map was there first."""
        if control.available and control.keeper.name:
            try:
                await self.load(control.keeper.name)
            except UnknownMap:
                self._log.info("the map in use is not kept any more: nothing is known of low things on it")

    async def save(self, name: str) -> None:
        """Write it beside the map."""
        try:
            await self._compute(self._save, name)
        except (OSError, ConfigError) as failure:
            raise MapUnavailable(f"the disk refuses what the camera saw of the map {name!r}: {failure}") from None

    async def load(self, name: str) -> None:
        """Take what was kept; what is damaged is said, and the map is used without."""
        try:
            await self._compute(self._load, name)
        except ConfigError as failure:
            self._log.warning("low things on the map %s are not known: %s", name, failure)
            await self.forget()

    async def forget(self) -> None:
        """Begin anew."""
        await self._compute(self._things.forget)

    def _save(self, name: str) -> None:
        file = self._library.existing(name) / THINGS
        new = file.with_name(f".{THINGS}.new")
        write_things(new, self._things.snapshot(), self._things.settings.resolution_m)
        new.replace(file)

    def _load(self, name: str) -> None:
        file: Path = self._library.existing(name) / THINGS
        self._things.take(read_things(file, self._things.settings.resolution_m))
