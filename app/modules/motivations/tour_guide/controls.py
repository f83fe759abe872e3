"""What can be pressed in each state, and what the operator is asked. Pure functions."""

from __future__ import annotations

from collections.abc import Iterator

from app.messages import OperatorQuestion
from app.modules.motivations.tour_guide.entering import AT_A_STOP, ON_THE_WAY, subject_of
from app.modules.motivations.tour_guide.passing_time import LONGEST_PAUSE_S
from app.modules.motivations.tour_guide.progress import Button, Progress
from app.modules.motivations.tour_guide.wishes import Scene, stop_of
from app.tours.model import rules_at

_DEFAULTS = {
    "skip": "the stop is skipped",
    "present_from_here": "the stop is presented from here",
    "end": "the tour ends",
}


def buttons(progress: Progress, *, e_stop: bool) -> tuple[Button, ...]:
    """The buttons that do something now."""
    return tuple(_buttons(progress, e_stop))


def _buttons(progress: Progress, e_stop: bool) -> Iterator[Button]:
    state, subject = progress.state, subject_of(progress)
    if state == "idle":
        # Visitors' phones have "start", too: it does not free a robot that the emergency stop holds.
        if not progress.held:
            yield "start"
        elif not e_stop:
            yield "resume"
        return
    if state == "confirming":
        yield "agree"
    if state in ("inviting", "confirming"):
        yield "decline"
    if state == "listening":
        yield "next"
    if state == "blocked":
        yield "retry"
    if state == "paused":
        if not e_stop:
            yield "resume"
    else:
        yield "pause"
    if state in AT_A_STOP:
        yield "repeat"
    if subject in ON_THE_WAY | AT_A_STOP:
        yield "skip"
        if progress.skipped:
            yield "undo_skip"
    if subject not in ("parting", "going_home") or (state == "paused" and progress.to_press):
        yield "end"


def operator_question(progress: Progress, scene: Scene) -> OperatorQuestion | None:
    """What the operator is asked, with what is done without an answer and when; None for nothing."""
    stop = stop_of(progress, scene.tour) if scene.tour.stops else None
    if progress.state == "blocked" and stop is not None:
        rule = rules_at(scene.tour, stop).reach
        text = f"The way to {stop.id} is blocked. Try again, or skip it?"
        return OperatorQuestion(text, ("retry", "skip", "end"), _DEFAULTS[rule.then], progress.since + rule.ask_s)
    if progress.state == "paused" and progress.to_press:
        text = f"The tour is paused: {progress.reason}. Go on, or end it?"
        return OperatorQuestion(text, ("resume", "end"), "the tour ends where it is", progress.since + LONGEST_PAUSE_S)
    return None
