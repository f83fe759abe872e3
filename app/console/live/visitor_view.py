"""How a tour goes, for its visitors: what concerns the operator alone is left out. Pure."""

from __future__ import annotations

from app.console.live.messages import VisitorButton, VisitorView
from app.messages import TourProgress
from app.speech.text_spans import sentences_of
from app.tours.model import Tour

_BUTTONS: tuple[VisitorButton, ...] = ("start", "agree", "decline", "next")
NOTHING = VisitorView(
    False, {}, "", (), state="idle", stop_title={}, number=0, stops=0, sentences={}, sentence=0, said="", shown=None,
    press={}, questions=(), buttons=(),
)  # fmt: skip


def is_open(progress: TourProgress | None) -> bool:
    """Whether visitors have something to see: a tour is led, or waits for them."""
    return progress is not None and progress.tour != "" and (progress.waits or progress.state != "idle")


def is_another_run(before: TourProgress | None, now: TourProgress) -> bool:
    """Whether ``now`` is of another run than ``before``: the end of a run begins the next one of a tour that waits."""
    if not is_open(before) or before is None or before.tour != now.tour:
        return True
    return before.state != "idle" and now.state == "idle"


def visitor_view(progress: TourProgress | None, said: str, tour: Tour | None) -> VisitorView:
    """What visitors see of ``progress`` of ``tour`` while the robot says ``said`` (empty: nothing)."""
    if progress is None or not is_open(progress):
        return NOTHING
    sentences = {language: _sentences(text) for language, text in progress.text.items()}
    beside = said not in sentences.get(progress.language, ()) if said else False
    return VisitorView(
        True,
        progress.title,
        progress.language,
        progress.languages,
        state=progress.state,
        stop_title=progress.stop_title,
        number=progress.number,
        stops=progress.stops,
        sentences=sentences,
        sentence=progress.sentence,
        said=said if beside else "",
        shown=progress.shown,
        press=progress.press,
        questions=progress.questions,
        buttons=visitor_buttons(progress, tour),
    )


def visitor_buttons(progress: TourProgress, tour: Tour | None) -> tuple[VisitorButton, ...]:
    """What a visitor may press: only what does something now, and what the tour's author waits for."""
    waits_for: dict[VisitorButton, bool] = {
        "start": progress.waits and tour is not None and "press" in tour.begin.by,
        "agree": True,
        "decline": progress.state == "confirming",
        "next": bool(progress.press),
    }
    return tuple(button for button in _BUTTONS if button in progress.buttons and waits_for[button])


def _sentences(text: str) -> tuple[str, ...]:
    return tuple(text[begin:end] for begin, end in sentences_of(text))
