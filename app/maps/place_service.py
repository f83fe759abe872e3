"""The service of the places of the map in use, for other parts of the program; the module that keeps them attaches a
PlaceServer."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

from app.base.service_slot import ServiceSlot
from app.maps.map_service import MapUnavailable
from app.maps.poster_places import Poster
from app.messages import Place

#: Makes the new places of the present ones.
Change = Callable[[tuple[Place, ...]], Iterable[Place]]


class PlaceServer(Protocol):
    """Keeps the places of the map in use; all methods are called on the event loop."""

    @property
    def places(self) -> tuple[Place, ...]:
        """Every place, in the order of their making."""
        ...

    @property
    def posters(self) -> tuple[Poster, ...]:
        """Every poster known on the map."""
        ...

    async def edit(self, change: Change) -> tuple[Place, ...]:
        """Replace the places by ``change(places)``, and keep them with the map at once if it has a name; returns them.

        No other edit comes between what ``change`` is given and what it returns. Raises what ``change`` raises,
        ValueError for places that may not be, and MapUnavailable, with a message for people, if the request cannot be
        met; nothing has changed then.
        """
        ...


class PlaceService(ServiceSlot[PlaceServer]):
    """The service of the places of the map in use: its server, which a module attaches while it runs."""

    def __init__(self) -> None:
        super().__init__(lambda: MapUnavailable("this program keeps no places: no PlaceKeeper runs"))

    @property
    def server(self) -> PlaceServer:
        """The server of the places. Raises MapUnavailable while there is none."""
        return self.provider
