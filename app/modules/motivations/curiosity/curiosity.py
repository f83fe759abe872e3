"""Curiosity: the motivation that explores: it desires to go where the map ends, until all that it can reach is mapped.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ Curiosity  in  localization  Localization: where the robot is on the map; its filter is  │
    │                              attention's                                                 │
    │            in  map           OccupancyGrid, when it changes                              │
    │            in  zones         Zones: keep-out zones are not explored; may be absent       │
    │            in  base          Exploitation of the base: without it, no frontier before    │
    │                              which the robot stands is refused; may be absent            │
    │            serves desires of class Explore by desires of class GoTo                      │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Of the frontiers of the map (``frontiers.py``) it desires the one that costs least, as intensely as exploring itself is
desired: a goal of people that is desired more has its way. Most frontiers are seen before they are reached; the next is
desired at once. One that could not be reached comes last, and is tried once more. A desire Explore is done when none is
left for a while: a map that still grows has others soon. Where people withdraw the goal, exploring ends with it; what
stops all driving withdraws the desire itself (``app/console/drive/goals.py``). A robot that can turn its head looks
where it goes meanwhile (LookWhereGoing).

With ``grows_s`` it is a drive (``drive.py``), too: the longer no behavior has moved the robot, the more it desires to
explore.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import Desire, DesireClass
from app.attention.workspace import UnknownDesire
from app.base.geometry import Pose2, wrap_angle
from app.maps.place_checks import inscribed_radius_m
from app.messages import Accomplishment, Exploitation, Localization, OccupancyGrid, Zone, Zones
from app.modules.motivations.curiosity.frontiers import (
    Frontier,
    Refused,
    choose,
    frontiers,
    known_floor_m2,
    refuse,
)
from app.modules.motivations.drive import Drive, DriveSettings
from app.modules.stream_module import robot_link
from app.runtime.module import ModuleContext

GO_TO: Final = "GoTo"
#: Desired beside it by a robot that can: objects on unknown ground may be lower than the laser.
LOOK: Final = "LookWhereGoing"
_BEAT_S = 1.0
#: Near enough to a frontier (m, rad): what is to be seen from there is seen.
_TOLERANCE: Final = {"tolerance_m": 0.3, "tolerance_rad": 0.4}
#: Only in these states of localization does a pose mean anything.
_LOCALIZED: Final = frozenset({"mapping", "tracking"})


class ExploreParameters(BaseModel):
    """Parameters of a desire of class Explore."""

    model_config = ConfigDict(extra="forbid", title="Explore", allow_inf_nan=False)

    speed: float = Field(0.8, gt=0, le=1, title="Speed", description="Share of the robot's greatest speeds, 0 to 1.")
    within_m: float | None = Field(
        None,
        gt=0,
        le=1000,
        title="Within",
        description="No further than so many metres from its beginning; none: any.",
    )


EXPLORE = DesireClass(
    name="Explore",
    title="Explore",
    description="Drive to where the map ends, until all that can be reached is mapped; the desire ends then.",
    parameters=ExploreParameters,
    achievement=True,
)


class CuriositySettings(DriveSettings):
    """Settings of Curiosity; those of its drive (``grows_s``) are off as shipped."""

    least_m: float = Field(0.4, gt=0, le=5, description="a shorter border between free floor and unknown is left alone")
    settled_s: float = Field(5.0, ge=0, description="time without a frontier after which all is explored")
    tries: int = Field(2, ge=1, le=10, description="how often a frontier that cannot be reached is tried")
    patience_s: float = Field(
        30.0, gt=0, description="a frontier before which the robot has not moved for so long cannot be reached"
    )
    goes_by: tuple[str, ...] = Field(
        ("PlanAndFollowPath", "GoToward"), description="the behaviors that go to places, as `base` names them"
    )
    spare_m: float = Field(0.05, ge=0, le=0.5, description="room around the body where it is sent")


class Curiosity(Drive):
    """Explores what the map does not have."""

    title = "Curiosity"
    desire_classes = (EXPLORE,)
    drive_class = EXPLORE.name
    Settings = CuriositySettings
    settings: CuriositySettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.map = self.input("map", OccupancyGrid, rests=True)
        self.localization = self.input("localization", Localization)
        self.zones = self.input("zones", Zones, wants="never", rests=True)
        self.base = self.input("base", Exploitation, wants="never")
        self.on(self.map, self._take_map)
        self.on(self.localization, self._take_localization)
        self.on(self.zones, self._take_zones)
        self.on(self.base, self._take_base)
        self.every(_BEAT_S, self._explore)
        self._radius_m = 0.0
        self._grid: OccupancyGrid | None = None
        self._zones: tuple[Zone, ...] = ()
        self._X_MB: Pose2 | None = None
        self._run: _Exploration | None = None
        #: Which has the base; "" while that is not known.
        self._behavior: str | None = ""

    async def start(self) -> None:
        await super().start()
        self._radius_m = inscribed_radius_m(robot_link(self).description.footprint) + self.settings.spare_m

    async def stop(self) -> None:
        """Withdraw its desires."""
        self._end()
        await super().stop()

    def grows(self) -> bool:
        """While no behavior moves the base: what it knows grows old then."""
        return self._behavior is None

    async def _take_map(self, grid: OccupancyGrid) -> None:
        self._grid = grid

    async def _take_localization(self, localization: Localization) -> None:
        self._X_MB = localization.X_MB if localization.state in _LOCALIZED else None

    async def _take_zones(self, zones: Zones) -> None:
        self._zones = zones.zones

    async def _take_base(self, exploitation: Exploitation) -> None:
        self._behavior = exploitation.behavior

    async def _explore(self) -> None:
        desire = self._wanted()
        if desire is None:
            self._end()
            return
        grid, X_MB = self._grid, self._X_MB
        if grid is None or X_MB is None:
            return  # the goal in force stays: the pose may come back
        run = self._run
        if run is None or run.desire_id != desire.id:
            self._end()
            run = self._run = _Exploration(desire.id, X_MB, self.clock.now())
        found = await self.compute(frontiers, grid, self._zones, X_MB, self._radius_m, self.settings.least_m)
        # Meanwhile people may have stopped the robot.
        desire = self._wanted()
        if desire is None or desire.id != run.desire_id or not self._look_at_goal(run):
            self._end()
            return
        self._lose_patience(run, X_MB)
        given = ExploreParameters.model_validate(desire.params)
        within = [each for each in found if given.within_m is None or _apart(each.stand, run.began) <= given.within_m]
        self._go_on(run, desire, given, choose(within, X_MB, run.frontier, run.refused, self.settings.tries))

    def _wanted(self) -> Desire | None:
        """The desire to explore that attention has room for."""
        return self._workspace.wanted(EXPLORE.name) if self.localization.subscription.filter.is_open else None

    def _go_on(self, run: _Exploration, desire: Desire, given: ExploreParameters, frontier: Frontier | None) -> None:
        now = self.clock.now()
        if frontier is None:
            self._withdraw(run)
            if now - run.frontier_seen >= self.settings.settled_s:
                self._done(run)
            return
        run.frontier_seen = now
        another = run.frontier is None or not _same_stand(frontier.stand, run.frontier.stand)
        params = _way_to(frontier.stand, given.speed)
        if run.goal is None:
            run.goal = self._add(GO_TO, desire.intensity, params)
            if run.look is None and LOOK in self._workspace.classes:
                run.look = self._add(LOOK, desire.intensity)
        elif another or run.intensity != desire.intensity:
            self._workspace.change(run.goal, intensity=desire.intensity, params=params)
        else:
            return
        run.frontier, run.intensity = frontier, desire.intensity

    def _add(self, cls: str, intensity: float, params: Mapping[str, Any] | None = None) -> str:
        return self._workspace.add(cls, intensity=intensity, utility=1.0, params=params, source=self.source).id

    def _look_at_goal(self, run: _Exploration) -> bool:
        """Take what has become of the desire for a frontier; whether exploring goes on.

        Where people withdrew it they want the robot to stay: the desire to explore is withdrawn with it.
        """
        if run.goal is None or run.frontier is None:
            return True
        try:
            report = self._workspace.report(run.goal)
        except UnknownDesire:
            report = None
        if report is not None and report.ended is None:
            return True
        if report is None or report.outcome not in ("done", "failed"):
            self._workspace.remove(run.desire_id)
            return False
        # Seen from there, a frontier is none any more: one that stays cannot be seen, and is as one not reached.
        run.refused = refuse(run.refused, run.frontier)
        run.goal = run.frontier = None
        return True

    def _lose_patience(self, run: _Exploration, X_MB: Pose2) -> None:
        """Refuse the frontier before which the robot does not move on, sooner than people would be asked for help.

        It is no fault of the frontier while another behavior has the base, as at the dock, or another goal is desired
        more.
        """
        now, goal = self.clock.now(), self._workspace.strongest().get(GO_TO)
        ours = goal is not None and goal.id == run.goal and self._behavior in self.settings.goes_by
        if run.frontier is None or not ours or not _same_stand(X_MB, run.at):
            run.at, run.moved = X_MB, now
        elif now - run.moved > self.settings.patience_s:
            run.refused, run.moved = refuse(run.refused, run.frontier), now
            self._withdraw(run)

    def _done(self, run: _Exploration) -> None:
        now, grid = self.clock.now(), self._grid
        area_m2 = 0.0 if grid is None else known_floor_m2(grid)
        left = sum(each.times >= self.settings.tries for each in run.refused)
        reason = f"all that it can reach is mapped: {area_m2:.0f} m² of floor in {now - run.since:.0f} s"
        if left:
            reason += f"; {left} {'place' if left == 1 else 'places'} could not be looked at"
        self._end()
        self._workspace.accomplish(Accomplishment(now, run.desire_id, self.name, "done", reason))

    def _end(self) -> None:
        run, self._run = self._run, None
        if run is not None:
            self._withdraw(run)
            self.retract(run.look)

    def _withdraw(self, run: _Exploration) -> None:
        goal, run.goal, run.frontier = run.goal, None, None
        self.retract(goal)


class _Exploration:
    """The exploration for one desire, from ``began`` and the time ``since`` on."""

    def __init__(self, desire_id: str, began: Pose2, since: float) -> None:
        self.desire_id = desire_id
        self.began = began
        self.since = since
        #: Where the robot last was after a move, and when.
        self.at, self.moved = began, since
        #: When there last was a frontier to go to.
        self.frontier_seen = since
        #: What is gone to, and the id of the desire for it.
        self.frontier: Frontier | None = None
        self.goal: str | None = None
        #: How intensely it is desired.
        self.intensity = 0.0
        #: The id of the desire to look ahead.
        self.look: str | None = None
        self.refused: tuple[Refused, ...] = ()


def _way_to(stand: Pose2, speed: float) -> dict[str, Any]:
    """Parameters of a desire to go there."""
    at = {"x": round(stand.x, 3), "y": round(stand.y, 3), "heading": round(stand.theta, 3)}
    return {**at, "speed": speed, "name": "unknown ground", **_TOLERANCE}


def _apart(a: Pose2, b: Pose2) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def _same_stand(a: Pose2, b: Pose2) -> bool:
    turned = abs(wrap_angle(a.theta - b.theta))
    return _apart(a, b) <= _TOLERANCE["tolerance_m"] and turned <= _TOLERANCE["tolerance_rad"]
