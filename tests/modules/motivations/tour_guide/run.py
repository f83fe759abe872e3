"""A run of a tour for tests: time passes, visitors come and go, and what is desired is done."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from app.modules.motivations.tour_guide.progress import Button, Ended, Event, Pressed, Progress, State, View
from app.modules.motivations.tour_guide.transitions import advance
from app.modules.motivations.tour_guide.wishes import Scene, Wish, wishes
from app.tours.model import Tour
from tests.tours.tours import tour

ACHIEVEMENTS = frozenset({"GoTo", "Say", "PointAt", "Wave"})
#: States in which it may drive.
DRIVES: frozenset[State] = frozenset({"leading", "searching", "going_home"})


def say(text: str) -> dict[str, Any]:
    return {"say": {"en": text}}


def stop(name: str, **more: Any) -> dict[str, Any]:
    return {"id": name, "place": name, "title": {"en": name}, "do": [say(f"This is {name}.")]} | more


#: Two stops; the second listens, and answers a question.
WAIT = {"wait": {"at_most_s": 30, "words": {"en": ["next"]}, "claps": 2, "call": True, "all_left": True}}
QUESTION = {
    "id": "weight",
    "question": {"en": "How heavy?"},
    "words": {"en": ["heavy"]},
    "answer": say("Four kilograms."),
}
LAB = tour(
    home="dock",
    begin={"by": ["press", "face"]},
    greeting={
        "do": [say("Hello.")],
        "confirm": {"ask": {"en": "Shall I?"}, "agree": {"en": ["yes"]}, "decline": {"en": ["no"]}},
    },
    farewell={"do": [say("Goodbye.")]},
    stops=[stop("one"), stop("two", do=[say("This is two."), WAIT], questions=[QUESTION])],
)


class Run:
    """A run of ``tour``; ``view`` is what is seen until it is changed."""

    def __init__(self, tour: Tour = LAB, missing: str = "") -> None:
        names = {each.place for each in tour.stops} | {"dock"} - {missing}
        places = {name: {"x": 1.0, "y": 2.0, "place": name} for name in names - {missing}}
        self.scene = Scene(tour, "en", places, ACHIEVEMENTS)
        self.view = View(100.0, people=2, farthest_m=1.0, near=2, looked_s=9.0)
        self.progress = Progress()
        self.states: list[State] = ["idle"]

    def see(self, *events: Event, after_s: float = 0.1, **changes: Any) -> Run:
        """``after_s`` later, with ``changes`` of what is seen."""
        self.view = replace(self.view, **{"now": self.view.now + after_s, "events": events, **changes})
        self.progress = advance(self.progress, self.view, self.scene)
        if self.progress.state != self.states[-1]:
            self.states.append(self.progress.state)
        return self

    def press(self, button: Button) -> Run:
        return self.see(Pressed(button))

    def wishes(self) -> tuple[Wish, ...]:
        return wishes(self.progress, self.scene, self.view.now)

    def moves(self) -> tuple[Wish, ...]:
        """All wishes but what is said."""
        return tuple(wish for wish in self.wishes() if wish.cls != "Say")

    def wish(self, cls: str) -> Wish:
        """The only wish of this class."""
        (found,) = [wish for wish in self.wishes() if wish.cls == cls]
        return found

    def texts(self) -> list[str]:
        return [wish.params["text"] for wish in self.wishes() if wish.cls == "Say"]

    def done(self, cls: str, done: bool = True, *, only: str = "") -> Run:
        """The desire of this class ends, the one with the name ``only`` of several; then the next state begins."""
        (key,) = [wish.key for wish in self.wishes() if wish.cls == cls and wish.key.endswith(only)]
        return self.see(Ended(key, done)).see()

    def until(self, state: State) -> Run:
        """All that is desired is done, and time passes, until ``state``."""
        for _ in range(1000):
            if self.progress.state == state:
                return self
            ended = [Ended(wish.key, True) for wish in self.wishes() if wish.cls in ACHIEVEMENTS]
            agreed: list[Event] = [Pressed("agree")] if self.progress.state == "confirming" else []
            self.see(*ended, *agreed, after_s=1.0)
        raise AssertionError(f"never {state}: {self.states}")

    def started(self) -> Run:
        return self.press("start")


def changed(**more: Any) -> Tour:
    """The tour of the laboratory with other members."""
    return LAB.model_validate(LAB.model_dump(by_alias=True) | more)
