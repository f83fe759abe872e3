"""Follow: keeps a polite distance from a person who walks, or comes to one from the front.

    ┌─────────────────────────────────────────────────────────────────────────────────────────────────────┐
    │ Follow  in   persons          Persons, 10 Hz; only where something tracks them                      │
    │         in   scans, images, odometry, joints, localization, map, zones, base   as PlanAndFollowPath │
    │         out  twist            Twist, each period while there is a person to follow or to look for   │
    │         out  path, status, costmap                                             as PlanAndFollowPath │
    │         out  accomplishments  Accomplishment: it is at the distance, or the person was lost        │
    └─────────────────────────────────────────────────────────────────────────────────────────────────────┘

It is PlanAndFollowPath with a goal that moves: costmap, planner, controllers and recovery are the same. The decisions
are pure (``following.py``). A command that would come nearer to the person than the distance, with the body's own
braking, is slowed down. Without fresh persons, scans or poses it does not move.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import DesireClass
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2, wrap_angle
from app.messages import Accomplished, Desire, Persons
from app.modules.behaviors.follow.following import Following, FollowRules, FollowStep, Side
from app.modules.behaviors.follow.standing import Point, bearing, nearing_mps, share_of_speed
from app.modules.behaviors.navigation.tracking.navigation_settings import PlanAndFollowPathSettings
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal, TrackingStep
from app.modules.behaviors.plan_and_follow_path import PlanAndFollowPath
from app.runtime.module import ModuleContext

#: How near (m, rad) to a place is there.
_TOLERANCE = (0.1, 0.15)
#: By so much (m, rad) the place moves before a way to it is planned again, and before a robot that is there leaves.
_MOVED = (0.05, 0.1)
_LEFT = (0.1, 0.35)
#: From a person's step to the base's answer (s).
_DELAY_S = 0.3


class FollowParameters(BaseModel):
    """Parameters of a desire of class Follow."""

    model_config = ConfigDict(extra="forbid", title="Follow a person", allow_inf_nan=False)

    person: int | None = Field(
        None, ge=0, title="Person", description="Number of the person, as the page shows it; none: the nearest."
    )
    distance_m: float = Field(
        1.2, ge=0.8, le=5, title="Distance", description="So many metres are kept between the robot and the person."
    )
    side: Side = Field(
        "behind",
        title="Side",
        description="behind: it follows; front: it comes to stand before the person, where they look or walk.",
    )


FOLLOW = DesireClass(
    name="Follow",
    title="Follow a person",
    description="Keep a polite distance from a person, turn to them where they stop, look round where they are lost.",
    parameters=FollowParameters,
)


class FollowSettings(PlanAndFollowPathSettings):
    """Settings of Follow, beside those of PlanAndFollowPath."""

    corner_share: float = Field(
        1.0, gt=0, le=1, description="share of the speed beside blind corners: what the person hides looks like one"
    )
    taken_s: float = Field(0.0, ge=0, description="as PlanAndFollowPath's; the person followed stands in the goal")
    hidden_s: float = Field(6.0, ge=2, le=60, description="so long it goes on to where an unseen person should be")
    search_s: float = Field(16.0, ge=1, le=600, description="so long it looks round for a person who is lost")


class Follow(PlanAndFollowPath):
    """Follows a person."""

    title = "Follow a person"
    desire_classes = (FOLLOW,)
    Settings = FollowSettings
    settings: FollowSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.persons = self.input("persons", Persons)
        self.on(self.persons, self._take_persons)
        self._persons: Persons | None = None
        self._parameters: FollowParameters | None = None
        self._desire: str | None = None
        self._following: Following | None = None
        self._decided: FollowStep | None = None
        self._end = Pose2()
        self._stands_at: NavigationGoal | None = None

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the desire's parameters, and the strategy's ``controller``; without any there is no desire."""
        self._controller = str(parameters.get("controller", self.settings.controller))
        known = {key: parameters[key] for key in FollowParameters.model_fields if key in parameters}
        given = FollowParameters.model_validate(known) if known else None
        if given != self._parameters:
            self._parameters, self._following = given, None

    async def _attach(self) -> None:
        """Nothing: PlanAndFollowPath keeps obstacles with the map, and plans for others."""

    async def _take_persons(self, persons: Persons) -> None:
        self._persons = persons

    async def _cycle(self) -> None:
        self._decide()
        await super()._cycle()

    def _decide(self) -> None:
        now, given = self.clock.now(), self._parameters
        desire = self.service(IntentionWorkspace).wanted(FOLLOW.name)
        motion, X_MO = self._poses.motion(now), self._poses.X_MO
        if given is None or not self.twist.filter.is_open or motion is None:
            self._following, self._decided, self._goal = None, None, None
            return
        if desire is not None and desire.id != self._desire:
            # What was given up may succeed for another desire.
            self._desire, self._following = desire.id, None
        if self._following is None:
            rules = FollowRules(given.distance_m, given.side, self.settings.hidden_s, self.settings.search_s)
            self._following = Following(given.person, rules, now, motion.pose.theta)
            self._goal = None
        before, step = self._decided, self._following.step(now, motion.pose, self._persons)
        self._decided = step
        if step.reason and (before is None or before.state != step.state):
            self.log.info(step.reason)
        if step.state == "given_up":
            self._report("failed", step.reason)
        if step.place is None or X_MO is None:
            self._goal = None
        else:
            self._aim(X_MO @ step.place)

    def _aim(self, X_MG: Pose2) -> None:
        """Move the goal, or leave the one that was reached."""
        left = self._goal is not None and self._stands_at is self._goal and _apart(self._end, X_MG, _LEFT)
        if self._goal is None or left:
            self._goal, self._end = NavigationGoal(X_MG, *_TOLERANCE), X_MG
        elif self._stands_at is not self._goal and _apart(self._end, X_MG, _MOVED):
            self._end = X_MG

    # --- what differs from a goal that stays ---

    def _end_of(self, goal: NavigationGoal) -> Pose2:
        return self._end if goal is self._goal else goal.pose

    def _arrived(self, goal: NavigationGoal, reason: str) -> None:
        self._stands_at = goal
        if self._decided is not None and self._decided.there and self._following is not None:
            self._report("done", f"it stands at its distance from {self._following.name}")

    def _limited(self, step: TrackingStep) -> TrackingStep:
        decided, given, motion = self._decided, self._parameters, self._poses.motion(self.clock.now())
        if decided is None or given is None or motion is None:
            return replace(step, linear_mps=0.0, angular_radps=0.0, lateral_mps=0.0)
        if decided.keep is None:
            return step
        at: Point = (motion.pose.x, motion.pose.y)
        gap_m = math.dist(at, decided.keep) - given.distance_m
        nearest_mps = nearing_mps(gap_m, self._control.body.limits[5], _DELAY_S)
        aside = wrap_angle(bearing(at, decided.keep) - motion.pose.theta)
        share = share_of_speed((step.linear_mps, step.lateral_mps), aside, nearest_mps)
        # The turn stays: it leads past the person, who else would bar it.
        return replace(step, linear_mps=share * step.linear_mps, lateral_mps=share * step.lateral_mps)

    def _report(self, outcome: Accomplished, reason: str) -> None:
        given = self._parameters
        wanted = None if given is None else given.model_dump()

        def about(desire: Desire) -> bool:
            return dict(desire.params) == wanted

        self._accomplishments.report(outcome, reason, about)


def _apart(a: Pose2, b: Pose2, least: tuple[float, float]) -> bool:
    return math.dist((a.x, a.y), (b.x, b.y)) > least[0] or abs(wrap_angle(b.theta - a.theta)) > least[1]
