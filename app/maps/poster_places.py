"""Places in front of posters (QR codes), and how they follow them as the map is corrected."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from app.base.geometry import Pose2, wrap_angle
from app.messages import Landmarks, Place

#: How far from a poster (m), along its normal, a place in front of it is.
STAND_OFF_M = 1.2
#: A poster of the same text that hangs within this (m) of one that is known no more is the same, found again.
SAME_M = 1.0
#: Smaller changes of a pose (m, rad) are no news.
MOVED = (0.01, 0.01)


@dataclass(frozen=True, slots=True)
class Poster:
    """A poster at ``x``, ``y`` (m) on the map; ``heading`` (rad): which way it faces, None while unknown. ``number`` is
    that of its landmark."""

    number: int
    text: str
    x: float
    y: float
    heading: float | None

    def stand(self, distance_m: float = STAND_OFF_M) -> Pose2 | None:
        """The pose ``distance_m`` in front of it, with it straight ahead; None while it is not known which way it
        faces."""
        if self.heading is None:
            return None
        x = self.x + distance_m * math.cos(self.heading)
        y = self.y + distance_m * math.sin(self.heading)
        return Pose2(x, y, wrap_angle(self.heading + math.pi))


def posters_of(landmarks: Landmarks | None) -> tuple[Poster, ...] | None:
    """The landmarks as posters on the map; None while they are not known on it."""
    if landmarks is None or landmarks.frame != "map":
        return None
    return tuple(Poster(each.id, each.text, *each.p_FQ[:2], heading=each.heading) for each in landmarks.landmarks)


def in_front_of(place: Place, poster: Poster, distance_m: float = STAND_OFF_M) -> Place:
    """``place``, in front of ``poster`` from now on. It stays where it is, if it is known to be of this poster, while
    it is not known which way that faces. Raises ValueError if it is not known and the place is not of it."""
    pose = poster.stand(distance_m)
    bound = replace(place, source="poster", poster=poster.text, landmark=poster.number)
    if pose is None:
        if place.poster != poster.text:
            raise ValueError(
                f"it is not known yet which way {poster.text!r} faces: let the robot see it from nearer by"
            )
        return bound
    away, turned = math.hypot(pose.x - place.x, pose.y - place.y), wrap_angle(pose.theta - place.heading)
    if place.poster == poster.text and away <= MOVED[0] and abs(turned) <= MOVED[1]:
        return bound
    return replace(bound, x=round(pose.x, 4), y=round(pose.y, 4), heading=round(pose.theta, 5))


def followed(place: Place, posters: Sequence[Poster], distance_m: float = STAND_OFF_M) -> tuple[Place, str]:
    """``place`` after its poster was measured better or moved with the map, and what is wrong with it in words.

    A poster whose number is not known any more is looked for by its text near where it was; one that hangs elsewhere
    is not followed, so that a place never jumps to another poster of the same text.
    """
    if place.source != "poster":
        return place, ""
    poster = next((each for each in posters if (each.number, each.text) == (place.landmark, place.poster)), None)
    if poster is None:
        # The place faces its poster.
        x = place.x + distance_m * math.cos(place.heading)
        y = place.y + distance_m * math.sin(place.heading)
        others = [(math.hypot(each.x - x, each.y - y), each) for each in posters if each.text == place.poster]
        if not others:
            return place, "its poster is not known on this map: it was removed, or not seen yet"
        away, poster = min(others, key=lambda other: other[0])
        if away > SAME_M:
            return place, f"its poster hangs {away:.1f} m from where it was: place it again"
    return in_front_of(place, poster, distance_m), ""


def is_of_poster(problem: str) -> bool:
    """Whether ``problem``, what is wrong with a place in words, is that its poster is gone or hangs elsewhere."""
    return problem.startswith("its poster ")


def poster_named(posters: Iterable[Poster], text: str, near: tuple[float, float] | None = None) -> Poster | None:
    """The poster of this text: the one nearest to ``near`` (m on the map), or the one found first; None without one."""
    same = [poster for poster in posters if poster.text == text]
    if near is None:
        return same[0] if same else None
    return min(same, key=lambda poster: math.hypot(poster.x - near[0], poster.y - near[1]), default=None)
