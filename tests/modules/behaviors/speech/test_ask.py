"""Ask: the question is said, its words are listened for; what is unsure is asked again, never guessed."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

from app.attention.desires import Desire, DesireClass, DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.messages import Accomplishment, HeardWords
from app.modules.behaviors.speech.ask import ASK
from app.modules.behaviors.speech.say import SAY
from app.modules.perception.word_recognizer import LISTEN_FOR_WORDS
from app.runtime.clock import VirtualClock, run_virtual
from tests.modules.fakes import Bench, drain

T = TypeVar("T")
QUESTION = "Shall I go on?"


class Dialogue:
    """Ask on its bench: what it makes desired is said and heard by the test."""

    def __init__(self, bench: Bench, workspace: IntentionWorkspace) -> None:
        self.bench = bench
        self.workspace = workspace
        self.reports = bench.listen("accomplishments")

    def ask(self, **params: Any) -> str:
        source = Source("rest", "test")
        params = {"question": QUESTION, **params}
        return self.workspace.add("Ask", intensity=5, utility=5, params=params, source=source).id

    async def desired(self, desire_class: DesireClass) -> Desire:
        """The desire of the class, once there is one."""
        while (found := self.workspace.wanted(desire_class.name)) is None:
            await self.bench.clock.sleep(0.05)
        return found

    async def said(self, outcome: Any = "done") -> str:
        """The text that it wants said, which has then been said."""
        desire = await self.desired(SAY)
        self.workspace.accomplish(Accomplishment(self.bench.clock.now(), desire.id, "Say", outcome))
        return str(desire.params["text"])

    async def answer(self, text: str, unsure: bool = False) -> None:
        await self.desired(LISTEN_FOR_WORDS)
        now = self.bench.clock.now()
        heard = HeardWords(
            now,
            "" if unsure else text,
            unsure,
            confidence=0.3 if unsure else 0.95,
            likeliest=text,
            direction=(1.0, 0.0, 0.0),
            words=("yes", "no"),
            language="en",
        )
        self.bench.feed("words", heard)
        await self.bench.settle()

    async def ended(self) -> Accomplishment:
        while not (found := drain(self.reports)):
            await self.bench.clock.sleep(0.05)
        (report,) = found
        assert isinstance(report, Accomplishment)
        return report


def asked(script: Callable[[Dialogue], Awaitable[T]], **settings: Any) -> T:
    async def main() -> T:
        clock = VirtualClock()
        workspace = IntentionWorkspace(DesireClasses([ASK, SAY, LISTEN_FOR_WORDS]), clock.now)
        bench = Bench(
            "app.modules.behaviors.speech.ask:Ask",
            inputs={"words": HeardWords},
            outputs={"accomplishments": Accomplishment},
            settings=settings,
            services={IntentionWorkspace: workspace},
            attended=("words",),
        )
        bench.graph.channel("accomplishments").observe(workspace.accomplish)
        async with bench:
            bench.graph.filters.apply({"Tested.words": 1})
            result = await script(Dialogue(bench, workspace))
        assert bench.problem == ""
        assert not [d for d in workspace.desires() if d.source.kind == "motivation"]
        return result

    return run_virtual(main())


def test_a_question_is_said_and_its_answer_reported() -> None:
    async def script(dialogue: Dialogue) -> None:
        asked = dialogue.ask(words="yes, no", wait_s=8)
        assert await dialogue.said() == QUESTION
        listening = await dialogue.desired(LISTEN_FOR_WORDS)
        assert listening.params == {"words": "yes, no", "language": "en"}
        assert listening.expires == listening.created + 8
        await dialogue.answer("no")
        report = await dialogue.ended()
        assert (report.desire_id, report.outcome, report.reason) == (asked, "done", "no")
        assert dialogue.workspace.desires() == ()

    asked(script)


def test_what_is_unsure_is_asked_again_and_never_guessed() -> None:
    async def script(dialogue: Dialogue) -> None:
        dialogue.ask()
        texts = []
        for _ in range(3):
            texts.append(await dialogue.said())
            await dialogue.answer("yes", unsure=True)
        assert texts == [QUESTION, f"I did not understand. {QUESTION}", f"I did not understand. {QUESTION}"]
        report = await dialogue.ended()
        assert (report.outcome, report.reason) == ("failed", "the answer was not understood, asked 3 times")

    asked(script)


def test_silence_is_asked_again_too_and_then_the_answer_counts() -> None:
    async def script(dialogue: Dialogue) -> None:
        dialogue.ask(wait_s=5)
        await dialogue.said()
        await dialogue.desired(LISTEN_FOR_WORDS)
        await dialogue.bench.clock.sleep(5)
        dialogue.workspace.expire()
        assert await dialogue.said() == f"I did not hear you. {QUESTION}"
        await dialogue.answer("yes")
        assert (await dialogue.ended()).reason == "yes"

    asked(script)


def test_a_question_that_nobody_answers_fails_with_the_reason() -> None:
    async def script(dialogue: Dialogue) -> Accomplishment:
        dialogue.ask(wait_s=5)
        await dialogue.said()
        await dialogue.desired(LISTEN_FOR_WORDS)
        await dialogue.bench.clock.sleep(5)
        dialogue.workspace.expire()
        return await dialogue.ended()

    report = asked(script, again=0)
    assert (report.outcome, report.reason) == ("failed", "no answer was heard, asked once")


def test_words_before_the_question_was_said_are_no_answer() -> None:
    async def script(dialogue: Dialogue) -> None:
        dialogue.ask()
        await dialogue.desired(SAY)
        heard = HeardWords(
            dialogue.bench.clock.now(),
            "yes",
            False,
            confidence=0.9,
            likeliest="yes",
            direction=(1.0, 0.0, 0.0),
            words=("yes", "no"),
            language="en",
        )
        dialogue.bench.feed("words", heard)
        await dialogue.bench.settle()
        assert drain(dialogue.reports) == []
        await dialogue.said()
        await dialogue.answer("no")
        assert (await dialogue.ended()).reason == "no"

    asked(script)


def test_a_withdrawn_question_is_silenced_and_the_next_one_asked() -> None:
    async def script(dialogue: Dialogue) -> None:
        first, second = dialogue.ask(), dialogue.ask(question="Which room?", words="kitchen, library")
        assert (await dialogue.desired(SAY)).params["text"] == QUESTION
        dialogue.workspace.remove(first)
        while (await dialogue.desired(SAY)).params["text"] != "Which room?":
            await dialogue.bench.clock.sleep(0.05)
        await dialogue.said()
        await dialogue.answer("kitchen")
        report = await dialogue.ended()
        assert (report.desire_id, report.reason) == (second, "kitchen")

    asked(script)


def test_a_question_shown_in_writing_alone_is_listened_for() -> None:
    async def script(dialogue: Dialogue) -> None:
        dialogue.ask()
        await dialogue.said("failed")
        await dialogue.answer("yes")
        assert (await dialogue.ended()).outcome == "done"

    asked(script)
