"""What there is now, of what comes in by channels: persons, objects, the place, emotions, what is done. No loop.

Identities are numbers: nothing of a face, a picture, a voice or a name is in an item.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final

from app.attention.desires import Desire
from app.base.geometry import Pose2
from app.maps.places import pose_of
from app.memory.deeds import key_of
from app.memory.em_art import Pattern
from app.memory.short_term import ShortTermMemory
from app.messages import (
    Desires,
    EmotionState,
    HeardWords,
    IntentionReport,
    Localization,
    PerceptEvent,
    Persons,
    Places,
)

SOMEONE: Final = "someone"
#: Localization of these states can be relied on.
_LOCALIZED: Final = frozenset({"mapping", "tracking"})
#: Another place is nearer only if it is so by this (m).
_NEARER_M: Final = 0.5
#: So many reports of desires that were done are remembered, to take each once.
_MOST_DONE: Final = 200
_DIGITS: Final = 6


@dataclass(frozen=True, slots=True)
class Senses:
    """What counts: a place within ``near_m`` (m), a person within ``person_m`` (m), of percept events the kinds
    ``objects`` and ``people``, of desires those of the classes ``acts`` (None: all). ``identity``: the activation of a
    person's number beside that of anybody, 0 for none. A percept whose leaving nothing reports stays ``stays_s``."""

    near_m: float
    person_m: float
    objects: Collection[str]
    people: Collection[str]
    acts: Collection[str] | None
    identity: float
    stays_s: float


