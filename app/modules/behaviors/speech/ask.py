"""Ask: the behavior that asks a question and reports the answer.

    ┌──────────────────────────────────────────────────────────────────────────────────────────────┐
    │ Ask    in   words            HeardWords, while a question is open                            │
    │        out  accomplishments  Accomplishment, with the answer or why there is none            │
    │        writes desires of the classes Say and ListenForWords into the Intention Workspace     │
    └──────────────────────────────────────────────────────────────────────────────────────────────┘

Each desire of class Ask is a question and the words that may answer it, the oldest first. The question is said, and
then its words are listened for. Where nothing is heard, or what is heard is unsure, it is asked again, at most
``again`` times: an answer is never guessed. Then the desire has failed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import Desire, DesireClass, Source
from app.attention.workspace import IntentionWorkspace, UnknownDesire
from app.messages import Accomplished, HeardWords
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.runtime.module import Caution, Module, ModuleContext, Settings
from app.speech.config import Language

SAY, LISTEN = "Say", "ListenForWords"
_BEAT_S = 0.1


class AskSettings(Settings):
    """Settings of Ask."""

    again: int = Field(2, ge=0, le=5, description="a question is asked again so often")
    not_understood: str = Field("I did not understand.", description="said before it is asked again; empty: nothing")
    not_heard: str = Field("I did not hear you.", description="the same, where nobody answered; empty: nothing")


class AskParameters(BaseModel):
    """Parameters of a desire of class Ask."""

    model_config = ConfigDict(extra="forbid", title="Ask", allow_inf_nan=False)

    question: str = Field(min_length=1, max_length=500, title="Question", description="What to ask.")
    words: str = Field(
        "yes, no", max_length=500, title="Answers", description="Words that may answer it, with commas between them."
    )
    language: Language = Field("en", title="Language", description="Of question and answers: a tag, as en.")
    wait_s: float = Field(10.0, ge=2, le=120, title="Wait", description="For an answer, each time it is asked, in s.")


ASK = DesireClass(
    name="Ask",
    title="Ask a question",
    description="Say a question and listen for one of a few words; the desire ends with the answer.",
    parameters=AskParameters,
    achievement=True,
)


@dataclass(slots=True)
class _Dialogue:
    """A question under way: ``tries`` so far; ``step`` is the desire, of Say or ListenForWords, that is waited for."""

    desire: Desire
    tries: int
    step: Desire


class Ask(Module):
    """Asks the desired questions, one at a time."""

    title = "Questions"
    desire_classes = (ASK,)
    Settings = AskSettings
    settings: AskSettings

    _workspace: IntentionWorkspace

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.words = self.input("words", HeardWords, capacity=8)
        self._accomplishments = AccomplishmentReporter(self, ASK.name)
        self.on(self.words, self._take_words)
        self.every(_BEAT_S, self._beat)
        self._dialogue: _Dialogue | None = None
        self._answered: set[str] = set()

    async def start(self) -> None:
        """Look up the workspace."""
        self._workspace = self.service(IntentionWorkspace)

    async def stop(self) -> None:
        """Withdraw what the question under way made desired."""
        self._leave()

    def cautions(self) -> tuple[Caution, ...]:
        return self._accomplishments.cautions()

    async def _beat(self) -> None:
        asked = [d for d in self._workspace.desires() if d.cls == ASK.name and d.utility > 0]
        self._answered &= {desire.id for desire in asked}
        if self._dialogue is not None and self._dialogue.desire not in asked:
            self._leave()
        if self._dialogue is None:
            waiting = next((desire for desire in asked if desire.id not in self._answered), None)
            if waiting is not None and self.words.connected and self.words.subscription.filter.is_open:
                self._say(waiting, 0, "")
        elif not self._stands(self._dialogue.step):
            self._go_on(self._dialogue)

    def _go_on(self, dialogue: _Dialogue) -> None:
        """The step is over: the question has been said, or nobody answered."""
        if dialogue.step.cls == LISTEN:
            self._ask_again(dialogue, self.settings.not_heard, "no answer was heard")
        elif self._outcome(dialogue.step) in ("done", "failed"):  # failed: it is shown in writing
            self._listen(dialogue)
        else:
            self._report(dialogue, "failed", "the question was not said: its desire was withdrawn")

    async def _take_words(self, heard: HeardWords) -> None:
        dialogue = self._dialogue
        if dialogue is None or dialogue.step.cls != LISTEN or heard.stamp < dialogue.step.created:
            return
        if heard.unsure:
            self._ask_again(dialogue, self.settings.not_understood, "the answer was not understood")
        else:
            self._report(dialogue, "done", heard.text)

    def _ask_again(self, dialogue: _Dialogue, remark: str, problem: str) -> None:
        if dialogue.tries < self.settings.again:
            self._leave()
            self._say(dialogue.desire, dialogue.tries + 1, remark)
        else:
            self._report(dialogue, "failed", f"{problem}, asked {_times(dialogue.tries + 1)}")

    def _say(self, desire: Desire, tries: int, remark: str) -> None:
        text = f"{remark} {desire.params['question']}".strip()
        step = self._desire(desire, SAY, {"text": text, "language": desire.params["language"]}, None)
        self._dialogue = _Dialogue(desire, tries, step)

    def _listen(self, dialogue: _Dialogue) -> None:
        params = {key: dialogue.desire.params[key] for key in ("words", "language")}
        dialogue.step = self._desire(dialogue.desire, LISTEN, params, dialogue.desire.params["wait_s"])

    def _desire(self, asked: Desire, cls: str, params: dict[str, Any], ttl: float | None) -> Desire:
        return self._workspace.add(
            cls,
            intensity=asked.intensity,
            utility=asked.utility,
            source=Source("motivation", self.name),
            params=params,
            ttl=ttl,
        )

    def _report(self, dialogue: _Dialogue, outcome: Accomplished, reason: str) -> None:
        self._leave()
        self._answered.add(dialogue.desire.id)
        self._accomplishments.report(outcome, reason, lambda desire: desire.id == dialogue.desire.id)

    def _leave(self) -> None:
        """End the question under way, and withdraw what it made desired."""
        if self._dialogue is not None and self._stands(self._dialogue.step):
            self._workspace.remove(self._dialogue.step.id)
        self._dialogue = None

    def _stands(self, desire: Desire) -> bool:
        return any(other.id == desire.id for other in self._workspace.desires())

    def _outcome(self, desire: Desire) -> str | None:
        try:
            return self._workspace.report(desire.id).outcome
        except UnknownDesire:
            return None


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
