"""NavigationReporter: where the robot is going and how it gets on, of all behaviors that go somewhere.

    ┌───────────────────────────────────────────────────────────────────────────────────────────┐
    │ NavigationReporter  in   navigation    NavigationStatus of what plans paths               │
    │                     in   going_toward  NavigationStatus of what goes straight             │
    │                     in   path          PlannedPath of the first                           │
    │                     in   localization  Localization: where a path in odom is on the map   │
    │                     out  report        NavigationReport, at every change                  │
    └───────────────────────────────────────────────────────────────────────────────────────────┘

The goal that was given up last is reported until another is desired, or an event of the timeline of kind
`goal` says that it is void: it was read, or was a place on another map.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.attention.desires import Desire
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.base.polyline import thinned_path
from app.messages import (
    GivenUpGoal,
    Localization,
    NavigationReport,
    NavigationStatus,
    PlannedPath,
    TimelineEvent,
    read_only,
)
from app.runtime.module import Module, ModuleContext

#: Period (s) of removing what is over.
PERIOD_S = 0.1
GO_TO = "GoTo"
#: An arrival is reported for so long (s), unless another goal is given.
ARRIVED_S = 5.0
#: In these states a behavior is on its way; in all but the last it gets on.
UNDER_WAY = ("planning", "following", "recovering", "waiting")


def at_work(statuses: Sequence[NavigationStatus]) -> NavigationStatus | None:
    """Of several behaviors, the one that is under way; of those the first that does not wait, or the first; where none
    is, the one with the newest status."""
    for states in (UNDER_WAY[:-1], UNDER_WAY):
        for status in statuses:
            if status.state in states:
                return status
    return max(statuses, key=lambda status: status.stamp, default=None)


class NavigationReporter(Module):
    title = "Navigation report"

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._statuses: dict[str, NavigationStatus] = {}
        self._path: PlannedPath | None = None
        self._X_MO: Pose2 | None = None
        #: The last arrival: the desire ends with it, and with that, within milliseconds, what the behavior is about.
        self._arrival: NavigationStatus | None = None
        self._given_up: GivenUpGoal | None = None
        self._published: tuple[object, ...] | None = None
        #: The path shown last with its pose on the map, and its points there.
        self._shown: tuple[PlannedPath | None, Pose2 | None] = (None, None)
        self._on_map: NDArray[np.float64] = read_only(np.zeros((0, 2)))
        self._stack = ExitStack()
        self.report = self.output("report", NavigationReport)
        for name in ("navigation", "going_toward"):
            self.on(self.input(name, NavigationStatus, capacity=16, wants="if_wanted"), self._status_taker(name))
        self.on(self.input("path", PlannedPath, wants="if_wanted"), self._take_path)
        self.on(self.input("localization", Localization, wants="if_wanted"), self._take_localization)
        self.every(PERIOD_S, self._publish)

    async def start(self) -> None:
        """Follow desires, and goals that are given up."""
        self._workspace = self.service(IntentionWorkspace)
        self._stack.callback(self._workspace.observe(lambda _: self._on_desires()))
        self._stack.callback(self.service(Timeline).observe(self._on_event))

    async def stop(self) -> None:
        """Follow them no more."""
        self._stack.close()

    # --- What comes in -----------------------------------------------------------------------------------------------

    def _status_taker(self, name: str) -> Callable[[NavigationStatus], Any]:
        async def take(status: NavigationStatus) -> None:
            self._statuses[name] = status
            if status.state == "arrived":
                self._arrival = status
            self._publish()

        return take

    async def _take_path(self, path: PlannedPath) -> None:
        self._path = path
        self._publish()

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MO = localization.X_MO
        if self._path is not None and self._path.frame == "odom":
            self._publish()

    def _on_desires(self) -> None:
        if self._desire() is not None:
            self._given_up = None
        self._publish()

    def _on_event(self, event: TimelineEvent) -> None:
        if event.kind != "goal":
            return
        goal = event.data.get("goal")
        if event.data == _DISMISSED:
            self._given_up = None
        elif goal is not None and event.data.get("arrived") is False and self._desire() is None:
            self._given_up = _given_up(event, goal)
        self._publish()

    # --- What goes out -----------------------------------------------------------------------------------------------

    def _publish(self) -> None:
        now = self.clock.now()
        status, desire = self._status(now), self._desire()
        path = self._shown_path(status)
        X_MP = None if path is None else Pose2() if path.frame == "map" else self._X_MO
        # Two of them differ only where these do: a path stays for seconds.
        content = (status, path, X_MP, None if desire is None else desire.id, self._given_up)
        if content == self._published:
            return
        self._published = content
        self.report.publish(
            NavigationReport(
                stamp=now if status is None else status.stamp,
                behavior="" if status is None else status.behavior,
                state="idle" if status is None else status.state,
                reason="" if status is None else status.reason,
                goal=None if status is None else _rounded(status.goal),
                target=None if status is None else _rounded(status.target),
                remaining_m=_metres(status),
                recoveries=0 if status is None else status.recoveries,
                desire=None if desire is None else desire.id,
                path=self._points(path, X_MP),
                given_up=self._given_up,
            )
        )

    def _desire(self) -> Desire | None:
        """The strongest desire to go somewhere."""
        return self._workspace.wanted(GO_TO)

    def _status(self, now: float) -> NavigationStatus | None:
        known = (self._statuses.get(name) for name in ("navigation", "going_toward"))
        status = at_work([each for each in known if each is not None])
        if status is not None and status.state == "idle" and self._arrival is not None:
            return self._arrival if now - self._arrival.stamp < ARRIVED_S else status
        return status

    def _shown_path(self, status: NavigationStatus | None) -> PlannedPath | None:
        """The path, while what follows it is at work and under way."""
        follows = status is not None and status is self._statuses.get("navigation") and status.state in UNDER_WAY
        return self._path if follows else None

    def _points(self, path: PlannedPath | None, X_MP: Pose2 | None) -> NDArray[np.float64]:
        if (path, X_MP) != self._shown:
            # It stays for seconds, while statuses come many times a second.
            self._shown = (path, X_MP)
            points = np.zeros((0, 2))
            if path is not None and X_MP is not None and len(path.poses):
                points = np.round(X_MP.transform(thinned_path(path.poses[:, :2])), 3)
            self._on_map = read_only(points)
        return self._on_map


#: Of an event of kind ``goal``: the goal that was given up is void.
_DISMISSED: Mapping[str, Any] = {"given_up": None}


def _given_up(event: TimelineEvent, goal: Mapping[str, Any]) -> GivenUpGoal:
    heading = goal["heading"]
    place = Pose2(goal["x"], goal["y"], math.nan if heading is None else heading)
    return GivenUpGoal(event.stamp, place, event.data.get("why", ""))


def _rounded(pose: Pose2 | None) -> Pose2 | None:
    return None if pose is None else Pose2(round(pose.x, 4), round(pose.y, 4), round(pose.theta, 5))


def _metres(status: NavigationStatus | None) -> float | None:
    remaining_m = None if status is None else status.remaining_m
    return round(remaining_m, 2) if remaining_m is not None and math.isfinite(remaining_m) else None
