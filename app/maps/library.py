"""The folder of maps: list, save, rename, delete.

A map is a folder of its own: ``map.yaml`` and ``map.pgm`` (as ROS's ``map_server`` reads them), ``zones.yaml``, files
of the module that made it (``graph.npz``, the pose graph with which mapping goes on), and files of others
(``places.yaml``, named poses; ``obstacles.npz``, obstacles that only a camera sees). A map of another program is used
as it is once its YAML file is called ``map.yaml``.
"""

from __future__ import annotations

import contextlib
import errno
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.base.errors import ConfigError
from app.base.named_library import NamedLibrary, data_folder
from app.base.whole_file import write_synced, write_whole
from app.maps.map_file import MOST_CELLS, pgm_bytes, read_map, yaml_text
from app.maps.map_service import MapUnavailable
from app.maps.picture import shown_png
from app.maps.places import read_places, write_places
from app.maps.zones import read_zones, zones_text
from app.messages import OccupancyGrid, Place, Zone

#: Age (s) beyond which an unfinished map is abandoned.
_ABANDONED_S = 3600.0

MAP, PICTURE, ZONES, GRAPH, PLACES = "map.yaml", "map.pgm", "zones.yaml", "graph.npz", "places.yaml"


class UnknownMap(MapUnavailable):
    """There is no map of this name."""


class MapNameTaken(MapUnavailable):
    """Another map has this name already."""


@dataclass(frozen=True, slots=True)
class MapFacts:
    """Facts of a saved map.

    ``size_m``: width and height of its picture; ``known_m2``: area of the known cells; ``saved``: Unix time (s);
    ``graph``: whether mapping can go on from it; ``zones``: their number; ``problem``: the reason why it cannot be
    used, "" if it can (the figures are 0 then).
    """

    name: str
    saved: float
    size_m: tuple[float, float] = (0.0, 0.0)
    resolution_m: float = 0.0
    known_m2: float = 0.0
    graph: bool = False
    zones: int = 0
    problem: str = ""


