"""How a person is followed: what to do now, by where robot and person are. A small class without a clock.

waiting ─▶ following ─▶ hidden ─▶ searching ─▶ given_up
               ▲           │           │
               └───────────┴───────────┘ seen again
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from app.base.geometry import Pose2
from app.messages import Persons
from app.modules.behaviors.follow.followed_person import FollowedPerson, look_round
from app.modules.behaviors.follow.standing import Point, bearing, behind, in_front, is_in_front

Side = Literal["behind", "front"]
FollowState = Literal["waiting", "following", "hidden", "searching", "given_up"]

#: Who was not seen for so long (s) is hidden.
_SEEN_S = 1.5
#: Behind who walks, the way leads to where they are so much later (s): to a place just ahead, controllers only creep.
_LEAD_S = 1.5


@dataclass(frozen=True, slots=True)
class FollowRules:
    """``distance_m`` is kept from the person on ``side`` of them. Unseen for ``hidden_s``, they are lost: they are
    looked for during ``search_s``. Persons that are older than ``fresh_s`` say nothing."""

    distance_m: float = 1.2
    side: Side = "behind"
    hidden_s: float = 6.0
    search_s: float = 16.0
    fresh_s: float = 0.5


@dataclass(frozen=True, slots=True)
class FollowStep:
    """What to do: go to ``place`` (``X_OG``), None: stand. ``keep``: the place (m, in ``odom``) that the robot comes no
    nearer to than the distance; None while nothing is known of them. ``there``: a robot at ``place`` is
    where it should. ``reason``: for people."""

    state: FollowState
    place: Pose2 | None
    keep: Point | None
    reason: str
    there: bool = False


class Following:
    """Follows one person from ``begin`` (s) on; ``person``: None for the nearest. ``heading`` (rad): the robot's."""

    def __init__(self, person: int | None, rules: FollowRules, begin: float, heading: float) -> None:
        self._rules = rules
        self._begin = begin
        self._begin_rad = heading
        self._person = FollowedPerson(person)
        self._given_up = ""

    @property
    def name(self) -> str:
        """Who is followed, for people."""
        return self._person.name

    def step(self, now: float, X_OB: Pose2, persons: Persons | None) -> FollowStep:
        """Decide at ``now`` (s), with the robot at ``X_OB``, by the newest ``persons``. What was given up stays so."""
        rules, person, robot = self._rules, self._person, (X_OB.x, X_OB.y)
        if self._given_up:
            return FollowStep("given_up", None, None, self._given_up)
        fresh = persons is not None and abs(now - persons.stamp) <= rules.fresh_s
        if fresh and persons is not None:
            person.see(persons, robot, now)
        sight = person.sight
        unseen_s = now - (self._begin if sight is None else sight.stamp)
        if unseen_s > rules.hidden_s + rules.search_s:
            self._given_up = self._why(unseen_s)
            return FollowStep("given_up", None, None, self._given_up)
        if not fresh:
            return FollowStep("waiting", None, None, "it waits: nothing tracks persons")
        if unseen_s > rules.hidden_s:
            return self._search(X_OB, now, (unseen_s - rules.hidden_s) / rules.search_s)
        if sight is None:
            return FollowStep("waiting", None, None, f"it waits: {person.name} is not seen")
        if unseen_s > _SEEN_S:
            expected = sight.expected(now)
            reason = f"{person.name} is out of sight: it goes on to where they should be"
            return FollowStep("hidden", behind(robot, expected, rules.distance_m), expected, reason)
        if rules.side == "behind":
            ahead = sight.expected(sight.stamp + _LEAD_S)
            return FollowStep("following", behind(robot, ahead, rules.distance_m), sight.at, "", there=True)
        facing = person.facing(robot)
        place = in_front(robot, sight.at, facing, rules.distance_m)
        there = is_in_front((place.x, place.y), sight.at, facing)
        return FollowStep("following", place, sight.at, "", there=there)

    def _search(self, X_OB: Pose2, now: float, share: float) -> FollowStep:
        """Look round on the spot, first where they should be."""
        sight = self._person.sight
        expected = None if sight is None else sight.expected(now)
        towards = self._begin_rad if expected is None else bearing((X_OB.x, X_OB.y), expected)
        place = Pose2(X_OB.x, X_OB.y, look_round(towards, share))
        return FollowStep("searching", place, expected, f"{self._person.name} is lost: it looks round for them")

    def _why(self, unseen_s: float) -> str:
        if self._person.sight is None:
            return f"{self._person.name} was not seen for {unseen_s:.0f} s"
        x, y = self._person.sight.at
        away = math.floor(unseen_s)
        return f"{self._person.name} was lost: seen last {away} s ago, at ({x:.1f}, {y:.1f}) m in odom"
