"""Docking: drives into a marked dock until the battery charges, and out of it when the robot is wanted elsewhere.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Docking    in   scans         LaserScan, 40 Hz / φ                                       │
    │            in   odometry      Odometry, 100 Hz, X_OB in odom; never filtered             │
    │            in   localization  Localization, X_MO on the map                              │
    │            in   battery       BatteryState: whether it charges; never filtered           │
    │            out  twist         Twist, each period while it drives or holds the base       │
    │            out  dock          DockSighting (odom), in the last part of the approach      │
    │            out  status        DockingStatus, when it changes                             │
    │            out  accomplishments  Accomplishment of desires of class Dock                 │
    │            states GoTo for the way to the dock, and Undock                               │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

The way to the place in front of the dock is GoTo's: for it the module states a desire of the intensity of its own. From
there the laser finds the dock (``dock_detector.py``), and the base follows its axis (``approach.py``) until the charger
comes on; else it backs off and tries again (``docking_sequence.py``). In the last part the collision monitor does not
mind the dock's outline, which ``dock`` gives it.

Where a desire for another place is more intense than the one for the dock, the robot leaves it: straight back, before
anything turns it. That takes the output open, and so a desire of class Undock.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import SCALE, Desire, Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.base.geometry import Pose2, wrap_angle
from app.messages import (
    Accomplishment,
    BatteryState,
    DockingStatus,
    DockSighting,
    LaserScan,
    Localization,
    Odometry,
    Twist,
)
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.docking.approach import ApproachRules
from app.modules.behaviors.docking.desire_classes import DOCK, UNDOCK, DockParameters
from app.modules.behaviors.docking.dock_detector import DetectorRules, DockShape, find_dock, scan_points
from app.modules.behaviors.docking.dock_filter import DockFilter
from app.modules.behaviors.docking.docking_sequence import SEEN_S, DockingInput, DockingSequence, SequenceRules
from app.modules.behaviors.navigation.tracking.localization_monitor import LocalizationMonitor
from app.runtime.module import Module, ModuleContext, Settings

GO_TO = "GoTo"
#: Within this much (m, rad) of the place in front of the dock, no way there is needed.
_THERE = (0.3, 0.5)
#: Tolerances (m, rad) of the way there.
_TOLERANCE = (0.12, 0.15)
#: The dock's outline is given to the collision monitor within this distance (m) of where the robot is docked.
_EXEMPT_M = 0.3


class DockPlace(BaseModel):
    """The dock's pose on the map: where its plates meet (m), and where it opens to (rad)."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    x: float
    y: float
    heading: float


class DockingSettings(Settings):
    """Settings of Docking."""

    dock: DockPlace | None = Field(None, description="the robot's dock on the map; none: desires must give it")
    docked_m: float = Field(0.39, gt=0, le=2, description="from base_link to where the plates meet, when docked")
    plate_m: float = Field(0.25, ge=0.1, le=0.4, description="length of each of the dock's plates")
    opening_deg: float = Field(120, ge=60, le=160, description="angle between the dock's plates")
    staging_m: float = Field(1.2, ge=0.8, le=3, description="from where the plates meet to where the approach begins")
    attempts: int = Field(3, ge=1, le=10, description="to dock, before it is given up")
    period_s: float = Field(0.1, gt=0, le=0.2, description="one control cycle")
    elsewhere: str = Field(GO_TO, description="the desire class that drives the robot to other places")


