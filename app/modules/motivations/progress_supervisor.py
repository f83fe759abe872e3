"""ProgressSupervisor: the motivation that acts on goals without progress, and on behaviors that are outdone.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ ProgressSupervisor  in   navigation    NavigationStatus, as they come                    │
    │                     in   going_toward  NavigationStatus, as they come; may be absent     │
    │                     in   exploitation  Exploitation of the base, 10 Hz                   │
    │                     in   desires       Desires: what is exploited; may be absent         │
    │                     in   intention     IntentionReport; may be absent                    │
    │                     in   any other     Exploitation of another arbiter                   │
    │                     edits desires of class GoTo, and inhibits others for a time          │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

While a desire of class GoTo makes no progress (``distress.py``) the module first *insists*: the desire gets
``intensity`` and desired ``utility``, so that attention selects the best strategy for it. Then it *inhibits* the
classes ``inhibits``, which compete for CPU, by desires of utility 0; security desires cannot be inhibited. Both
measures end with progress or with the goal; the inhibiting desires also expire. Finally the goal is given up: all
desires for it have failed, and people are asked for help. Manual driving is no distress.

With ``conflict_s``, two behaviors that command one actuator group for so long are distress as well: the class of the
one that is outdone is inhibited until the other lets go (``conflicts.py``, ``conflict_relief.py``).
"""

from __future__ import annotations

import math
from typing import Self

from pydantic import Field, model_validator

from app.attention.desires import SCALE, Desire
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.base.geometry import Pose2
from app.messages import Accomplishment, Desires, Exploitation, IntentionReport, Message, NavigationStatus
from app.modules.motivations.conflict_relief import ConflictRelief
from app.modules.motivations.distress import (
    Act,
    DistressState,
    DistressTimes,
    GiveUp,
    GoalProgress,
    Level,
    Raise,
    Restore,
    decide,
    same_goal,
    status_of,
)
from app.modules.motivations.motivation import Motivation
from app.runtime.errors import ModuleFailed
from app.runtime.module import ModuleContext, Settings

GO_TO = "GoTo"
_BEAT_S = 0.25
#: Greatest age (s) of the arbiter's report of the driving behavior.
_FRESH_S = 0.5


class ProgressSupervisorSettings(Settings):
    """Settings of ProgressSupervisor; times in s without progress."""

    insist_s: float = Field(20.0, gt=0, description="the robot insists on its goal")
    inhibit_s: float = Field(40.0, gt=0, description="what competes with it is inhibited")
    give_up_s: float = Field(90.0, gt=0, description="the goal is given up, and people are asked for help")
    unreachable_s: float = Field(10.0, ge=0, description="a goal called unreachable for so long is given up")
    relief_s: float = Field(20.0, gt=0, description="what was done about distress stands so long at least")
    intensity: float = Field(SCALE, gt=0, le=SCALE, description="of the desire insisted on")
    utility: float = Field(SCALE, gt=0, le=SCALE, description="desired of the class insisted on")
    inhibits: tuple[str, ...] = Field((), description="desire classes that are inhibited, of those there are")
    by_hand: str = Field("Teleop", description="the behavior that people drive by")
    conflict_s: float | None = Field(
        None, gt=0, le=3600, description="a behavior that another one outdoes for so long is distress; null: none is"
    )
    hands: tuple[str, ...] = Field(
        ("Teleop", "HeadTeleop"), description="behaviors by which people move the robot: they outdo others rightly"
    )

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.insist_s <= self.inhibit_s <= self.give_up_s:
            raise ValueError("insist_s, inhibit_s and give_up_s follow each other: none may be shorter than the former")
        return self

    def times(self) -> DistressTimes:
        return DistressTimes(self.insist_s, self.inhibit_s, self.give_up_s, self.unreachable_s, self.relief_s)


