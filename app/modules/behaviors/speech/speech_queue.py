"""The queue of texts to be said: which one is next, and what interrupts what. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SpeechRequest:
    """A text to be said, of the desire with id ``desire``; ``volume`` in ]0, 1]. The greater ``priority`` is first."""

    desire: str
    text: str
    language: str
    priority: int
    interruptible: bool
    volume: float
    created: float


def next_request(requests: Iterable[SpeechRequest], current: str | None) -> SpeechRequest | None:
    """The request to be said now, while that of the desire ``current`` is being said; None without any.

    The current one goes on, unless it is interruptible and another has a greater priority. Else the greatest priority
    is first, then the oldest.
    """
    waiting = sorted(requests, key=lambda request: (-request.priority, request.created))
    if not waiting:
        return None
    going_on = next((request for request in waiting if request.desire == current), None)
    if going_on is None:
        return waiting[0]
    interrupted = going_on.interruptible and waiting[0].priority > going_on.priority
    return waiting[0] if interrupted else going_on
