"""The service that plans ways on the map in use without driving them; the module that drives attaches a
RoutePlanner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.base.service_slot import ServiceSlot
from app.maps.map_service import MapUnavailable

#: Where a leg leads: to its end, to the nearest place that can be reached, or nowhere.
LegState = Literal["way", "near", "none"]


@dataclass(frozen=True, slots=True, eq=False)
class RouteLeg:
    """A way between two poses, as it would be driven.

    ``reason``: for people, why it does not lead to the end, or what is special about it; "" for nothing. ``path``
    (N, 2) float64: m on the map, without points where there is no way. ``duration_s``: an estimate of the time it takes
    while nothing is in the way.
    """

    state: LegState
    reason: str
    path: NDArray[np.float64]
    length_m: float
    duration_s: float


class RoutePlanner(Protocol):
    """Plans as the robot that drives does; all methods are called on the event loop."""

    async def leg(self, start: Pose2, goal: Pose2, speed: float) -> RouteLeg:
        """The way from ``start`` to ``goal`` (heading NaN: any), both on the map in use, as it and its zones are now.

        ``speed``: share (in ]0, 1]) of the robot's greatest.

        Raises MapUnavailable, with a message for people, while there is no map.
        """
        ...


class RouteService(ServiceSlot[RoutePlanner]):
    """The service of ways: its planner, which a module attaches while it runs."""

    def __init__(self) -> None:
        super().__init__(lambda: MapUnavailable("this program plans no ways: no PlanAndFollowPath runs"))

    @property
    def planner(self) -> RoutePlanner:
        """The planner. Raises MapUnavailable while there is none."""
        return self.provider