class MapLibrary(NamedLibrary):
    """Maps in one folder. All methods touch the disk: call them off the event loop.

    Methods that take a name raise ValueError for an invalid one, UnknownMap if no map has it, ConfigError for a map
    whose files are damaged, and OSError.
    """

    kind = "map"

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        #: Several threads call the methods: none may see a map that is half replaced,
        self._replacing = threading.Lock()
        #: and no file may be replaced in a folder that another thread is just making a new one of.
        self._writing = threading.Lock()

    def names(self) -> list[str]:
        """Every map there is, sorted."""
        if not self.folder.is_dir():
            return []
        with self._replacing:
            for left in self.folder.glob(".*.old"):
                # A program that died between the two renames of `keep`, or right after them.
                former = self.folder / left.name[1:].removesuffix(".old")
                if former.exists():
                    shutil.rmtree(left, ignore_errors=True)
                else:
                    left.rename(former)
            for left in self.folder.glob(".new-*"):
                # Left by a program that died while it saved a map: writing one takes less time.
                with contextlib.suppress(FileNotFoundError):  # it was given up, or has become a map, just now
                    if time.time() - left.stat().st_mtime > _ABANDONED_S:
                        shutil.rmtree(left, ignore_errors=True)
        return sorted(name for name, path in self.entries() if (path / MAP).is_file())

    def existing(self, name: str) -> Path:
        """The folder of the map ``name``."""
        path = self.path(name)
        if not (path / MAP).is_file():
            names = self.names()
            if name not in names:
                raise UnknownMap(f"there is no map {name!r}; there are: {', '.join(names) or 'none'}")
        return path

    def listing(self) -> list[MapFacts]:
        """Every map with its facts, sorted by name; ``problem`` describes damage."""
        return [self.facts(name) for name in self.names()]

    def facts(self, name: str) -> MapFacts:
        """Facts of the map ``name``; ``problem`` describes damage."""
        path = self.existing(name)
        saved = (path / MAP).stat().st_mtime
        try:
            grid, zones = self.grid(name), self.zones(name)
        except ConfigError as damage:
            return MapFacts(name, saved, problem=str(damage))
        height, width = grid.cells.shape
        cell = grid.resolution_m
        known = int(np.count_nonzero(grid.cells >= 0))
        size = width * cell, height * cell
        return MapFacts(
            name,
            saved,
            size_m=size,
            resolution_m=cell,
            known_m2=known * cell**2,
            graph=(path / GRAPH).is_file(),
            zones=len(zones),
        )

    def grid(self, name: str) -> OccupancyGrid:
        """Its cells."""
        return read_map(self.existing(name) / MAP)

    def zones(self, name: str) -> tuple[Zone, ...]:
        """Its zones."""
        return read_zones(self.existing(name) / ZONES)

    def places(self, name: str) -> tuple[Place, ...]:
        """Its places."""
        return read_places(self.existing(name) / PLACES)

    def picture(self, name: str) -> bytes:
        """PNG, as people draw maps: free white, occupied black, unknown grey."""
        return shown_png(self.grid(name))

    def keep(
        self,
        name: str,
        grid: OccupancyGrid,
        zones: Iterable[Zone] = (),
        others: Mapping[str, Callable[[Path], None]] | None = None,
        former: str = "",
    ) -> None:
        """Save ``grid`` and ``zones`` as the map ``name``; an older map of this name is replaced, wholly or not at all.

        ``others``: file names, and the function that writes each. ``former``: the name of this map before, if any:
        files that others saved with it are copied.
        """
        path = self.path(name)
        if grid.cells.size > MOST_CELLS:
            raise OSError(
                errno.EFBIG, f"a map of more than {MOST_CELLS // 10**6} million cells could not be read again"
            )
        with self._writing:
            self._keep(path, grid, zones, others or {}, former)

    def _keep(
        self,
        path: Path,
        grid: OccupancyGrid,
        zones: Iterable[Zone],
        others: Mapping[str, Callable[[Path], None]],
        former: str,
    ) -> None:
        along = [] if not former else list(_kept_beside(self.path(former), others))
        self.folder.mkdir(parents=True, exist_ok=True)
        new = Path(tempfile.mkdtemp(prefix=".new-", dir=self.folder))
        try:
            write_synced(new / PICTURE, pgm_bytes(grid))
            write_synced(new / ZONES, zones_text(zones).encode())
            for file, write in others.items():
                write(new / file)
            for kept in along:
                write_synced(new / kept.name, kept.read_bytes())
            write_synced(new / MAP, yaml_text(grid, PICTURE).encode())
            new.chmod(0o755)
            old = self.folder / f".{path.name}.old"
            with self._replacing:
                if path.exists():
                    shutil.rmtree(old, ignore_errors=True)
                    path.rename(old)
                new.rename(path)
            shutil.rmtree(old, ignore_errors=True)
        except BaseException:
            shutil.rmtree(new, ignore_errors=True)
            raise

    def keep_zones(self, name: str, zones: Iterable[Zone]) -> None:
        """Replace the zones of the map ``name``, wholly or not at all."""
        with self._writing:
            write_whole(self.existing(name) / ZONES, zones_text(zones).encode())

    def keep_places(self, name: str, places: Iterable[Place]) -> None:
        """Replace the places of the map ``name``, wholly or not at all."""
        with self._writing:
            write_places(self.existing(name) / PLACES, places)

    def rename(self, name: str, to: str) -> None:
        """Call the map ``name`` ``to`` from now on. Raises MapNameTaken where another has that name."""
        path, target = self.existing(name), self.path(to)
        if to != name:
            if target.exists():
                raise MapNameTaken(f"there is a map {to!r} already: delete it first, or choose another name")
            path.rename(target)

    def delete(self, name: str) -> None:
        """Delete the map ``name`` with all that is kept with it."""
        shutil.rmtree(self.existing(name))


def _kept_beside(folder: Path, others: Container[str]) -> Iterator[Path]:
    """The files in a map's folder that are neither the map's own nor ``others``."""
    own = (MAP, PICTURE, ZONES, GRAPH)
    if folder.is_dir():
        for file in folder.iterdir():
            if file.is_file() and not file.name.startswith(".") and file.name not in own and file.name not in others:
                yield file


def default_folder() -> Path:
    """``$HBBA_MAPS``, or ``hbba/maps`` in the user's data folder."""
    return data_folder("HBBA_MAPS", "maps")
