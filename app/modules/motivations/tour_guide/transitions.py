"""The guide's states: what it sees, and what people say and do, lead from one to the next; ``passing_time`` says what
time leads to. Pure functions."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, assert_never

from app.base.geometry import wrap_angle
from app.modules.motivations.tour_guide.commands import among, commands_now
from app.modules.motivations.tour_guide.company import falls_behind_m, noted
from app.modules.motivations.tour_guide.entering import (
    AT_A_STOP,
    AT_HOME,
    NOWHERE,
    ON_THE_WAY,
    enter,
    lead,
    part,
    subject_of,
)
from app.modules.motivations.tour_guide.passing_time import HELD, invited, next_step, outcome, resumed, timed
from app.modules.motivations.tour_guide.progress import (
    Asked,
    Called,
    Chosen,
    Clapped,
    CodeRead,
    Ended,
    Event,
    Heard,
    Pressed,
    Progress,
    Scheduled,
    Spoken,
    State,
    View,
    Withdrawn,
)
from app.modules.motivations.tour_guide.waiting import looks_towards
from app.modules.motivations.tour_guide.wishes import Scene, step_now, stop_of
from app.tours.codes import accepted
from app.tours.model import Tour

#: As it sets out, mapping begins, and says within this time (s) where the robot is.
LOCATES_S: Final = 3.0
#: It speeds up again at this share of the distance at which it slows down.
_CLOSER: Final = 0.8
#: It turns after visitors who are beside it by more (rad).
_BESIDE_RAD: Final = 0.35
#: People who are seen then come along.
_COUNTS: Final[frozenset[State]] = AT_A_STOP | frozenset[State](
    {"inviting", "confirming", "waiting", "searching", "turning"}
)


def advance(progress: Progress, view: View, scene: Scene) -> Progress:
    """``progress`` after what is seen now."""
    progress = interrupted(progress, view, scene)
    if progress.held and not progress.is_running:
        # What comes now may say more, such as why a press does nothing.
        progress = replace(progress, reason=HELD)
    for event in view.events:
        progress = _after(progress, event, view, scene)
    if view.e_stop or view.by_hand:
        # What is pressed or heard does not move a robot that is held.
        progress = interrupted(progress, view, scene)
    progress = _people(progress, view, scene.tour)
    return timed(progress, view, scene)


# --- what may come in any state ----------------------------------------------------------------------------------


def interrupted(progress: Progress, view: View, scene: Scene) -> Progress:
    """``progress`` after the emergency stop, driving by hand, an empty battery, a pose that is lost."""
    if view.e_stop or view.by_hand:
        progress = replace(progress, homed=False, held=progress.held or view.e_stop)
    if not progress.is_running:
        return progress
    if view.e_stop:
        return _paused(progress, view, "the emergency stop was pressed", to_press=True, excuse="e_stop")
    if view.by_hand:
        return _paused(progress, view, "it is driven by hand", to_press=False)
    if progress.state in ("paused", "parting", "going_home"):
        return progress
    if view.battery is not None and view.battery < scene.tour.battery.end_below:
        return part(progress, view, "the battery is low", excuse="battery")
    known = view.localized or progress.state == "lost" or view.now - progress.since < LOCATES_S
    if progress.state in ON_THE_WAY and not known:
        return enter(progress, "lost", view, reason=NOWHERE)
    return progress


def _paused(progress: Progress, view: View, reason: str, *, to_press: bool, excuse: str = "paused") -> Progress:
    if progress.state == "paused":
        # The emergency stop withdraws the goal, too, and may be seen later.
        changes = progress.pause_spoken or not progress.to_press or excuse == "e_stop" != progress.excuse
        if to_press and changes:
            return replace(progress, to_press=True, pause_spoken=False, reason=reason, excuse=excuse)
        # The time until it goes on begins when no hand drives any more.
        return progress if to_press or progress.to_press else replace(progress, since=view.now)
    kept = replace(progress, resume=progress.state, to_press=to_press, excuse=excuse)
    return replace(kept, state="paused", since=view.now, entry=progress.entry + 1, reason=reason)


def _after(progress: Progress, event: Event, view: View, scene: Scene) -> Progress:
    match event:
        case Ended():
            return outcome(progress, event, view, scene)
        case Withdrawn(key) if key == f"{progress.entry}.go":
            # A person who withdraws the goal stops the robot.
            return _paused(progress, view, "its goal was withdrawn", to_press=True)
        case Withdrawn(key):
            return outcome(progress, Ended(key, True), view, scene)
        case Pressed():
            return _pressed(progress, event, view, scene)
        case Chosen(stop):
            index = next((i for i, each in enumerate(scene.tour.stops) if each.id == stop), None)
            return progress if index is None else _sent(progress, index, view, scene)
        case Asked(question):
            return _asked(progress, question, view, scene.tour)
        case Heard(phrase):
            return _heard(progress, phrase, view, scene)
        case CodeRead(text):
            return _shown(progress, text, view, scene)
        case Clapped(times):
            step = step_now(progress, scene.tour)
            claps = None if step is None or step.wait is None else step.wait.claps
            over = progress.state == "listening" and claps == times
            return next_step(progress, view, scene) if over else progress
        case Called():
            step = step_now(progress, scene.tour)
            over = progress.state == "listening" and step is not None and step.wait is not None and step.wait.call
            return next_step(progress, view, scene) if over else progress
        case Spoken(key, sentence):
            now = key == f"{progress.entry}.say"
            return replace(progress, sentence=progress.said_from + sentence) if now else progress
        case Scheduled():
            return invited(progress, view, scene.tour)
    assert_never(event)


def _pressed(progress: Progress, event: Pressed, view: View, scene: Scene) -> Progress:
    match event.button:
        case "start":
            return invited(progress, view, scene.tour)
        case "end" if progress.state == "paused" and progress.to_press:
            # The robot does not even go home before a press to go on.
            return enter(progress, "idle", view, reason="it was ended")
        case "end" if progress.is_running and subject_of(progress) not in ("parting", "going_home"):
            return part(progress, view, "it was ended")
        case "agree" if progress.state == "confirming":
            return lead(progress, view, scene)
        case "decline" if progress.state in ("inviting", "confirming"):
            return enter(progress, "idle", view, reason="visitors declined")
        case "pause" if progress.is_running:
            return _paused(progress, view, "it was paused", to_press=True)
        case "resume" if progress.state == "paused" and not view.e_stop:
            return resumed(replace(progress, held=False), view, scene)
        case "resume" if progress.held and not view.e_stop:
            return replace(progress, held=False, reason="")
        case "retry" if progress.state == "blocked":
            return lead(progress, view, scene, progress.stop)
        case "next" if progress.state == "listening":
            return next_step(progress, view, scene)
        case "repeat" if progress.state in AT_A_STOP:
            return enter(progress, "presenting", view)
        case "skip" if subject_of(progress) in ON_THE_WAY | AT_A_STOP:
            skipped = replace(progress, skipped=(*progress.skipped, progress.stop))
            return _sent(skipped, progress.stop + 1, view, scene)
        case "undo_skip" if progress.skipped and subject_of(progress) in ON_THE_WAY | AT_A_STOP:
            return _sent(replace(progress, skipped=progress.skipped[:-1]), progress.skipped[-1], view, scene)
    return progress


def _sent(progress: Progress, stop: int, view: View, scene: Scene) -> Progress:
    """On the way to ``stop``; while it is paused, it goes there afterwards."""
    if subject_of(progress) not in ON_THE_WAY | AT_A_STOP:
        return progress
    if progress.state != "paused":
        return lead(progress, view, scene, stop)
    # Where the way leads is found as if it went on, and kept for then.
    ahead = lead(replace(progress, state=progress.resume), view, scene, stop)
    state = replace(ahead, state="paused", resume=ahead.state, since=progress.since)
    return replace(state, to_press=progress.to_press, reason=progress.reason)


# --- what people say and do -----------------------------------------------------------------------------------------


def _asked(progress: Progress, question: str, view: View, tour: Tour) -> Progress:
    if progress.state not in ("listening", "answering"):
        return progress
    questions = stop_of(progress, tour).questions
    index = next((number for number, each in enumerate(questions) if each.id == question), None)
    if index is None:
        return progress
    listened = progress.step if progress.state == "listening" else progress.listened
    return replace(enter(progress, "answering", view), question=index, listened=listened)


def _heard(progress: Progress, phrase: str, view: View, scene: Scene) -> Progress:
    tour = scene.tour
    if progress.state == "confirming" and (confirm := tour.greeting.confirm) is not None:
        if among(phrase, confirm.agree):
            return lead(progress, view, scene)
        if among(phrase, confirm.decline):
            return enter(progress, "idle", view, reason="visitors declined")
    if progress.state == "listening":
        step = step_now(progress, tour)
        if step is not None and step.wait is not None and among(phrase, step.wait.words):
            return next_step(progress, view, scene)
        for question in stop_of(progress, tour).questions:
            if among(phrase, question.words):
                return _asked(progress, question.id, view, tour)
    for words, command in commands_now(progress, tour):
        if among(phrase, words):
            after = _after(progress, command, view, scene)
            begins = after.state == "paused" and progress.state != "paused"
            return replace(after, pause_spoken=True, reason="a visitor asked for a pause") if begins else after
    return progress


def _shown(progress: Progress, text: str, view: View, scene: Scene) -> Progress:
    """What a code that is shown to it does: only while it listens, so that no poster on its way diverts it."""
    code = accepted(text, scene.tour) if progress.state == "listening" else None
    if code is None:
        return progress
    here = stop_of(progress, scene.tour)
    if code.stop is not None and code.stop.id != here.id:
        index = scene.tour.stops.index(code.stop)
        sent = _sent(progress, index, view, scene)
        return replace(sent, carried=code.says) if (sent.state, sent.stop) == ("leading", index) else sent
    if code.says is None or text == here.poster:
        return progress  # the poster of this stop hangs in view
    return replace(enter(progress, "listening", view, step=progress.step), carried=code.says)


def _people(progress: Progress, view: View, tour: Tour) -> Progress:
    """Notes who is seen: since when enough are near, since when none is, and how far it drove since all were."""
    enough = view.near >= tour.begin.people_min
    near_since = (view.now if progress.near_since is None else progress.near_since) if enough else None
    unseen = view.people + view.others == 0 and not view.speaking
    gone = (view.now if progress.gone_since is None else progress.gone_since) if unseen else None
    towards, wanted = progress.towards, looks_towards(progress, view) if progress.state == "waiting" else view.towards
    beside_rad = _BESIDE_RAD if progress.company.last_look is None else 0.0
    if wanted is not None and (towards is None or abs(wrap_angle(wanted - towards)) > beside_rad):
        towards = wanted
    if progress.state in AT_HOME and unseen:
        towards = progress.towards  # visitors follow only while it leads
    if view.docked:
        towards = None  # nothing turns in a dock
    slow = progress.slow
    if view.people > 0:
        slow = view.farthest_m > falls_behind_m(progress.company, tour.pace) * (_CLOSER if slow else 1.0)
    invites = progress.invites or not enough
    company = noted(progress.company, view, tour.pace, counts=progress.state in _COUNTS)
    after = replace(progress, near_since=near_since, gone_since=gone, invites=invites, company=company, slow=slow)
    return replace(after, towards=towards, stuck_since=view.stuck_since)
