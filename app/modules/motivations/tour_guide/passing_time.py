"""The guide's states: what time, or the end of what was waited for, leads to. Pure functions."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from app.modules.motivations.tour_guide.company import Company, looks_back
from app.modules.motivations.tour_guide.entering import NOWHERE, enter, go_home, lead, part
from app.modules.motivations.tour_guide.progress import Ended, Progress, View
from app.modules.motivations.tour_guide.stop_outcomes import arrived, failed_step, given_up, unreached
from app.modules.motivations.tour_guide.waiting import searched, wait, waited
from app.modules.motivations.tour_guide.wishes import BESIDE, Scene, awaited, step_now, steps_now, stop_of
from app.tours.model import Tour, rules_at

#: A visitor who declines by leaving is gone so long (s).
LEFT_S: Final = 5.0
#: It turns to visitors for so long at most (s).
TURN_S: Final = 8.0
#: A step that reports nothing has failed after so long (s).
LONGEST_STEP_S: Final = 180.0
#: So long it looks for where it is (s).
LOST_S: Final = 180.0
#: Why no tour begins, also once the emergency stop is released.
HELD: Final = "the emergency stop was pressed: press Resume"
#: A pause ends the tour after so long (s); one by driving by hand ends so long after that.
LONGEST_PAUSE_S: Final = 600.0
AFTER_HAND_S: Final = 1.0
#: The way home takes no longer, and is tried so often.
HOME_S: Final = 600.0
HOME_TRIES: Final = 3


def outcome(progress: Progress, event: Ended, view: View, scene: Scene) -> Progress:
    """What the end of a desire of this entry leads to; that of an earlier one, to nothing."""
    entry, _, name = event.key.partition(".")
    if entry != str(progress.entry):
        return progress
    match progress.state:
        case "leading" if name == "go":
            return arrived(progress, view, scene) if event.done else unreached(progress, view, scene)
        case "listening" if name == "code":
            # Its time begins again, as after an answer.
            return enter(progress, "listening", view, step=progress.step)
        case "searching" if name == "go":
            return wait(progress, view, "it waits where it saw them last")
        case "going_home" if name == "go":
            if event.done:
                return replace(enter(progress, "idle", view, reason="the tour is over"), homed=True)
            if progress.attempt + 1 >= HOME_TRIES:
                return enter(progress, "idle", view, reason="the way home is blocked")
            return replace(enter(progress, "going_home", view), attempt=progress.attempt + 1)
        case "inviting" | "presenting" | "answering" | "parting":
            if event.key not in awaited(progress, scene, view.now):
                return progress
            if not event.done and progress.state == "presenting" and not name.startswith(BESIDE):
                return failed_step(progress, name, view, scene)
            return replace(progress, ended=progress.ended | {event.key})
    return progress


def timed(progress: Progress, view: View, scene: Scene) -> Progress:
    """What time, or what is seen by now, leads to."""
    tour, spent = scene.tour, view.now - progress.since
    match progress.state:
        case "idle":
            near = progress.near_since is not None and view.now - progress.near_since >= tour.begin.for_s
            begins = ("face" in tour.begin.by and near) or ("voice" in tour.begin.by and near and view.speaking)
            return invited(progress, view, tour) if begins and progress.invites else progress
        case "confirming":
            confirm = tour.greeting.confirm
            # A press may come from where the robot does not look: who was never seen has not left.
            gone_since = progress.gone_since if progress.company.met else None
            left = gone_since is not None and view.now - max(gone_since, progress.since) >= LEFT_S
            if left or confirm is None or spent >= confirm.at_most_s:
                return enter(progress, "idle", view, reason="visitors did not answer")
        case "leading" if view.people > 0 and view.farthest_m > tour.pace.wait_m:
            return wait(progress, view, "visitors fell behind")
        case "leading" if looks_back(progress.company, view, tour.pace):
            return wait(progress, view, "it looks back for visitors")
        case "waiting":
            return waited(progress, view, tour.pace)
        case "searching":
            return searched(progress, view, tour.pace)
        case "turning" if spent >= TURN_S or (view.people > 0 and spent > 0):
            return replace(enter(progress, "presenting", view), excuse=progress.excuse)
        case "inviting" | "presenting" | "answering" | "parting":
            return _stepped(progress, view, scene)
        case "listening":
            return _listened(progress, view, scene)
        case "blocked" if spent >= rules_at(tour, stop_of(progress, tour)).reach.ask_s:
            return given_up(progress, view, scene)
        case "lost" if view.localized:
            return lead(progress, view, scene, progress.stop)
        case "lost" if spent >= LOST_S:
            return part(progress, view, NOWHERE, excuse="lost")
        case "paused":
            if spent >= LONGEST_PAUSE_S and not (view.e_stop or view.by_hand):
                # Nothing moves before a press: it ends where it is.
                return enter(progress, "idle", view, reason="it was paused too long")
            if not progress.to_press and not view.by_hand and spent >= AFTER_HAND_S:
                return resumed(progress, view, scene)
        case "going_home" if spent >= HOME_S:
            return enter(progress, "idle", view, reason="the way home took too long")
    return progress


def _stepped(progress: Progress, view: View, scene: Scene) -> Progress:
    """On to the next step once all that this one waits for has ended, or has taken too long."""
    missing = awaited(progress, scene, view.now) - progress.ended
    if missing and view.now - progress.since < LONGEST_STEP_S:
        return progress
    if missing and progress.state == "presenting":
        return failed_step(progress, min(missing).partition(".")[2], view, scene)
    step = step_now(progress, scene.tour)
    if progress.state == "presenting" and step is not None and step.wait is not None:
        return enter(progress, "listening", view, step=progress.step)
    return next_step(progress, view, scene)


def _listened(progress: Progress, view: View, scene: Scene) -> Progress:
    if progress.carried is not None and view.now - progress.since < LONGEST_STEP_S:
        return progress
    step = step_now(progress, scene.tour)
    wait = None if step is None else step.wait
    # Where it does not turn to visitors, it does not see whether they have left.
    faces = stop_of(progress, scene.tour).stand.face == "visitors"
    left = faces and wait is not None and wait.all_left and progress.gone_since is not None
    gone = left and view.now - max(progress.gone_since or 0.0, progress.since) >= LEFT_S
    if wait is None or gone or view.now - progress.since >= wait.at_most_s:
        return next_step(progress, view, scene)
    return progress


def next_step(progress: Progress, view: View, scene: Scene) -> Progress:
    """The next step of this state, or what comes after it."""
    tour, state = scene.tour, progress.state
    if state == "answering":
        return enter(progress, "listening", view, step=progress.listened)
    if progress.step + 1 < len(steps_now(progress, tour)):
        reason = progress.reason if state == "parting" else ""
        after = "presenting" if state == "listening" else state
        return enter(progress, after, view, step=progress.step + 1, reason=reason)
    match state:
        case "inviting":
            asks = tour.greeting.confirm is not None
            return enter(progress, "confirming", view) if asks else lead(progress, view, scene)
        case "parting":
            return go_home(progress, view, scene)
    done = replace(progress, presented=(*progress.presented, stop_of(progress, tour).id))
    return lead(done, view, scene, progress.stop + 1)


def resumed(progress: Progress, view: View, scene: Scene) -> Progress:
    """In the state before: a text from the sentence that was interrupted on, a way planned from here."""
    match progress.resume:
        case "presenting" | "inviting" | "parting":
            again = enter(progress, progress.resume, view, step=progress.step)
            again = replace(again, carried=progress.carried)
            return replace(again, sentence=progress.sentence, said_from=progress.sentence)
        case "listening":
            return replace(enter(progress, "listening", view, step=progress.step), carried=progress.carried)
        case "answering":
            return enter(progress, "listening", view, step=progress.listened)
        case "leading" | "waiting" | "searching" | "turning" | "blocked" | "lost":
            return lead(progress, view, scene, progress.stop)
    return enter(progress, progress.resume, view)


def invited(progress: Progress, view: View, tour: Tour) -> Progress:
    """Inviting visitors, or why no tour begins."""
    if progress.is_running:
        return progress
    if view.e_stop or view.by_hand:
        return replace(progress, reason="no tour begins while the robot is held")
    if progress.held:
        return replace(progress, reason=HELD)
    if view.battery is not None and view.battery < tour.battery.begin_min:
        return replace(progress, reason="the battery is too low for a tour")
    fresh = Progress(entry=progress.entry, company=Company(seen_m=view.driven_m), homed=progress.homed)
    return enter(fresh, "inviting", view)
