"""The service of the map in use, for other parts of the program: save, load, place the robot, mark zones.

The module that makes the map attaches a MapServer. Other modules may add a MapLayer: data of theirs that is saved and
loaded with each map, for instance obstacles that only a camera sees.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from app.base.geometry import Pose2
from app.base.observers import Observers
from app.base.service_slot import ServiceSlot
from app.messages import Zone

log = logging.getLogger(__name__)

#: File names, and what writes each.
Files = Mapping[str, Callable[[Path], None]]

#: The desire class that makes and follows maps.
SLAM = "SLAM"


class MapUnavailable(Exception):
    """The request cannot be met now; the message says why and what would help."""


class MapServer(Protocol):
    """Makes and follows the map; all methods are called on the event loop.

    Each raises MapUnavailable, with a message for people, if the request cannot be met; nothing has changed then.
    """

    @property
    def name(self) -> str:
        """The name of the map in use; "" while it has none."""
        ...

    async def save(self, name: str, others: Files | None = None) -> None:
        """Save the map and the files ``others`` under ``name``, its name from then on; an older map of this name is
        replaced, wholly or not at all. Other files saved with the map under its former name are copied."""
        ...

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        """Take the map ``name`` into use. The robot is at ``X_MB``; if None, it localizes itself.

        ``extend``: the map grows further; else it stays as it is.
        """
        ...

    async def begin(self) -> None:
        """Begin an empty map without a name, with the robot at its origin."""
        ...

    async def place(self, X_MB: Pose2) -> None:
        """The robot is about at ``X_MB`` (within 1 m and 0.5 rad): from there its pose is refined."""
        ...

    async def search(self) -> None:
        """Localize the robot, which is anywhere on the map."""
        ...

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        """These are the zones of the map from now on; kept with it at once if it has a name."""
        ...


class MapLayer(Protocol):
    """Data of a module other than the map server that belongs to the map in use; all methods are called on the event
    loop."""

    async def files(self) -> Files:
        """The files to save with the map, as the data is now."""
        ...

    async def load(self, name: str) -> None:
        """Load the layer saved with the map ``name``, which is in use now, in place of the present one.

        Raises MapUnavailable, with a message for people, if it cannot be read.
        """
        ...

    async def clear(self) -> None:
        """A map without a name is in use now, of which nothing is known."""
        ...


class MapService(ServiceSlot[MapServer]):
    """The service of the map in use: its server, which a module attaches while it runs, and the layers beside it."""

    def __init__(self) -> None:
        super().__init__(lambda: MapUnavailable("this program makes no maps: SLAM2D does not run"))
        self._layers = MapLayers()
        self._observers: Observers[[]] = Observers("the map in use")

    async def add(self, layer: MapLayer) -> Callable[[], None]:
        """Save ``layer`` with every map, and load it for the map in use; returns a function that removes it."""
        leave = self._layers.add(layer)
        if self.available:
            await self._load_layers(self.provider.name, same=True)
        return leave

    def on_change(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call ``callback()`` when another map was loaded or created, before its layers are loaded: places on the
        former map are void. Returns a function that ends this."""
        return self._observers.add(callback)

    async def resume(self, name: str, *, same: bool) -> None:
        """Load the layers for the map ``name``, which a map server about to attach has in use.

        ``same``: its former instance used the same map; layers loaded for it stay as they are, for they are newer than
        their files.
        """
        await self._load_layers(name, same=same)

    @property
    def server(self) -> MapServer:
        """The server of the map, with its layers. Raises MapUnavailable while there is none."""
        return _Layered(self.provider, self._layers, self._observers.notify)

    async def _load_layers(self, name: str, *, same: bool) -> None:
        try:
            await self._layers.load(name, same=same)
        except MapUnavailable as lack:
            log.warning("%s", lack)


class MapLayers:
    """All layers, each with the name of the map it was loaded for (None: for none yet)."""

    def __init__(self) -> None:
        self._loaded_for: dict[MapLayer, str | None] = {}

    def add(self, layer: MapLayer) -> Callable[[], None]:
        """Add a layer that was loaded for no map yet; returns a function that removes it."""
        self._loaded_for[layer] = None

        def leave() -> None:
            self._loaded_for.pop(layer, None)

        return leave

    async def load(self, name: str, *, same: bool) -> None:
        """Load every layer for the map ``name`` ("": clear it), also layers added meanwhile; ``same``: only those not
        loaded for it yet. Raises the first MapUnavailable of a layer once all are done."""
        lack: MapUnavailable | None = None
        if not same:
            self._loaded_for = dict.fromkeys(self._loaded_for)
        while (
            due := next((layer for layer, map_name in self._loaded_for.items() if map_name != name), None)
        ) is not None:
            self._loaded_for[due] = name
            try:
                await (due.load(name) if name else due.clear())
            except MapUnavailable as failure:
                lack = lack or failure
        if lack is not None:
            raise lack

    async def files(self, name: str) -> Files:
        """The files of all layers that were loaded for the map ``name``."""
        files: dict[str, Callable[[Path], None]] = {}
        for layer in [layer for layer, map_name in self._loaded_for.items() if map_name == name]:
            files |= await layer.files()
        return files

    def rename(self, former: str, name: str) -> None:
        """Note that the map ``former`` has the name ``name`` now."""
        for layer, map_name in self._loaded_for.items():
            if map_name == former:
                self._loaded_for[layer] = name


class _Layered:
    """A map server with layers."""

    def __init__(self, server: MapServer, layers: MapLayers, changed: Callable[[], None]) -> None:
        self._server = server
        self._layers = layers
        self._changed = changed

    @property
    def name(self) -> str:
        return self._server.name

    async def save(self, name: str, others: Files | None = None) -> None:
        former = self._server.name
        files = {**(others or {}), **await self._layers.files(former)}
        await self._server.save(name, files)
        self._layers.rename(former, name)

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        await self._server.load(name, X_MB, extend)
        self._changed()
        await self._layers.load(name, same=False)

    async def begin(self) -> None:
        await self._server.begin()
        self._changed()
        await self._layers.load("", same=False)

    async def place(self, X_MB: Pose2) -> None:
        await self._server.place(X_MB)

    async def search(self) -> None:
        await self._server.search()

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        await self._server.mark(zones)
