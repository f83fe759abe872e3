"""The places of the map in use: in memory, and in ``places.yaml`` beside the map."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.base.errors import ConfigError
from app.base.yaml_source import validation_message
from app.maps.library import PLACES, MapLibrary
from app.maps.map_service import Files, MapUnavailable
from app.maps.place_service import Change
from app.maps.places import PlaceEntry, checked, write_places
from app.maps.poster_places import Poster
from app.messages import Place

#: Gives places their problems; may move those that follow a poster.
Judge = Callable[[tuple[Place, ...]], Awaitable[tuple[Place, ...]]]


class PlaceBook:
    """Implements :class:`app.maps.place_service.PlaceServer` and :class:`app.maps.map_service.MapLayer`.

    Places that a poster moved are written with the map, or at the next edit. A file that cannot be read stays as it is,
    and its map is used without places, which cannot be edited then.
    """

    def __init__(
        self,
        library: MapLibrary,
        *,
        in_use: Callable[[], str],
        behind: Callable[..., Awaitable[Any]],
        judge: Judge,
        changed: Callable[[str, tuple[Place, ...]], None],
        log: logging.Logger | logging.LoggerAdapter[logging.Logger],
        former: tuple[str | None, tuple[Place, ...]] | None = None,
    ) -> None:
        """``in_use`` gives the name of the map in use, "" while it has none; ``behind`` calls in a thread where the
        disk may block; ``changed(map, places)`` is called after every change. ``former``: the places of a
        book before this one and their map, taken over where the same map is in use; None: on whatever map."""
        self._library = library
        self._in_use = in_use
        self._behind = behind
        self._judge = judge
        self._changed = changed
        self._log = log
        self._former = former
        self._one = asyncio.Lock()
        self._places: tuple[Place, ...] = ()
        #: Whether the places are those of the map in use.
        self._loaded = False
        #: What is wrong with their file, in words.
        self._damage = ""
        self.posters: tuple[Poster, ...] = ()

    @property
    def places(self) -> tuple[Place, ...]:
        return self._places if self._loaded else ()

    async def edit(self, change: Change) -> tuple[Place, ...]:
        async with self._one:
            if not self._loaded:
                raise MapUnavailable("there is no map in use yet: its places are not known")
            if self._damage:
                raise MapUnavailable(
                    f"the places of this map cannot be read, and are not overwritten: {self._damage}; mend or delete "
                    "that file, and load the map again"
                )
            before = self._places
            after = await self._judge(_valid(change(before)))
            if not self._loaded:  # another map came into use meanwhile
                raise MapUnavailable("another map was loaded meanwhile: nothing was changed")
            # A map that is being saved just now takes these along.
            self._places = after
            if name := self._in_use():
                try:
                    await self._behind(self._library.keep_places, name, after)
                except (OSError, MapUnavailable) as failure:
                    self._places = before
                    why = getattr(failure, "strerror", None) or failure
                    raise MapUnavailable(f"the disk refuses the places: {why}") from None
            self._changed(name, after)
            return after

    async def revise(self) -> None:
        """Judge the places again: the map, its zones or its posters changed."""
        async with self._one:
            if not (self._loaded and self._places):
                return
            after = await self._judge(self._places)
            if self._loaded and after != self._places:
                self._places = after
                self._changed(self._in_use(), after)

    def leave(self) -> None:
        """Another map is in use now: these places are not its."""
        self._loaded = False

    # --- With the map -------------------------------------------------------------------------------------------------

    async def files(self) -> Files:
        """The file of the places; none where theirs could not be read, so that it is kept."""
        return {} if self._damage else {PLACES: self._write}

    async def load(self, name: str) -> None:
        """Take the places of the map ``name``. Raises MapUnavailable where there is no such map."""
        async with self._one:
            self._damage = ""
            if (former := self._former_on(name)) is not None:
                await self._take(former)
                return
            try:
                places = await self._behind(self._library.places, name)
            except (ConfigError, OSError) as failure:
                self._damage = str(failure)
                self._log.warning("the places of the map %s are not known: %s", name, failure)
                places = ()
            await self._take(places)

    async def clear(self) -> None:
        """Begin without places: the map has no name, and is new."""
        async with self._one:
            self._damage = ""
            await self._take(self._former_on("") or ())

    def _former_on(self, name: str) -> tuple[Place, ...] | None:
        """The places to take over for the first map; None for none."""
        former, self._former = self._former, None
        return None if former is None or former[0] not in (name, None) else former[1]

    def _write(self, path: Path) -> None:
        write_places(path, self._places)

    async def _take(self, places: tuple[Place, ...]) -> None:
        self._places = await self._judge(places)
        self._loaded = True
        self._changed(self._in_use(), self._places)


def _valid(places: Any) -> tuple[Place, ...]:
    """``checked``, with a mistake in one sentence. Raises ValueError."""
    try:
        return checked(places)
    except ValidationError as refusal:
        first = refusal.errors(include_url=False)[0]
        field = f"{first['loc'][0]}: " if first["loc"] else ""
        raise ValueError(f"{field}{validation_message(PlaceEntry, first)}") from None
