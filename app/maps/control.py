"""How others speak to whoever keeps the map without knowing the module: save, load, place the robot, mark zones.

Other modules may keep something with each map (a ``MapLayer``): what the camera knows of the floor, for instance.
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

#: File names, and what writes each.
Files = Mapping[str, Callable[[Path], None]]

#: The desire class that makes and follows maps.
SLAM = "SLAM"


class MapUnavailable(Exception):
    """What was asked cannot be done now; the message says why and what would help."""


class MapKeeper(Protocol):
    """What makes and follows the map; all methods are called on the event loop.

    Each raises MapUnavailable, in words for people, for what cannot be done, and then has changed nothing.
    """

    @property
    def name(self) -> str:
        """The name of the map in use; "" while it has none."""
        ...

    async def save(self, name: str, others: Files | None = None) -> None:
        """Keep the map under ``name``, which it has from then on, and ``others`` with it; an older one of this name is
        replaced, wholly or not at all. What else was kept with the map in use, under its former name, goes along."""
        ...

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        """Take the map ``name`` into use, the robot being at ``X_MB`` or, where nobody knows, looking for itself.

        ``extend``: the map goes on growing; else it stays as it is.
        """
        ...

    async def begin(self) -> None:
        """Begin an empty map without a name, the robot at its origin."""
        ...

    async def place(self, X_MB: Pose2) -> None:
        """The robot is about at ``X_MB`` (within 1 m and 0.5 rad): from there its pose is refined."""
        ...

    async def search(self) -> None:
        """The robot is somewhere on the map: look for it."""
        ...

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        """These are the zones of the map from now on; kept with it at once if it has a name."""
        ...


class MapLayer(Protocol):
    """What another module than the keeper knows of the map in use; all methods are called on the event loop."""

    async def files(self) -> Files:
        """What to keep with the map, as it is now."""
        ...

    async def load(self, name: str) -> None:
        """The map ``name`` is in use now: what was kept with it counts, nothing else.

        Raises MapUnavailable, in words for people, where that is not known.
        """
        ...

    async def clear(self) -> None:
        """A map without a name is in use now, of which nothing is known."""
        ...


class MapControl(ServiceSlot[MapKeeper]):
    """The service of the map in use: its keeper, which a module attaches while it runs, and the layers beside it."""

    def __init__(self, log: logging.Logger | None = None) -> None:
        super().__init__(lambda: MapUnavailable("this program makes no maps: SLAM2D does not run"))
        self._layers = Layers()
        self._observers: Observers[[]] = Observers("the map in use")
        self._log = log or logging.getLogger(__name__)

    async def add(self, layer: MapLayer) -> Callable[[], None]:
        """Keep ``layer`` with every map, and tell it of the one in use; returns what takes it away."""
        leave = self._layers.add(layer)
        if self.available:
            await self._told(self.provider.name, same=True)
        return leave

    def on_change(self, callback: Callable[[], None]) -> Callable[[], None]:
        """Call ``callback()`` whenever another map was taken into use or begun, before its layers are told: what was a
        place on the former one is none any more."""
        return self._observers.add(callback)

    async def resume(self, name: str, *, same: bool) -> None:
        """A keeper that is about to attach has the map ``name`` in use; ``same``: its former instance had it too, and
        who was told of it then knows more than what was kept."""
        await self._told(name, same=same)

    @property
    def keeper(self) -> MapKeeper:
        """The keeper of the map, with its layers. Raises MapUnavailable while there is none."""
        return _Layered(self.provider, self._layers, self._observers.notify)

    async def _told(self, name: str, *, same: bool) -> None:
        try:
            await self._layers.tell(name, same=same)
        except MapUnavailable as lack:
            self._log.warning("%s", lack)


class Layers:
    """All layers, and which map each was told of."""

    def __init__(self) -> None:
        self._told: dict[MapLayer, str | None] = {}

    def add(self, layer: MapLayer) -> Callable[[], None]:
        """One more, which was told of none; returns what takes it away."""
        self._told[layer] = None

        def leave() -> None:
            self._told.pop(layer, None)

        return leave

    async def tell(self, name: str, *, same: bool) -> None:
        """Tell all, also those that are added meanwhile, that the map ``name`` is in use ("": it has none); ``same``:
        not those that were told of it before. Raises what the first raises that cannot, once all are told."""
        lack: MapUnavailable | None = None
        if not same:
            self._told = dict.fromkeys(self._told)
        while (due := next((layer for layer, told in self._told.items() if told != name), None)) is not None:
            self._told[due] = name
            try:
                await (due.load(name) if name else due.clear())
            except MapUnavailable as failure:
                lack = lack or failure
        if lack is not None:
            raise lack

    async def files(self, name: str) -> Files:
        """What those keep that were told of the map ``name``."""
        files: dict[str, Callable[[Path], None]] = {}
        for layer in [layer for layer, told in self._told.items() if told == name]:
            files |= await layer.files()
        return files

    def call(self, name: str, former: str) -> None:
        """The map ``former`` has this name from now on."""
        for layer, told in self._told.items():
            if told == former:
                self._told[layer] = name


class _Layered:
    """A keeper with layers."""

    def __init__(self, keeper: MapKeeper, layers: Layers, changed: Callable[[], None]) -> None:
        self._keeper = keeper
        self._layers = layers
        self._changed = changed

    @property
    def name(self) -> str:
        return self._keeper.name

    async def save(self, name: str, others: Files | None = None) -> None:
        former = self._keeper.name
        files = {**(others or {}), **await self._layers.files(former)}
        await self._keeper.save(name, files)
        self._layers.call(name, former)

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        await self._keeper.load(name, X_MB, extend)
        self._changed()
        await self._layers.tell(name, same=False)

    async def begin(self) -> None:
        await self._keeper.begin()
        self._changed()
        await self._layers.tell("", same=False)

    async def place(self, X_MB: Pose2) -> None:
        await self._keeper.place(X_MB)

    async def search(self) -> None:
        await self._keeper.search()

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        await self._keeper.mark(zones)
