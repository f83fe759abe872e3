"""Initial map of SLAM2D: the one in use before a failure, a saved one, the published grid, or an empty one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.base.geometry import Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import MapUnavailable
from app.messages import Localization, OccupancyGrid, Zone

if TYPE_CHECKING:  # kernels are compiled or loaded on import
    from app.modules.perception.slam.map_session import MapSession, StoredMap
    from app.modules.perception.slam.types import SlamState

#: Makes a session on a saved map (None: an empty one), with the robot by this ``X_MO``; the flag: whether it grows.
NewSession = Callable[["StoredMap | None", Pose2 | None, bool], "MapSession"]


@dataclass(slots=True)
class RestartState:
    """State that one instance of the module passes to the next: the map in use, whether it grows (None: as configured),
    and, of one that grew, its state so far. ``known``: whether there was an earlier instance."""

    name: str | None = None
    grows: bool | None = None
    grown: SlamState | None = None
    known: bool = False

    def use(self, *, grows: bool) -> None:
        """Store that another map is in use, without any growth yet."""
        self.grows, self.grown, self.known = grows, None, True


@dataclass(frozen=True, slots=True)
class LastPublished:
    """The newest published messages, from before a restart or at a position in a recording."""

    grid: OccupancyGrid | None
    place: Localization | None
    zones: tuple[Zone, ...]

    @property
    def X_MO(self) -> Pose2 | None:
        """Pose of ``odom`` on the map."""
        return None if self.place is None else self.place.X_MO


@dataclass(frozen=True, slots=True, eq=False)
class InitialMap:
    """The initial map. ``refused``: why a saved map cannot be used; ``stopped``: it grew and no longer does; ``same``:
    the earlier instance used it."""

    session: MapSession
    name: str = ""
    zones: tuple[Zone, ...] = ()
    refused: str = ""
    stopped: bool = False
    same: bool = False


def choose_initial_map(
    restart_state: RestartState,
    last_published: LastPublished,
    library: MapLibrary,
    new: NewSession,
    configured: str,
    extend: bool,
) -> InitialMap:
    """*Behind.* Choose the initial map; ``configured``: name of the map without other knowledge, ``extend``: whether it
    grows."""
    from app.modules.perception.slam.map_session import MapSession, StoredMap, stored_map

    grown = restart_state.grown
    name = configured if restart_state.name is None else restart_state.name
    grows = extend if restart_state.grows is None else restart_state.grows
    if grown is not None and last_published.grid is not None:
        # Used for one restart only: a failure before the next growth may be caused by this state, and the restart after
        # it goes on without.
        return InitialMap(
            new(StoredMap("", last_published.grid, (), grown), last_published.X_MO, True),
            name,
            last_published.zones,
            same=True,
        )
    refused = ""
    if name:
        try:
            kept = stored_map(library, name)
            session = new(kept, last_published.X_MO, grows and kept.state is not None)
            return InitialMap(session, name, kept.zones, same=restart_state.known)
        except MapUnavailable as refusal:
            refused = str(refusal)
    if last_published.grid is not None and last_published.place is not None and (last_published.grid.cells >= 0).any():
        session = MapSession(last_published.grid, grows=False, X_MO=last_published.X_MO)
        return InitialMap(
            session,
            last_published.place.map,
            last_published.zones,
            refused,
            stopped=grows and restart_state.known,
            same=restart_state.known,
        )
    return InitialMap(new(None, None, True), refused=refused)
