"""The map that SLAM2D begins with: the one in use when it failed, one that was kept, what is shown, or an empty one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from app.base.geometry import Pose2
from app.maps.control import MapUnavailable
from app.maps.library import MapLibrary
from app.messages import Localization, OccupancyGrid, Zone

if TYPE_CHECKING:  # it is compiled, or loaded, when it is imported
    from app.modules.perception.slam.session import MapSession, StoredMap
    from app.modules.perception.slam.types import SlamState

_MAP, _GROWS, _GROWN = "map", "grows", "grown"

#: Makes a session on a map that was kept (None: an empty one), the robot being where this ``X_MO`` has it, which grows.
NewSession = Callable[["StoredMap | None", Pose2 | None, bool], "MapSession"]


class RestartState:
    """What an instance of the module leaves to the next, in ``kept`` (``Module.kept``)."""

    def __init__(self, kept: dict[str, Any]) -> None:
        self._kept = kept

    def call(self, name: str) -> None:
        """The map in use has this name."""
        self._kept[_MAP] = name

    def use(self, *, grows: bool) -> None:
        """A map is taken into use; it has not grown yet."""
        self._kept[_GROWS] = grows
        self._kept.pop(_GROWN, None)

    def grow(self, state: SlamState | None) -> None:
        """So far has it grown."""
        self._kept[_GROWN] = state

    def known(self) -> bool:
        """Whether there was an instance before."""
        return bool(self._kept)

    def name(self, configured: str) -> str:
        """Of the map to begin with."""
        name: str = self._kept.get(_MAP, configured)
        return name

    def grows(self, configured: bool) -> bool:
        """Whether that is to grow."""
        grows: bool = self._kept.get(_GROWS, configured)
        return grows

    def grown(self) -> SlamState | None:
        """How far the map in use had grown."""
        return self._kept.get(_GROWN)


@dataclass(frozen=True, slots=True)
class LastPublished:
    """What was told last, before a restart or at some place of a recording."""

    grid: OccupancyGrid | None
    place: Localization | None
    zones: tuple[Zone, ...]

    @property
    def X_MO(self) -> Pose2 | None:
        """Where odometry's frame was on the map."""
        return None if self.place is None else self.place.X_MO


@dataclass(frozen=True, slots=True, eq=False)
class InitialMap:
    """The map to begin with. ``refused``: why a kept one cannot be used; ``stopped``: it grew, and does no more;
    ``same``: the instance before had it in use."""

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
    """*Behind.* Choose the map; ``configured`` by name if nothing else is known, and to ``extend``."""
    from app.modules.perception.slam.session import MapSession, StoredMap, stored_map

    name, grows, grown = restart_state.name(configured), restart_state.grows(extend), restart_state.grown()
    if grown is not None and last_published.grid is not None:
        # Left once: who fails again before the map grew goes on without what may be the cause.
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
            return InitialMap(session, name, kept.zones, same=restart_state.known())
        except MapUnavailable as refusal:
            refused = str(refusal)
    if last_published.grid is not None and last_published.place is not None and (last_published.grid.cells >= 0).any():
        session = MapSession(last_published.grid, grows=False, X_MO=last_published.X_MO)
        return InitialMap(
            session,
            last_published.place.map,
            last_published.zones,
            refused,
            stopped=grows and restart_state.known(),
            same=restart_state.known(),
        )
    return InitialMap(new(None, None, True), refused=refused)
