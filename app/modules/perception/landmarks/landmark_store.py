"""Saving of landmarks with their map: ``landmarks.npz`` in the map's folder."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.maps.library import MapLibrary
from app.maps.map_service import Files
from app.modules.perception.landmarks.landmark_file import (
    LANDMARKS_FILE,
    NONE,
    StoredLandmarks,
    read_landmarks,
    write_landmarks,
)


class LandmarkStore:
    """Implements :class:`app.maps.map_service.MapLayer` for landmarks that ``snapshot`` returns and ``take``
    takes over.

    ``behind`` calls in a thread where the disk may block. ``resumed``: landmarks are known from before a restart, which
    are newer than the file of the first map.
    """

    def __init__(
        self,
        snapshot: Callable[[], StoredLandmarks],
        take: Callable[[StoredLandmarks], None],
        *,
        library: MapLibrary,
        behind: Callable[..., Awaitable[Any]],
        log: logging.Logger | logging.LoggerAdapter[logging.Logger],
        resumed: bool,
    ) -> None:
        self._resumed = resumed
        self._snapshot = snapshot
        self._take = take
        self._library = library
        self._behind = behind
        self._log = log

    async def files(self) -> Files:
        """The landmarks' file, for the folder of the map."""
        return {LANDMARKS_FILE: partial(write_landmarks, stored=self._snapshot())}

    async def load(self, name: str) -> None:
        """Take over the landmarks of the map ``name``. A damaged file is logged, and the map is used without. Raises
        MapUnavailable where there is no such map."""
        resumed, self._resumed = self._resumed, False
        if resumed:
            return
        try:
            stored = await self._behind(self._read, name)
        except (ConfigError, OSError) as failure:
            self._log.warning("landmarks on the map %s are not known: %s", name, failure)
            stored = NONE
        self._take(stored)

    async def clear(self) -> None:
        """An empty map has no landmarks: those of the map before went when it did."""
        self._resumed = False

    def _read(self, name: str) -> StoredLandmarks:
        path: Path = self._library.existing(name) / LANDMARKS_FILE
        return read_landmarks(path)
