"""Words by which visitors steer the tour: what each says, and when it is listened for. Pure functions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from app.modules.motivations.tour_guide.entering import AT_A_STOP, ON_THE_WAY
from app.modules.motivations.tour_guide.progress import Button, Chosen, Pressed, Progress
from app.tours.model import Tour
from app.tours.values import Words

#: What can be said in a pause that visitors asked for.
_IN_A_PAUSE: Final = frozenset({"resume", "end"})


def commands_now(progress: Progress, tour: Tour) -> Iterator[tuple[Words, Pressed | Chosen]]:
    """The words that steer ``tour`` in this state, with what they do.

    Words end only a pause that was asked for by words: not one of the operator's, and none by the emergency stop.
    """
    if progress.state == "paused":
        if progress.pause_spoken:
            yield from (each for each in _buttons(tour) if each[1].button in _IN_A_PAUSE)
    elif progress.state in ON_THE_WAY | AT_A_STOP:
        yield from (each for each in _buttons(tour) if each[1].button != "resume")
        yield from ((stop.words, Chosen(stop.id)) for stop in tour.stops if not stop.left_out)


def among(phrase: str, words: Words) -> bool:
    """Whether ``phrase`` is one of ``words``, in any language and case."""
    return any(phrase.lower() == each.lower() for phrases in words.values() for each in phrases)


def _buttons(tour: Tour) -> Iterator[tuple[Words, Pressed]]:
    words = tour.commands
    buttons: tuple[Button, ...] = ("pause", "resume", "skip", "undo_skip", "repeat", "end")
    for button in buttons:
        yield getattr(words, button), Pressed(button)
