"""Where the robot is on the map and where it goes, as REST and the live stream tell it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Desire
from app.base.geometry import Pose2
from app.console import reports
from app.console.drive.goals import GO_TO
from app.console.playback import rate
from app.messages import Localization, NavigationStatus, OccupancyGrid, PlannedPath, Zone, Zones

if TYPE_CHECKING:
    from app.attention.timeline import TimelineEvent
    from app.program.system import System

#: Where those who go somewhere say what they are about. The path is the first one's.
STATUSES = ("navigation", "going_toward")
PATH = "path"
LOCALIZATION = "localization"
ZONES = "zones"
MAP = "map"
COSTMAP = "local_costmap"
#: A path has at most so many points when it is told.
MOST_POINTS = 200
_HEADING_STEP = 0.01
#: A local costmap older than this (s) does not show what stands around now: nobody makes another any more.
COSTMAP_FRESH_S = 2.0
#: An arrival is told for so long (s), unless another goal is given.
ARRIVED_S = 5.0
#: In these states a behavior is on its way; in all but the last it gets on.
UNDER_WAY = ("planning", "following", "recovering", "waiting")


def localization_json(message: Localization) -> dict[str, Any]:
    """Where the robot is on the map."""
    variances = np.clip(np.diagonal(message.covariance), 0.0, None)
    return {
        "stamp": message.stamp,
        "state": message.state,
        "map": message.map,
        **_pose_json(message.X_MB),
        "sigma": [_rounded(float(sigma)) for sigma in np.sqrt(variances)],
        "X_MO": _pose_json(message.X_MO),
        "overlap": _rounded(message.overlap),
    }


def zones_json(zones: Iterable[Zone]) -> list[dict[str, Any]]:
    """Every zone."""
    return [
        {
            "name": zone.name,
            "kind": zone.kind,
            "polygon": [[round(float(x), 4), round(float(y), 4)] for x, y in zone.polygon],
            "speed": zone.speed,
        }
        for zone in zones
    ]


def navigation_json(
    status: NavigationStatus | None,
    path: list[list[float]],
    desire: Desire | None,
    given_up: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """What the behavior that goes somewhere is about (None: none has said anything yet), and the goal given up last."""
    if status is None:
        status = NavigationStatus(0.0, "", "idle", "")
    return {
        "stamp": status.stamp,
        "behavior": status.behavior,
        "state": status.state,
        "reason": status.reason,
        "goal": None if status.goal is None else _pose_json(status.goal),
        "target": None if status.target is None else _pose_json(status.target),
        "remaining_m": None if status.remaining_m is None else _rounded(status.remaining_m, 2),
        "recoveries": status.recoveries,
        "desire": None if desire is None else desire.id,
        "path": path,
        "given_up": given_up,
    }


def at_work(statuses: Sequence[NavigationStatus]) -> NavigationStatus | None:
    """Of several behaviors, the one that is under way; of those the first that does not wait, or the first; where none
    is, the one that spoke last."""
    for states in (UNDER_WAY[:-1], UNDER_WAY):
        for status in statuses:
            if status.state in states:
                return status
    return max(statuses, key=lambda status: status.stamp, default=None)


def thinned_path(points: NDArray[np.float64], most: int = MOST_POINTS) -> NDArray[np.float64]:
    """At most ``most`` (at least 2) of ``points`` (N, 2), both ends among them: those where it turns, then evenly."""
    if len(points) > 2:
        steps = np.diff(points, axis=0)
        headings = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
        # Between two that are kept, the heading stays within one step: a wide bend is no straight line.
        turns = np.diff(np.floor(headings / _HEADING_STEP)) != 0
        points = points[np.concatenate([[True], turns, [True]])]
    if len(points) > most:
        points = points[np.linspace(0, len(points) - 1, most).round().astype(np.intp)]
    return points


class WayReport:
    """What was said last of place and way. Tells only what this program has channels for.

    :meth:`open` when the program runs; what it returns ends it.
    """

    def __init__(self, system: System) -> None:
        self._system = system
        #: The channels it tells of; what nobody wants may rest.
        self.channels = tuple(name for name in (LOCALIZATION, ZONES, PATH, *STATUSES) if name in system.graph.channels)
        self._told: tuple[Any, ...] = ()
        self._points: list[list[float]] = []
        self._zones: tuple[Zones | None, list[dict[str, Any]]] = (None, [])
        #: The last arrival: the desire ends with it, and with that, within milliseconds, what the behavior is about.
        self._arrival: NavigationStatus | None = None
        #: What the robot has given up, and why: told until somebody wants it to go somewhere again, or has read it.
        self._given_up: dict[str, Any] | None = None

    def open(self) -> Callable[[], None]:
        """Begin to look out for arrivals, and for goals that are given up."""
        stack = ExitStack()
        stack.callback(self._system.timeline.observe(self._hear))
        stack.callback(self._system.workspace.observe(lambda _: self._heed_desires()))
        for name in STATUSES:
            if name in self.channels:
                stack.callback(self._system.graph.channel(name).observe(self._note))
        return stack.close

    def forget(self) -> None:
        """Time has jumped."""
        self._arrival = None
        self.dismiss()

    def dismiss(self) -> None:
        """The goal that was given up is not told any more: it was read, or was a place on another map."""
        self._given_up = None

    def _note(self, status: NavigationStatus) -> None:
        if status.state == "arrived":
            self._arrival = status

    def _hear(self, event: TimelineEvent) -> None:
        goal = event.data.get("goal") if event.kind == "goal" and event.data.get("arrived") is False else None
        if goal is not None and self.desire() is None:
            place = {"x": goal["x"], "y": goal["y"], "theta": goal["heading"]}
            self._given_up = {"stamp": event.stamp, "goal": place, "reason": event.data.get("why", "")}

    def _heed_desires(self) -> None:
        if self._given_up is not None and self.desire() is not None:
            self.dismiss()

    @property
    def goes(self) -> bool:
        """Whether there is anybody who could go somewhere."""
        return any(name in self.channels for name in STATUSES)

    def localization(self) -> dict[str, Any] | None:
        """As in docs/live-stream.md; None before the first."""
        message: Localization | None = reports.latest(self._system.graph, LOCALIZATION)
        return None if message is None else localization_json(message)

    def zones(self) -> dict[str, Any] | None:
        """As in docs/live-stream.md; None in a program without."""
        if ZONES not in self.channels:
            return None
        message: Zones | None = reports.latest(self._system.graph, ZONES)
        if message is not self._zones[0]:
            # They stay for hours, and are asked for ten times in each second.
            self._zones = (message, [] if message is None else zones_json(message.zones))
        return {"zones": self._zones[1]}

    def navigation(self) -> dict[str, Any] | None:
        """As in docs/live-stream.md; None in a program where nobody goes anywhere."""
        if not self.goes:
            return None
        return navigation_json(self._status(), self._path_points(), self.desire(), self._given_up)

    def desire(self) -> Desire | None:
        """The strongest desire to go somewhere."""
        desire = self._system.workspace.strongest().get(GO_TO)
        return desire if desire is not None and desire.utility > 0 else None

    def path(self) -> PlannedPath | None:
        """The path that is being followed."""
        status, planner = self._status(), reports.latest(self._system.graph, STATUSES[0])
        follows = status is not None and status is planner and status.state in UNDER_WAY
        path: PlannedPath | None = reports.latest(self._system.graph, PATH) if follows else None
        return path

    def costmap(self) -> OccupancyGrid | None:
        """What stands around the robot; None where nobody has looked for a while."""
        grid: OccupancyGrid | None = reports.latest(self._system.graph, COSTMAP)
        clock = self._system.clock
        return grid if grid is not None and clock.now() - grid.stamp <= COSTMAP_FRESH_S * rate(clock) else None

    def goal(self) -> tuple[float, float, float | None] | None:
        """Where a behavior is going, or cannot go: x, y (m) and heading (rad, None: any) on the map."""
        status = self._status()
        if status is None or status.goal is None or status.state not in (*UNDER_WAY, "unreachable"):
            return None
        return status.goal.x, status.goal.y, status.goal.theta if math.isfinite(status.goal.theta) else None

    def _status(self) -> NavigationStatus | None:
        graph = self._system.graph
        status = at_work([latest for name in STATUSES if (latest := reports.latest(graph, name)) is not None])
        arrival = self._arrival
        if status is not None and status.state == "idle" and arrival is not None:
            return arrival if self._system.clock.now() - arrival.stamp < ARRIVED_S else status
        return status

    def _path_points(self) -> list[list[float]]:
        path = self.path()
        localization: Localization | None = reports.latest(self._system.graph, LOCALIZATION)
        X_MP: Pose2 | None = Pose2()
        if path is not None and path.frame == "odom":
            X_MP = None if localization is None else localization.X_MO
        if (path, X_MP) != self._told:
            # A path stays for seconds, and is asked for ten times in each.
            self._told = (path, X_MP)
            self._points = [] if path is None or X_MP is None else _points_json(path, X_MP)
        return self._points


def _points_json(path: PlannedPath, X_MP: Pose2) -> list[list[float]]:
    if len(path.poses) == 0:
        return []
    points = thinned_path(path.poses[:, :2])
    c, s = math.cos(X_MP.theta), math.sin(X_MP.theta)
    on_map = points @ np.array([[c, s], [-s, c]]) + (X_MP.x, X_MP.y)
    return [[round(float(x), 3), round(float(y), 3)] for x, y in on_map]


def _pose_json(pose: Pose2) -> dict[str, float | None]:
    return {"x": _rounded(pose.x), "y": _rounded(pose.y), "theta": _rounded(pose.theta, 5)}


def _rounded(value: float, digits: int = 4) -> float | None:
    """Null for what is not known."""
    return round(value, digits) if math.isfinite(value) else None