class Docking(Module):
    """Docks and undocks."""

    title = "Docking"
    desire_classes = (DOCK, UNDOCK)
    Settings = DockingSettings
    settings: DockingSettings
    auxiliary_inputs = frozenset({"localization"})

    _workspace: IntentionWorkspace

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.scans = self.input("scans", LaserScan)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.localization = self.input("localization", Localization)
        self.battery = self.input("battery", BatteryState, always_open=True)
        self.twist = self.output("twist", Twist)
        self.dock = self.output("dock", DockSighting)
        self.status = self.output("status", DockingStatus)
        self._accomplishments = AccomplishmentReporter(self, DOCK.name)
        self._poses = LocalizationMonitor()
        self.on(self.scans, self._take_scan)
        self.on(self.odometry, self._poses.add_odometry)
        self.on(self.localization, self._poses.add_localization)
        self.on(self.battery, self._take_battery)
        self.every(self.settings.period_s, self._cycle)
        s = self.settings
        self._shape = DockShape(s.plate_m, math.radians(s.opening_deg))
        rules = SequenceRules(ApproachRules(docked_m=s.docked_m), staging_m=s.staging_m, attempts=s.attempts)
        self._sequence = DockingSequence(rules)
        self._filter = DockFilter()
        self._scan: LaserScan | None = None
        self._charging = False
        self._given: Mapping[str, Any] = {}
        self._goal: str | None = None
        self._undock: str | None = None
        self._served: tuple[str, Mapping[str, Any]] | None = None
        self._published: DockingStatus | None = None

    async def start(self) -> None:
        self._workspace = self.service(IntentionWorkspace)

    async def stop(self) -> None:
        """Withdraw the desires that it stated."""
        self._withdraw_goal()
        if self._undock is not None:
            self._remove(self._undock)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the dock's pose from the desire."""
        self._given = {key: parameters[key] for key in DockParameters.model_fields if key in parameters}

    def last_word(self, port: str) -> Twist | None:
        return Twist(self.clock.now(), 0.0, 0.0) if port == "twist" else None

    async def _take_scan(self, scan: LaserScan) -> None:
        self._scan = scan

    async def _take_battery(self, state: BatteryState) -> None:
        self._charging = state.charging

    # --- a cycle ---

    async def _cycle(self) -> None:
        now, motion = self.clock.now(), self._poses.motion(self.clock.now())
        if motion is None:
            return
        desire = self._workspace.wanted(DOCK.name)
        self._renew(desire)
        before = self._sequence.state
        if before in ("searching", "approaching", "backing"):
            await self._look(search=not self._filter.is_sure)
        velocity = self._sequence.step(self._known(now, motion.pose, desire))
        if self._sequence.state == "searching" and before != "searching":
            self._filter.reset()
        self._follow(desire)
        if velocity is not None:
            self.twist.publish(Twist(now, *velocity))
        self._exempt(now, motion.pose)
        self._report(now, desire)

    def _renew(self, desire: Desire | None) -> None:
        """What failed may succeed for another desire, or for another dock."""
        served = None if desire is None else (desire.id, desire.params)
        if served != self._served:
            self._served = served
            self._sequence.again()

    def _known(self, now: float, X_OB: Pose2, desire: Desire | None) -> DockingInput:
        elsewhere = self._elsewhere()
        called_away = elsewhere is not None and (desire is None or elsewhere.intensity > desire.intensity)
        wanted = desire is not None and self.twist.filter.is_open and not called_away
        unreachable = ""
        at_staging = False
        X_MD = self._place()
        if wanted and X_MD is None:
            unreachable = "where the dock is on the map is not known: give it with the desire, or in the settings"
        elif self._goal is not None:
            report = self._workspace.report(self._goal)
            at_staging = report.outcome == "done"
            if report.outcome not in (None, "done"):
                unreachable = report.reason or str(report.outcome)
        if X_MD is not None and not at_staging and not self._poses.problem(now):
            at_staging = self._stands_in_front(now, X_MD)
        return DockingInput(
            now,
            X_OB,
            wanted=wanted,
            leave=called_away or self._workspace.wanted(UNDOCK.name) is not None,
            charging=self._charging,
            at_staging=at_staging,
            X_OD=self._filter.estimate if self._filter.is_sure else None,
            seen_s=now - self._filter.stamp,
            unreachable=unreachable,
        )

    def _elsewhere(self) -> Desire | None:
        """The strongest desire for another place that is not of this module."""
        others = [
            desire
            for desire in self._workspace.desires()
            if desire.cls == self.settings.elsewhere and desire.id != self._goal and desire.utility > 0
        ]
        return max(others, key=lambda desire: desire.intensity, default=None)

    def _place(self) -> Pose2 | None:
        """``X_MD``, as the desire or else the settings say."""
        given = DockParameters.model_validate(dict(self._given))
        if given.x is not None and given.y is not None and given.heading is not None:
            return Pose2(given.x, given.y, given.heading)
        own = self.settings.dock
        return None if own is None else Pose2(own.x, own.y, own.heading)

    def _staging(self, X_MD: Pose2) -> Pose2:
        return X_MD @ Pose2(self.settings.staging_m, 0.0, math.pi)

    def _stands_in_front(self, now: float, X_MD: Pose2) -> bool:
        X_MB = self._poses.X_MB(now)
        if X_MB is None:
            return False
        X_SB = self._staging(X_MD).inverse() @ X_MB
        return math.hypot(X_SB.x, X_SB.y) <= _THERE[0] and abs(wrap_angle(X_SB.theta)) <= _THERE[1]

    # --- the dock, seen ---

    async def _look(self, *, search: bool) -> None:
        """Find the dock in the newest scan."""
        scan, self._scan = self._scan, None
        if scan is None:
            return
        stamp = scan.stamp + scan.duration_s / 2
        X_OB, expected = self._poses.at(stamp), self._expected()
        if X_OB is None or expected is None:
            return
        found = await self.compute(_find, scan, X_OB.inverse() @ expected, self._shape, search)
        if found is not None:
            self._filter.add(stamp, X_OB @ found)

    def _expected(self) -> Pose2 | None:
        """``X_OD`` where the dock is looked for: where it was seen, else where it is on the map."""
        if self._filter.estimate is not None:
            return self._filter.estimate
        X_MD, X_MO = self._place(), self._poses.X_MO
        return None if X_MD is None or X_MO is None else X_MO.inverse() @ X_MD

    def _exempt(self, now: float, X_OB: Pose2) -> None:
        X_OD = self._filter.estimate
        if self._sequence.state not in ("approaching", "docked", "backing", "undocking") or X_OD is None:
            return
        remaining_m = (X_OD.inverse() @ X_OB).x - self.settings.docked_m
        # In the dock the estimate is kept; before it, what is not seen any more is not exempt either.
        seen = self._sequence.state != "approaching" or now - self._filter.stamp <= SEEN_S
        if seen and self._filter.is_sure and remaining_m <= _EXEMPT_M:
            self.dock.publish(DockSighting(now, X_OD, self._shape.plate_m, self._shape.opening_rad))

    # --- desires ---

    def _follow(self, desire: Desire | None) -> None:
        """State and withdraw the desires that the sequence needs."""
        X_MD = self._place()
        if self._sequence.needs_way and desire is not None and X_MD is not None:
            self._state_goal(desire, self._staging(X_MD))
        else:
            self._withdraw_goal()
        self._follow_undocking()

    def _follow_undocking(self) -> None:
        """State the desire that opens the output for undocking, and end those that are done."""
        asked = [each.id for each in self._workspace.desires() if each.cls == UNDOCK.name and each.utility > 0]
        if self._undock is not None and self._undock not in asked:
            self._undock = None
            self._sequence.abort()  # people stopped the robot
        if self._sequence.state == "undocking":
            if self._undock is None:
                source = Source("motivation", self.name)
                self._undock = self._workspace.add(UNDOCK.name, intensity=SCALE, utility=1.0, source=source).id
        elif self._sequence.state != "docked":
            self._undock = None
            for desire_id in asked:
                done = Accomplishment(self.clock.now(), desire_id, self.name, "done", "it stands in no dock")
                self._workspace.accomplish(done)

    def _state_goal(self, desire: Desire, place: Pose2) -> None:
        if self._goal is None:
            params = {
                "x": place.x,
                "y": place.y,
                "heading": place.theta,
                "tolerance_m": _TOLERANCE[0],
                "tolerance_rad": _TOLERANCE[1],
            }
            source = Source("motivation", self.name)
            added = self._workspace.add(GO_TO, intensity=desire.intensity, utility=1.0, params=params, source=source)
            self._goal = added.id
            return
        standing = {each.id: each for each in self._workspace.desires()}.get(self._goal)
        if standing is not None and standing.intensity < desire.intensity:
            self._workspace.change(standing.id, intensity=desire.intensity)

    def _withdraw_goal(self) -> None:
        goal, self._goal = self._goal, None
        if goal is not None:
            self._remove(goal)

    def _remove(self, desire_id: str) -> None:
        try:
            self._workspace.remove(desire_id)
        except UnknownDesire:
            self.log.debug("desire %s has ended already", desire_id)

    def _report(self, now: float, desire: Desire | None) -> None:
        sequence = self._sequence
        served = "" if desire is None else desire.id
        status = DockingStatus(now, sequence.state, sequence.reason, served, sequence.attempt)
        if self._published is None or _differs(status, self._published):
            self._published = status
            self.status.publish(status)
            self.log.info("%s%s", status.state, f": {status.reason}" if status.reason else "")
        if desire is None:
            return
        if sequence.state == "docked" and self._charging:
            self._accomplishments.report("done", "the battery charges", lambda each: each.id == served)
        elif sequence.state == "failed":
            self._accomplishments.report("failed", sequence.reason, lambda each: each.id == served)


def _find(scan: LaserScan, expected: Pose2, shape: DockShape, search: bool) -> Pose2 | None:
    return find_dock(scan_points(scan), expected, shape, DetectorRules(), search=search)


def _differs(one: DockingStatus, other: DockingStatus) -> bool:
    return (one.state, one.reason, one.desire, one.attempt) != (other.state, other.reason, other.desire, other.attempt)
