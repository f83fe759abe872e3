"""What visitors do beside following, on a guide of paper."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

from app.messages import Speech, TourProgress, TourQuestion
from app.modules.motivations.tour_guide.tour_guide import _NOTHING
from app.rehearsal.replies import VisitorReplies


@dataclass
class Guide:
    """What is pressed and asked; ``progress`` is what it shows."""

    progress: TourProgress
    did: list[str] = field(default_factory=list)

    def press(self, button: str) -> None:
        self.did.append(button)

    def ask(self, question: str) -> None:
        self.did.append(f"ask {question}")


class Channel:
    message_type = Speech

    def observe(self, take: Any) -> Any:
        self.take = take
        return lambda: setattr(self, "take", None)


def said(text: str, desire: str, state: Any = "speaking") -> Speech:
    return Speech(0.0, state, text, 0, 1, viseme="open", language="en", desire=desire, waiting=0)


def test_they_agree_ask_once_go_on_and_let_it_pass() -> None:
    guide, channel, passed, now = Guide(_NOTHING), Channel(), [], [100.0]
    system: Any = SimpleNamespace(
        tour_run=SimpleNamespace(server=guide),
        clock=SimpleNamespace(now=lambda: now[0]),
        graph=SimpleNamespace(channels={"speech": channel}),
    )
    with VisitorReplies(system, lambda: passed.append(1), lambda: 3.0) as replies:
        guide.progress = replace(_NOTHING, state="confirming", buttons=("agree",), since=98.0)
        replies.look()
        assert guide.did == [], "they hesitate"
        now[0] = 101.0
        replies.look()
        asked = (TourQuestion("why", {"en": "Why?"}),)
        listening = replace(_NOTHING, state="listening", stop="one", questions=asked, since=90.0)
        guide.progress = replace(listening, buttons=("next",), press={"en": "On"})
        replies.look()
        replies.look()
        assert guide.did == ["agree", "ask why", "next"]
        guide.progress = listening
        replies.look()
        assert guide.did == ["agree", "ask why", "next"], "nothing is to be pressed"
        channel.take(said("It is warm.", "d1"))
        channel.take(said("Excuse me, may I pass?", "d2"))
        channel.take(said("Excuse me, may I pass?", "d2"))
        assert len(passed) == 1, "once a sentence"
        channel.take(said("", "", "silent"))
        channel.take(said("Excuse me, may I pass?", "d3"))
        assert len(passed) == 2
    assert channel.take is None
