"""What becomes of a stop: it is reached or given up, presented from beside its place, and its steps may fail. Pure
functions; what visitors are not shown is noted, and said where they would wonder."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from app.base.geometry import wrap_angle
from app.maps.poster_places import is_of_poster
from app.modules.motivations.tour_guide.entering import enter, lead, part
from app.modules.motivations.tour_guide.progress import Failure, Progress, View
from app.modules.motivations.tour_guide.wishes import Scene, goal_of, stop_of
from app.tours.model import Stop, rules_at

#: A pose that was good enough as it arrived may be corrected by so much (m, rad) until it is noted.
_POSE_M: Final = 0.05
_POSE_RAD: Final = 0.03
#: By the wish of a step, what failed.
_FAILED: Final[Mapping[str, str]] = {
    "say": "a text was not said",
    "look": "it could not look there",
    "point": "it could not point there",
    "gesture": "a gesture failed",
    "expression": "an expression failed",
}


def arrived(progress: Progress, view: View, scene: Scene) -> Progress:
    """At the stop; what is doubtful about its place is noted, and it is presented all the same. That its poster is gone
    or has moved is said first, since visitors see it, too."""
    stop = stop_of(progress, scene.tour)
    doubt = scene.doubts.get(stop.place, "")
    for what in (doubt, _beside_its_place(stop, view, scene)):
        if what:
            progress = replace(progress, failures=(*progress.failures, Failure(stop.id, what)))
    there = enter(progress, "turning" if stop.stand.face == "visitors" else "presenting", view)
    return replace(there, excuse="poster") if is_of_poster(doubt) else there


def _beside_its_place(stop: Stop, view: View, scene: Scene) -> str:
    """How far beside its place the robot stopped, where that is farther than the stop allows; "" else. Where it turns
    to visitors, the heading of the place is none of its own."""
    if view.X_MB is None:
        return ""
    place, stand = goal_of(stop, scene), stop.stand
    off_m = math.hypot(view.X_MB[0] - place["x"], view.X_MB[1] - place["y"])
    if off_m > stand.tolerance_m + _POSE_M:
        return f"presented {off_m:.2f} m from its place"
    off_rad = abs(wrap_angle(view.X_MB[2] - place.get("heading", view.X_MB[2])))
    turned = stand.face != "visitors" and off_rad > stand.tolerance_rad + _POSE_RAD
    return f"presented turned {math.degrees(off_rad):.0f}° from its place" if turned else ""


def unreached(progress: Progress, view: View, scene: Scene) -> Progress:
    """The stop cannot be reached this time: again, or ask, or what its rule says."""
    rule = rules_at(scene.tour, stop_of(progress, scene.tour)).reach
    if progress.attempt < rule.retry:
        return replace(enter(progress, "leading", view), attempt=progress.attempt + 1)
    blocked = enter(progress, "blocked", view, reason=f"the way to {stop_of(progress, scene.tour).id} is blocked")
    return blocked if rule.ask_s > 0 else given_up(blocked, view, scene)


def given_up(progress: Progress, view: View, scene: Scene) -> Progress:
    """On without ``progress``'s stop, or what its rule says; that is said."""
    stop = stop_of(progress, scene.tour)
    noted = replace(progress, failures=(*progress.failures, Failure(stop.id, "not reached")))
    match rules_at(scene.tour, stop).reach.then:
        case "skip":
            return replace(lead(noted, view, scene, progress.stop + 1), excuse="skipped")
        case "present_from_here":
            return replace(enter(noted, "presenting", view), excuse="from_here")
        case "end":
            return part(noted, view, f"{stop.id} cannot be reached", excuse="unreachable")


def failed_step(progress: Progress, name: str, view: View, scene: Scene) -> Progress:
    """The step again, or what its rule says; ``name`` is the wish that failed."""
    stop = stop_of(progress, scene.tour)
    rule = rules_at(scene.tour, stop).present
    if progress.attempt < rule.retry:
        return replace(enter(progress, "presenting", view, step=progress.step), attempt=progress.attempt + 1)
    noted = replace(progress, failures=(*progress.failures, Failure(stop.id, _FAILED.get(name, name))))
    match rule.then:
        case "continue":
            return replace(noted, ended=noted.ended | {f"{progress.entry}.{name}"})
        case "skip":
            return lead(noted, view, scene, progress.stop + 1)
        case "end":
            return part(noted, view, f"a step of {stop.id} failed")
