"""How others speak to whoever keeps the map without knowing the module: save, load, place the robot, mark zones.

Other modules may keep something with each map (a ``MapLayer``): what the camera knows of the floor, for instance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from app.geometry import Pose2
from app.messages import Zone

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

    async def save(self, name: str) -> None:
        """Keep the map under ``name``, which it has from then on; an older one of this name is replaced."""
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
    """What another module than the keeper knows of the map in use; all methods are called on the event loop, once the
    keeper has done the same. Each raises MapUnavailable, in words for people."""

    async def save(self, name: str) -> None:
        """Keep it with the map ``name``, which was just written anew."""
        ...

    async def load(self, name: str) -> None:
        """The map ``name`` is in use now: what was kept with it counts, nothing else."""
        ...

    async def forget(self) -> None:
        """An empty map is in use now."""
        ...


class MapControl:
    """The one way to the map: a service of the program. The module attaches itself while it lives."""

    def __init__(self) -> None:
        self._keeper: MapKeeper | None = None
        self._layers: list[MapLayer] = []

    def add(self, layer: MapLayer) -> Callable[[], None]:
        """Keep ``layer`` with every map; returns what takes it away."""
        self._layers.append(layer)
        return lambda: self._layers.remove(layer)

    def attach(self, keeper: MapKeeper) -> Callable[[], None]:
        """The keeper is there; returns what detaches it."""
        self._keeper = keeper

        def detach() -> None:
            if self._keeper is keeper:
                self._keeper = None

        return detach

    @property
    def available(self) -> bool:
        """Whether anybody keeps a map."""
        return self._keeper is not None

    @property
    def keeper(self) -> MapKeeper:
        """Whoever keeps the map. Raises MapUnavailable where nobody does."""
        if self._keeper is None:
            raise MapUnavailable("this program makes no maps: SLAM2D does not run")
        return _Layered(self._keeper, tuple(self._layers)) if self._layers else self._keeper


class _Layered:
    """A keeper with layers."""

    def __init__(self, keeper: MapKeeper, layers: tuple[MapLayer, ...]) -> None:
        self._keeper = keeper
        self._layers = layers
        self.place = keeper.place
        self.search = keeper.search
        self.mark = keeper.mark

    @property
    def name(self) -> str:
        return self._keeper.name

    async def save(self, name: str) -> None:
        await self._keeper.save(name)
        for layer in self._layers:
            await layer.save(name)

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        await self._keeper.load(name, X_MB, extend)
        for layer in self._layers:
            await layer.load(name)

    async def begin(self) -> None:
        await self._keeper.begin()
        for layer in self._layers:
            await layer.forget()
