"""Entering the guide's states: on the way to a stop, to the farewell, home. Pure functions."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from app.modules.motivations.tour_guide.company import set_out
from app.modules.motivations.tour_guide.progress import Failure, Progress, State, View
from app.modules.motivations.tour_guide.wishes import Scene

#: States in which it drives, or is about to.
ON_THE_WAY: Final[frozenset[State]] = frozenset({"leading", "waiting", "searching", "turning", "blocked", "lost"})
#: States in which a robot that is home stays there.
AT_HOME: Final[frozenset[State]] = frozenset({"idle", "inviting", "confirming"})
#: States in which it presents a stop.
AT_A_STOP: Final[frozenset[State]] = frozenset({"presenting", "listening", "answering"})
#: Why it neither leads nor goes home.
NOWHERE: Final = "the robot does not know where it is"


def subject_of(progress: Progress) -> State:
    """The state, or the one before a pause."""
    return progress.resume if progress.state == "paused" else progress.state


def enter(progress: Progress, state: State, view: View, *, step: int = 0, reason: str = "") -> Progress:
    """In ``state`` from now on. A wait for visitors is no new try to reach the stop."""
    same_try = {progress.state, state} <= {"leading", "waiting", "searching"} and progress.state != state
    return replace(
        progress,
        state=state,
        since=view.now,
        entry=progress.entry + 1,
        step=step,
        ended=frozenset(),
        attempt=progress.attempt if same_try else 0,
        sentence=0,
        said_from=0,
        to_press=False,
        pause_spoken=False,
        stuck_since=None,
        # What is to be said at a stop stays until it is there.
        carried=progress.carried if subject_of(progress) in ON_THE_WAY else None,
        excuse="",
        homed=progress.homed and state in AT_HOME,
        invites=state != "idle",
        reason=reason,
    )


def lead(progress: Progress, view: View, scene: Scene, stop: int = 0) -> Progress:
    """On the way to ``stop``, or to the first after it that is not left out; after the last, it says goodbye."""
    stops = scene.tour.stops
    for index in range(stop, len(stops)):
        if stops[index].left_out:
            continue
        carried = progress.carried if index == progress.stop else None
        company = set_out(progress.company, view, scene.tour.pace)
        ahead = replace(progress, stop=index, company=company, carried=carried)
        if stops[index].place in scene.places:
            return replace(enter(ahead, "leading", view), attempt=0)
        noted = Failure(stops[index].id, f"there is no place {stops[index].place}")
        progress = replace(ahead, failures=(*progress.failures, noted))
    return part(progress, view, "it is over")


def part(progress: Progress, view: View, reason: str, *, excuse: str = "") -> Progress:
    """Saying goodbye, for ``reason``; ``excuse`` is what is said before."""
    return replace(enter(progress, "parting", view, reason=reason), excuse=excuse)


def go_home(progress: Progress, view: View, scene: Scene) -> Progress:
    """``progress`` on the way home; idle where the tour has none, its place is not there, or it ends for being lost."""
    home = scene.tour.home
    if progress.reason == NOWHERE and not view.localized:
        return enter(progress, "idle", view, reason=NOWHERE)
    if home is None:
        return enter(progress, "idle", view, reason=progress.reason)
    if home not in scene.places:
        return enter(progress, "idle", view, reason=f"there is no place {home}")
    return enter(progress, "going_home", view, reason=progress.reason)