class Scene:
    """Takes messages and says what there is."""

    def __init__(self, senses: Senses) -> None:
        self._senses = senses
        self._short = ShortTermMemory()
        #: When what is there, by kind and subject, was heard of last (s).
        self._present: dict[tuple[str, str], float] = {}
        self._persons: Mapping[str, float] = {}
        self._persons_at = -math.inf
        self._localization: Localization | None = None
        self._places: Places | None = None
        self._place = ""
        self._map = ""
        self._desires: Desires | None = None
        self._fulfilled: frozenset[str] = frozenset()
        self._done: dict[tuple[str, float], None] = {}
        self._felt: dict[str, float] = {}
        self.emotion: float | None = None

    # --- what comes in ---------------------------------------------------------------------------------------------

    def take_event(self, event: PerceptEvent) -> None:
        """Something appears, leaves or changes."""
        key = (event.kind, event.subject)
        if event.kind not in self._senses.people and event.kind not in self._senses.objects:
            return
        if not event.name.endswith(".leaves"):
            self._present[key] = event.stamp
        elif self._present.pop(key, None) is not None:
            self._perceive(*key, event.stamp)

    def take_persons(self, message: Persons) -> None:
        """Persons near enough count as someone, and those whose identity is known by their number, too."""
        found: dict[str, float] = {}
        for person in message.persons:
            if person.state not in ("confirmed", "unsure") or self._distance(person.p_OP) > self._senses.person_m:
                continue
            found[SOMEONE] = 1.0
            if person.person is not None and self._senses.identity > 0:
                found[f"person {person.person}"] = self._senses.identity
        self._persons, self._persons_at = found, message.stamp

    def take_localization(self, message: Localization) -> None:
        """Where the robot is."""
        self._localization = message

    def take_places(self, message: Places) -> None:
        """The places of the map."""
        self._places = message

    def take_words(self, heard: HeardWords) -> None:
        """A word or phrase of those listened for was recognized."""
        if heard.text and not heard.unsure:
            self._short.perceive("object", {f"word {heard.text}": 1.0}, heard.stamp)

    def take_intention(self, intention: IntentionReport) -> None:
        """Which classes get what they desire."""
        self._fulfilled = frozenset(intention.fulfilled)

    def take_desires(self, message: Desires) -> bool:
        """What is desired, done and accomplished; whether something that counts was accomplished."""
        self._desires = message
        accomplished = False
        classes = {desire.id: desire.cls for desire in (*message.desires, *message.ended)}
        reports = [(r.desire_id, r.stamp) for r in message.accomplishments if r.outcome == "done"]
        reports += [
            (each.id, each.ended) for each in message.ended if each.outcome == "done" and each.ended is not None
        ]
        for key in reports:
            if key not in self._done and self._counts(classes.get(key[0], "")):
                self._done[key] = None
                accomplished = True
        while len(self._done) > _MOST_DONE:
            del self._done[next(iter(self._done))]
        return accomplished

    def take_emotions(self, message: EmotionState) -> None:
        """What is felt from now on. As long as nothing is heard of emotions, they have no effect."""
        self.emotion = max((level.intensity for level in message.emotions), default=0.0)
        tenths = {level.emotion: round(level.intensity, 1) for level in message.emotions}
        self._felt = {name: value for name, value in tenths.items() if value > 0}

    # --- what there is ---------------------------------------------------------------------------------------------

    def look(self, now: float) -> tuple[Pattern, bool]:
        """What there is at ``now`` (s), and whether the robot came from one place to another."""
        left = self._follow_place(now)
        for key, since in tuple(self._present.items()):
            if now - since > self._senses.stays_s:
                del self._present[key]
            else:
                self._perceive(*key, now)
        if now - self._persons_at < 1.0:
            self._short.perceive("person", self._persons, now)
        if self._desires is not None:
            exploited = set(self._desires.exploited)
            acts = [d for d in self._desires.desires if d.id in exploited and self._counts(d.cls)]
            self._short.perceive("desire", {key_of(each.cls, each.params): 1.0 for each in acts}, now)
        self._short.perceive("emotion", self._felt, now)
        return self._short.pattern(now), left

    def at_work(self, classes: Collection[str], others: Collection[Desire]) -> Mapping[str, Desire]:
        """The desires of ``others`` of these ``classes`` that are served now, by key: the strongest of each class,
        where its class gets what it desires or a behavior is exploited for it."""
        exploited = set(self._desires.exploited) if self._desires is not None else set()
        strongest: dict[str, Desire] = {}
        for desire in others:
            if desire.cls in classes and desire.utility > 0:
                rival = strongest.get(desire.cls)
                if rival is None or desire.intensity > rival.intensity:
                    strongest[desire.cls] = desire
        served = (each for each in strongest.values() if each.cls in self._fulfilled or each.id in exploited)
        return {key_of(each.cls, each.params): each for each in served}

    # --- inside ----------------------------------------------------------------------------------------------------

    def _counts(self, cls: str) -> bool:
        return cls != "" and (self._senses.acts is None or cls in self._senses.acts)

    def _perceive(self, kind: str, subject: str, now: float) -> None:
        if kind in self._senses.people:
            self._short.perceive("person", {SOMEONE: 1.0}, now)
        else:
            self._short.perceive("object", {self._object(kind, subject): 1.0}, now)

    def _object(self, kind: str, subject: str) -> str:
        """A code by the place in front of which it hangs; else by a number, for its text may say anything."""
        if kind != "code":
            return f"{kind} {subject}".strip()
        for place in self._places.places if self._places is not None else ():
            if place.poster == subject:
                return f"code {place.id}"
        return f"code #{hashlib.sha256(subject.encode()).hexdigest()[:_DIGITS]}"

    def _distance(self, p_OP: tuple[float, float, float]) -> float:
        """From the robot (m), over ground; 0 while nothing is known of where the robot is."""
        where = self._localization
        if where is None:
            return 0.0
        p_MP = where.X_MO @ Pose2(p_OP[0], p_OP[1], 0.0)
        return math.hypot(p_MP.x - where.X_MB.x, p_MP.y - where.X_MB.y)

    def _follow_place(self, now: float) -> bool:
        """Take the place where the robot is; whether it was at another before."""
        where, places = self._localization, self._places
        if where is None or places is None or where.state not in _LOCALIZED:
            return False
        distances = {
            place.id: math.hypot(pose_of(place).x - where.X_MB.x, pose_of(place).y - where.X_MB.y)
            for place in places.places
        }
        nearest = min(distances, key=distances.__getitem__, default=None)
        if nearest is None or distances[nearest] > self._senses.near_m:
            return False
        still = distances.get(self._place, math.inf) if where.map == self._map else math.inf
        if still <= self._senses.near_m and still - distances[nearest] < _NEARER_M:
            nearest = self._place
        before, self._place, self._map = self._place, nearest, where.map
        item = f"{where.map}/{nearest}" if where.map else nearest
        moved = self._short.be_at(item, now)
        if moved and before:
            self._present.clear()
        return moved and before != ""
