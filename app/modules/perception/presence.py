"""Presence with hysteresis: which subjects of one kind are there, from repeated looks; without any event loop.

A subject appears after enough sightings, leaves after enough looks without it, and changes where it has moved or turned
far enough since its last event. Only looks count, and each for at most ``LONGEST_LOOK_S``: a perception that rests
looks at nothing, so nothing leaves meanwhile. A subject is missed only by the source that saw it last, since another
camera may look elsewhere. Between two ``appears`` of a subject there is always one ``leaves``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from pydantic import BaseModel, Field

from app.base.geometry import wrap_angle

Point = tuple[float, float, float]
Verb = Literal["appears", "leaves", "changes"]

#: One look says something about so much time (s) before it at most: what was before, it did not see.
LONGEST_LOOK_S = 1.0


class Hysteresis(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """When a subject of one kind appears, leaves and changes."""

    sightings: int = Field(1, ge=1, description="looks that show it before it appears")
    on_s: float = Field(0.0, ge=0, description="s of looking at it before it appears")
    off_looks: int = Field(2, ge=1, description="looks in a row without it before it leaves")
    off_s: float = Field(2.0, ge=0, description="s of looking without it before it leaves")
    enter: float = Field(0.0, ge=0, le=1, description="least confidence of a sighting of what is not there yet")
    stay: float = Field(0.0, ge=0, le=1, description="least confidence of a sighting of what is there")
    moved_m: float | None = Field(None, gt=0, description="it changes when it has moved further; none: never")
    turned_rad: float | None = Field(
        None, gt=0, description="it changes when its direction turned further; none: never"
    )
    change_s: float = Field(2.0, ge=0, description="least time between two events of one subject, of which one changes")


@dataclass(frozen=True, slots=True)
class Sighting:
    """One subject in one look: ``confidence`` in [0, 1], NaN where it was not judged; ``p_O`` (m) and ``heading`` (rad)
    in ``odom``, None where unknown."""

    subject: str
    confidence: float = 1.0
    p_O: Point | None = None
    heading: float | None = None


@dataclass(frozen=True, slots=True)
class Subject:
    """The state of one subject: its newest ``sighting``, made by ``source``, and the one at its last event.

    ``first`` is the stamp of its first sighting and ``reported`` that of its last event; ``seen_s`` and ``missed_s``
    are s of looking with it and without it.
    """

    sighting: Sighting
    source: str
    first: float
    there: bool = False
    sightings: int = 0
    seen_s: float = 0.0
    missed_looks: int = 0
    missed_s: float = 0.0
    reported: float = -math.inf
    reference: Sighting | None = None


@dataclass(frozen=True, slots=True)
class PresenceState:
    """The subjects of one kind, appeared or not yet, and when each source looked last."""

    subjects: Mapping[str, Subject] = field(default_factory=dict)
    looked: Mapping[str, float] = field(default_factory=dict)

    @property
    def there(self) -> frozenset[str]:
        """The subjects that have appeared and not left."""
        return frozenset(name for name, subject in self.subjects.items() if subject.there)


@dataclass(frozen=True, slots=True)
class Change:
    """``subject`` appears, leaves or changes."""

    verb: Verb
    subject: Subject


def look(
    before: PresenceState, rule: Hysteresis, source: str, stamp: float, sightings: Iterable[Sighting]
) -> tuple[PresenceState, tuple[Change, ...]]:
    """The presence after ``source`` looked at ``stamp`` (s) and saw exactly ``sightings``, and what changed by it.

    Of several sightings of one subject the one nearest to its last place counts, else the first.
    """
    since_last = stamp - before.looked.get(source, stamp)
    looked_s = min(max(0.0, since_last), LONGEST_LOOK_S)
    subjects = dict(before.subjects)
    changes: list[Change] = []
    seen = _chosen(before, rule, sightings)
    for name, sighting in seen.items():
        subject = _seen(subjects.get(name), sighting, source, stamp, looked_s)
        verb = _verb(subject, rule, stamp)
        if verb is not None:
            subject = replace(subject, there=True, reported=stamp, reference=subject.sighting)
            changes.append(Change(verb, subject))
        subjects[name] = subject
    for name, subject in before.subjects.items():
        if name in seen or subject.source != source:
            continue
        missed = replace(subject, missed_looks=subject.missed_looks + 1, missed_s=subject.missed_s + looked_s)
        subjects[name] = missed
        if missed.missed_looks >= rule.off_looks and missed.missed_s >= rule.off_s:
            del subjects[name]
            if subject.there:
                changes.append(Change("leaves", missed))
    newest = max(stamp, before.looked.get(source, stamp))
    return PresenceState(subjects, {**before.looked, source: newest}), tuple(changes)


def _chosen(before: PresenceState, rule: Hysteresis, sightings: Iterable[Sighting]) -> dict[str, Sighting]:
    """Each subject's sighting that counts; those of too little confidence do not."""
    chosen: dict[str, Sighting] = {}
    for sighting in sightings:
        subject = before.subjects.get(sighting.subject)
        there = subject is not None and subject.there
        # NaN, not judged, keeps what is there and brings nothing new.
        enough = not sighting.confidence < rule.stay if there else sighting.confidence >= rule.enter
        if not enough:
            continue
        other = chosen.get(sighting.subject)
        last = None if subject is None else subject.sighting.p_O
        if other is None or _distance(last, sighting.p_O) < _distance(last, other.p_O):
            chosen[sighting.subject] = sighting
    return chosen


def _seen(before: Subject | None, sighting: Sighting, source: str, stamp: float, looked_s: float) -> Subject:
    if before is None:
        return Subject(sighting, source, stamp, sightings=1)
    again = before.source == source and before.missed_looks == 0
    return replace(
        before,
        sighting=_completed(sighting, before.sighting),
        # A place that becomes known after the event is where it was then, no change.
        reference=None if before.reference is None else _completed(before.reference, sighting),
        source=source,
        sightings=before.sightings + 1,
        seen_s=before.seen_s + (looked_s if again else 0.0),
        missed_looks=0,
        missed_s=0.0,
    )


def _completed(sighting: Sighting, other: Sighting) -> Sighting:
    """``sighting``, with what is unknown of it taken from ``other``."""
    return replace(
        sighting,
        confidence=other.confidence if math.isnan(sighting.confidence) else sighting.confidence,
        p_O=other.p_O if sighting.p_O is None else sighting.p_O,
        heading=other.heading if sighting.heading is None else sighting.heading,
    )


def _verb(subject: Subject, rule: Hysteresis, stamp: float) -> Verb | None:
    if not subject.there:
        return "appears" if subject.sightings >= rule.sightings and subject.seen_s >= rule.on_s else None
    reference = subject.reference
    if reference is None or stamp - subject.reported < rule.change_s:
        return None
    moved_m = _distance(reference.p_O, subject.sighting.p_O)
    if rule.moved_m is not None and rule.moved_m < moved_m < math.inf:
        return "changes"
    if rule.turned_rad is not None and _turned(reference.heading, subject.sighting.heading) > rule.turned_rad:
        return "changes"
    return None


def _distance(one: Point | None, other: Point | None) -> float:
    """Infinite where either is unknown."""
    return math.inf if one is None or other is None else math.dist(one, other)


def _turned(one: float | None, other: float | None) -> float:
    """0 where either is unknown."""
    return 0.0 if one is None or other is None else abs(wrap_angle(other - one))
