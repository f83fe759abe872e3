"""Say: the behavior that says what is desired to be said.

    ┌──────────────────────────────────────────────────────────────────────────────────────────────┐
    │ Say    in   exploitation     Exploitation of the voice: another that is heard; may be absent │
    │        in   sources          SoundSources: who talks meanwhile; may be absent                │
    │        in   emotions         EmotionState: what shows changes the manner; may be absent      │
    │        out  audio            Audio, one channel, frames of 40 ms as they are played          │
    │        out  speech           Speech, with each change of word, mouth or state                │
    │        out  accomplishments  Accomplishment, when a text has been said                       │
    └──────────────────────────────────────────────────────────────────────────────────────────────┘

Each desire of class Say is a text; the queue (``speech_queue.py``) decides which is said. It is said sentence by
sentence while attention has the output ``audio`` open. A sentence that was interrupted (by a text of greater priority,
by another behavior at the loudspeaker, by a person, by attention) is said again from its beginning. A desire whose text
has been said is done, or has failed where no engine could say it; removing a desire silences it. The emotion that shows
as a sentence is made changes its manner a little (``feeling.py``).
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator

from app.attention.desires import DesireClass
from app.attention.workspace import IntentionWorkspace
from app.messages import (
    Accomplished,
    Audio,
    EmotionState,
    Exploitation,
    ShownEmotion,
    SoundSources,
    Speech,
    read_only,
)
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.speech.barge_in import BargeIn
from app.modules.behaviors.speech.feeling import manner_of
from app.modules.behaviors.speech.playback import UtterancePlayback
from app.modules.behaviors.speech.speech_queue import SpeechRequest, next_request
from app.runtime.module import Caution, Module, ModuleContext, Settings
from app.speech.config import EngineConfig, EspeakConfig, Language
from app.speech.manner import Manner
from app.speech.text_only import TextOnly
from app.speech.text_spans import sentences_of
from app.speech.utterance import SpeechEngine, SpeechError, Utterance
from app.speech.visemes import Viseme

_BEAT_S = 0.02
#: Greatest age (s) of the report of who is heard.
_FRESH_S = 0.5
_NOWHERE = read_only(np.zeros((0, 3)))


class SayParameters(BaseModel):
    """Parameters of a desire of class Say."""

    model_config = ConfigDict(extra="forbid", title="Say", allow_inf_nan=False)

    text: str = Field(min_length=1, max_length=2000, title="Text", description="What to say.")
    language: Language | None = Field(
        None, title="Language", description="Its tag, as en or fr; none: the robot's usual one."
    )
    priority: int = Field(5, ge=0, le=10, title="Priority", description="The greatest is said first, 0 to 10.")
    interruptible: bool = Field(
        True, title="Interruptible", description="Whether a greater priority, or a person who talks, interrupts it."
    )
    volume: float = Field(1.0, gt=0, le=1, title="Volume", description="Share of the engine's loudness, 0 to 1.")

    @field_validator("text")
    @classmethod
    def _has_words(cls, text: str) -> str:
        if not sentences_of(text):
            raise ValueError("must have a letter or a digit")
        return text


#: What can be desired of it.
SAY = DesireClass(
    name="Say",
    title="Say something",
    description="Say a text through the loudspeaker, with subtitles; the desire ends when it has been said.",
    parameters=SayParameters,
    achievement=True,
)


class SaySettings(Settings):
    """Settings of Say."""

    engine: EngineConfig = Field(EspeakConfig(engine="espeak"), description="what speaks")
    engines: Mapping[Language, EngineConfig] = Field(
        default_factory=dict, description="what speaks a language that `engine` is not for, by its tag"
    )
    language: Language = Field("en", description="of texts whose desire names none")
    behavior: str = Field("Say", description="this behavior's name at the loudspeaker")
    ahead_s: float = Field(0.15, ge=0.04, le=0.4, description="so much waits at the loudspeaker, against gaps")
    latency_s: float = Field(0.05, ge=0, le=1, description="from a frame's sending to its sound: for words and mouth")
    barge_in_s: float | None = Field(
        None, gt=0, le=5, description="a person who talks for so long interrupts what is interruptible; none: never"
    )
    resume_s: float = Field(1.0, ge=0, le=10, description="... until so long after their last word")
    voice: float = Field(0.6, ge=0, le=1, description="a source at least this probably speech is a person who talks")


@dataclass(slots=True)
class _Progress:
    """How far a text has been said: ``next`` of its ``sentences``. ``problem``: why one was shown in writing alone."""

    request: SpeechRequest
    sentences: tuple[str, ...]
    next: int = 0
    problem: str = ""

    @property
    def over(self) -> bool:
        return self.next >= len(self.sentences)


class Say(Module):
    """Says the desired texts, one at a time."""

    title = "Speech"
    desire_classes = (SAY,)
    Settings = SaySettings
    settings: SaySettings

    _workspace: IntentionWorkspace

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.exploitation = self.input("exploitation", Exploitation, wants="never")
        self.sources = self.input("sources", SoundSources, wants="never")
        self.emotions = self.input("emotions", EmotionState, wants="never")
        self.audio = self.output("audio", Audio)
        self.speech = self.output("speech", Speech)
        self._accomplishments = AccomplishmentReporter(self, SAY.name)
        self.on(self.exploitation, self._take_exploitation)
        self.on(self.sources, self._take_sources)
        self.on(self.emotions, self._take_emotions)
        self.every(_BEAT_S, self._beat)
        self._engine = self.settings.engine.make()
        self._engines = {language: config.make() for language, config in self.settings.engines.items()}
        self._heard: Exploitation | None = None
        self._feeling: ShownEmotion | None = None
        self._barge_in = BargeIn(self.settings.barge_in_s, self.settings.resume_s)
        #: Texts of which something was said, by the id of their desire.
        self._progress: dict[str, _Progress] = {}
        self._current: _Progress | None = None
        self._playback: UtterancePlayback | None = None
        #: The synthesis of the current text's sentence of that number.
        self._synthesis: tuple[int, asyncio.Task[tuple[Utterance, str]]] | None = None
        self._problems: set[str] = set()
        self._samples = 0
        self._shown: Speech | None = None

    async def start(self) -> None:
        """Look up the workspace."""
        self._workspace = self.service(IntentionWorkspace)

    async def stop(self) -> None:
        """End the synthesis."""
        self._leave()

    def cautions(self) -> tuple[Caution, ...]:
        return self._accomplishments.cautions()

    async def _take_exploitation(self, exploitation: Exploitation) -> None:
        self._heard = exploitation

    async def _take_sources(self, heard: SoundSources) -> None:
        voice = any(source.active and source.speech >= self.settings.voice for source in heard.sources)
        self._barge_in.hear(heard.stamp, voice)

    async def _take_emotions(self, state: EmotionState) -> None:
        self._feeling = state.shown

    async def _beat(self) -> None:
        now = self.clock.now()
        requests = {request.desire: request for request in self._requests()}
        self._progress = {key: known for key, known in self._progress.items() if requests.get(key) == known.request}
        requests = {
            key: each for key, each in requests.items() if key not in self._progress or not self._progress[key].over
        }
        chosen = self._chosen(requests, now)
        if (None if self._current is None else self._current.request) != chosen:
            self._turn_to(chosen)
        if self._current is not None:
            self._go_on(self._current, now)
        self._show(now, len(requests))

    def _requests(self) -> Iterator[SpeechRequest]:
        for desire in self._workspace.desires():
            if desire.cls == SAY.name and desire.utility > 0:
                params = desire.params
                yield SpeechRequest(
                    desire.id,
                    params["text"],
                    params["language"] or self.settings.language,
                    priority=params["priority"],
                    interruptible=params["interruptible"],
                    volume=params["volume"],
                    created=desire.created,
                )

    def _chosen(self, requests: Mapping[str, SpeechRequest], now: float) -> SpeechRequest | None:
        if not self.audio.filter.is_open or self._another_is_heard(now):
            return None
        chosen = next_request(requests.values(), None if self._current is None else self._current.request.desire)
        if chosen is not None and chosen.interruptible and self._barge_in.yields(now):
            return None
        return chosen

    def _another_is_heard(self, now: float) -> bool:
        heard = self._heard
        if heard is None or now - heard.stamp > _FRESH_S:
            return False
        return heard.behavior not in (None, self.settings.behavior)

    def _turn_to(self, request: SpeechRequest | None) -> None:
        """Leave the current sentence, if any, for ``request``."""
        self._leave()
        if request is None:
            return
        text = request.text
        fresh = _Progress(request, tuple(text[begin:end] for begin, end in sentences_of(text)))
        self._current = self._progress.setdefault(request.desire, fresh)

    def _leave(self) -> None:
        self._current = self._playback = None
        if self._synthesis is not None:
            self._synthesis[1].cancel()
            self._synthesis = None

    def _go_on(self, current: _Progress, now: float) -> None:
        if self._playback is not None and now >= self._playback.ends + self.settings.latency_s:
            self._playback = None
            current.next += 1
        if current.over:
            self._leave()
            outcome: Accomplished = "failed" if current.problem else "done"
            self._accomplishments.report(outcome, current.problem, lambda d: d.id == current.request.desire)
            return
        if self._playback is None:
            made = self._synthesized(current, current.next)
            if made is None:
                return
            self._playback = UtterancePlayback(made, now, current.request.volume)
        if current.next + 1 < len(current.sentences):
            self._synthesized(current, current.next + 1)
        for samples in self._playback.frames_until(now + self.settings.ahead_s):
            self._publish(samples, self._playback.utterance.rate, now)

    def _synthesized(self, current: _Progress, number: int) -> Utterance | None:
        """Sentence ``number`` as sound; None while it is being made."""
        if self._synthesis is None or self._synthesis[0] != number:
            language = current.request.language
            engine = self._engines.get(language) or self._engines.get(language.partition("-")[0], self._engine)
            making = self.compute(_synthesize, engine, current.sentences[number], language, manner_of(self._feeling))
            self._synthesis = number, asyncio.create_task(making, name=f"{self.name} synthesis")
        task = self._synthesis[1]
        if not task.done():
            return None
        utterance, problem = task.result()
        if problem:
            current.problem = f"{problem}; it is shown in writing alone"
        if problem and problem not in self._problems:
            self._problems.add(problem)
            self.log.warning("%s", current.problem)
        return utterance

    def _publish(self, samples: np.ndarray[tuple[int, int], np.dtype[np.int16]], rate: int, now: float) -> None:
        self.audio.publish(
            Audio(now, "speech", read_only(samples), rate=rate, first_sample=self._samples, p_BM=_NOWHERE)
        )
        self._samples += len(samples)

    def _show(self, now: float, wanted: int) -> None:
        before = self._shown
        if self._playback is None or self._current is None:
            text = "" if before is None else before.text
            language = self.settings.language if before is None else before.language
            shown = Speech(
                now, "silent", text, 0, 0, viseme=Viseme.CLOSED.value, language=language, desire="", waiting=wanted
            )
        else:
            request, utterance = self._current.request, self._playback.utterance
            begin, end, viseme = self._playback.at(now - self.settings.latency_s)
            shown = Speech(
                now,
                "speaking",
                utterance.text,
                begin,
                end,
                viseme=viseme.value,
                language=request.language,
                desire=request.desire,
                waiting=wanted - 1,
            )
        if before is None or replace(shown, stamp=before.stamp) != before:
            self._shown = shown
            self.speech.publish(shown)


def _synthesize(engine: SpeechEngine, text: str, language: str, manner: Manner) -> tuple[Utterance, str]:
    """The utterance; where the engine cannot, the text alone and the reason."""
    try:
        return engine.synthesize(text, language, manner), ""
    except SpeechError as failure:
        return TextOnly().synthesize(text, language), str(failure)