class ProgressSupervisor(Motivation):
    title = "Progress supervisor"
    motive = "emotional"
    Settings = ProgressSupervisorSettings
    settings: ProgressSupervisorSettings

    _workspace: IntentionWorkspace
    _timeline: Timeline

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.navigation = self.input("navigation", NavigationStatus, capacity=4)
        self.going_toward = self.input("going_toward", NavigationStatus, capacity=4)
        self.exploitation = self.input("exploitation", Exploitation)
        self.on(self.navigation, self._take_status)
        self.on(self.going_toward, self._take_status)
        self.on(self.exploitation, self._take_exploitation)
        self.every(_BEAT_S, self._supervise)
        self._statuses: dict[str, NavigationStatus] = {}
        self._exploited: Exploitation | None = None
        self._distress = DistressState()
        #: Time at which each GoTo desire's parameters were given, by id: earlier statuses are not about them.
        self._given: dict[str, tuple[Pose2, float]] = {}
        #: The desire insisted on, before and after its intensity was raised.
        self._insisted: tuple[Desire, Desire] | None = None
        self._inhibiting: list[str] = []
        self._relief: ConflictRelief | None = None
        self.desires = self.input("desires", Desires, wants="never")
        self.intention = self.input("intention", IntentionReport, wants="never")
        self.on(self.desires, self._take_desires)
        self.on(self.intention, self._take_intention)

    def accept(self, name: str, message_type: type[Message]) -> None:
        """Take what another arbiter lets through."""
        if message_type is Exploitation:
            self.on(self.input(name, Exploitation, wants="never"), self._take_other)

    def check_wiring(self) -> None:
        """Raises ModuleFailed where conflicts are to be judged without what they are judged by."""
        if self.settings.conflict_s is None:
            return
        if missing := [port.name for port in (self.desires, self.intention) if not port.connected]:
            raise ModuleFailed(
                f"{self.name} judges conflicts (conflict_s) by what is desired and intended: wire its "
                f"{'inputs' if len(missing) > 1 else 'input'} {' and '.join(missing)}"
            )

    async def start(self) -> None:
        self._workspace = self.service(IntentionWorkspace)
        self._timeline = self.service(Timeline)
        if self.settings.conflict_s is not None:
            self._relief = ConflictRelief(
                self._workspace, self._timeline, self.source, self.settings.conflict_s, self.settings.hands
            )

    async def stop(self) -> None:
        """Restore the desires as people gave them."""
        if self._relief is not None:
            self._relief.restore()
        if self._insisted is not None or self._inhibiting:
            self._restore()

    async def _take_status(self, status: NavigationStatus) -> None:
        self._statuses[status.behavior] = status
        await self._supervise()

    async def _take_exploitation(self, exploitation: Exploitation) -> None:
        self._exploited = exploitation
        await self._take_other(exploitation)

    async def _take_other(self, exploitation: Exploitation) -> None:
        if self._relief is not None:
            self._relief.take(exploitation)

    async def _take_desires(self, desires: Desires) -> None:
        if self._relief is not None:
            self._relief.take_desires(desires)

    async def _take_intention(self, intention: IntentionReport) -> None:
        if self._relief is not None:
            self._relief.take_intention(intention)

    async def _supervise(self) -> None:
        now = self.clock.now()
        if self._relief is not None:
            self._relief.supervise(now)
        desire = self._workspace.strongest().get(GO_TO)
        if desire is not None and desire.utility == 0:
            desire = None  # another desire inhibits the class
        goal_progress = None if desire is None else self._goal_progress(desire)
        exploited = self._exploited
        fresh = exploited is not None and now - exploited.stamp <= _FRESH_S
        by_hand = exploited is not None and fresh and exploited.behavior == self.settings.by_hand
        self._distress, acts = decide(now, goal_progress, self._distress, self.settings.times(), by_hand=by_hand)
        for act in acts:
            self._do(act, desire)

    def _goal_progress(self, desire: Desire) -> GoalProgress:
        goal = goal_of(desire)
        known = self._given.get(desire.id)
        if known is None or not same_goal(known[0], goal):
            # A desire keeps its creation time when its goal changes.
            given = desire.created if known is None else self.clock.now()
            self._given = {d.id: self._given[d.id] for d in self._workspace.desires() if d.id in self._given}
            self._given[desire.id] = known = goal, given
        exploited = self._exploited
        return GoalProgress(
            goal,
            known[1],
            status_of(goal, known[1], self._statuses.values()),
            "" if exploited is None else exploited.limited,
        )

    def _do(self, act: Act, desire: Desire | None) -> None:
        match act:
            case Restore(why):
                self._restore()
                self._timeline.add("goal", GO_TO, f"Distress is over, {why}: desires are as they were before")
            case Raise(level, stuck_s) if desire is not None:
                self._raise(level, stuck_s, desire)
            case GiveUp(why) if desire is not None:
                self._fail_all(goal_of(desire), why)
                text = f"Gave up going to {place(desire)}: {why}. Please help, or send it elsewhere"
                self.log.warning("%s", text)
                goal = {name: desire.params.get(name) for name in ("x", "y", "heading")}
                about = {"desire": desire.id, "arrived": False, "why": why, "goal": goal}
                self._timeline.add("goal", GO_TO, text, about)

    def _raise(self, level: Level, stuck_s: float, desire: Desire) -> None:
        with self._workspace.transaction():
            if self._insisted is None:
                after = self._workspace.change(
                    desire.id,
                    intensity=max(desire.intensity, self.settings.intensity),
                    utility=max(desire.utility, self.settings.utility),
                )
                self._insisted = desire, after
            silenced = self._inhibit() if level is Level.INHIBITING else []
        text = f"Distress: {place(desire)} has come no nearer for {stuck_s:.0f} s; insists on it"
        if silenced:
            text += f" and inhibits {' and '.join(silenced)}"
        self.log.info("%s", text)
        self._timeline.add("goal", GO_TO, text, {"desire": desire.id, "stuck_s": round(stuck_s, 1)})

    def _inhibit(self) -> list[str]:
        strongest = self._workspace.strongest()
        silenced = [cls for cls in self.settings.inhibits if cls in strongest and not strongest[cls].security]
        for cls in silenced:
            # Expires by itself in case this module fails first.
            until_s = self.settings.give_up_s - self.settings.inhibit_s + self.settings.relief_s
            added = self._workspace.add(cls, intensity=SCALE, utility=0.0, ttl=until_s, source=self.source)
            self._inhibiting.append(added.id)
        return silenced

    def _restore(self) -> None:
        insisted, self._insisted = self._insisted, None
        inhibiting, self._inhibiting = self._inhibiting, []
        with self._workspace.transaction():
            for desire_id in inhibiting:
                self._remove(desire_id)
            if insisted is None:
                return
            before, after = insisted
            try:
                now = self._workspace.get(before.id)
            except UnknownDesire:
                return
            # Changes made by others since then stay.
            if (now.intensity, now.utility) == (after.intensity, after.utility):
                self._workspace.change(before.id, intensity=before.intensity, utility=before.utility)

    def _fail_all(self, goal: Pose2, why: str) -> None:
        """End all desires for this goal, whatever their source: it cannot be reached."""
        now = self.clock.now()
        with self._workspace.transaction():
            for desire in self._workspace.desires():
                if desire.cls == GO_TO and desire.utility > 0 and same_goal(goal_of(desire), goal):
                    self._workspace.accomplish(Accomplishment(now, desire.id, self.name, "failed", why))

    def _remove(self, desire_id: str) -> None:
        try:
            self._workspace.remove(desire_id)
        except UnknownDesire:
            self.log.info("desire %s was already gone", desire_id)


def goal_of(desire: Desire) -> Pose2:
    """The goal of a desire of class GoTo, on the map; heading NaN for any."""
    heading = desire.params.get("heading")
    return Pose2(float(desire.params["x"]), float(desire.params["y"]), math.nan if heading is None else float(heading))


def place(desire: Desire) -> str:
    if name := desire.params.get("name"):
        return str(name)
    goal = goal_of(desire)
    return f"({goal.x:.2f}, {goal.y:.2f})"
