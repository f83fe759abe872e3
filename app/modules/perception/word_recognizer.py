"""WordRecognizer: which of a few words is said, while one of them is waited for.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ WordRecognizer    in   audio   Audio, 2 and more channels, frames of any length; all or  │
    │                                nothing: sound may not be decimated                       │
    │                   in   played  Audio, one channel: what the robot's loudspeaker plays,   │
    │                                numbered as the microphones' samples; may be absent       │
    │                   out  words   HeardWords, one for each utterance                        │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

An utterance is found by the probability of speech in one microphone, and heard by a beam of all of them toward where it
came from (``words/``). A recognizer (``app/speech/recognition.py``) in a process of its own compares it with the words
of the desire ListenForWords. What it is not sure of is reported as unsure, to be asked again. Utterances longer than
``longest_s`` are talk, and not reported; nothing is while the robot itself speaks. No stop may depend on any of this.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator

from app.attention.desires import DesireClass
from app.base.errors import ConfigError
from app.messages import Audio, HeardWords
from app.modules.perception.overruns import Overruns
from app.modules.perception.voices.microphone_array import MicrophoneArray
from app.modules.perception.words.utterance_listener import HeardUtterance, UtteranceListener
from app.runtime.errors import InboxOverflow, ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings
from app.speech.config import Language
from app.speech.recognition import Recognition, RecognitionError, RecognizerConfig
from app.speech.recognition_process import RecognitionProcess

#: Inbox capacity: six seconds of frames, for the start of the recognizer's process.
_CAPACITY = 564
#: Sound (s) that is processed together, and after the robot's own voice that may be its echo.
_BLOCK_S, _ECHO_S = 0.064, 0.3
_MOST_WORDS = 20


def phrases_of(words: str) -> tuple[str, ...]:
    """The words or short phrases of a list with commas, each once, in lower case."""
    return tuple(dict.fromkeys(" ".join(phrase.lower().split()) for phrase in words.split(",") if phrase.strip()))


class WordRecognizerSettings(Settings):
    """Settings of WordRecognizer."""

    recognizer: RecognizerConfig = Field(RecognizerConfig(), description="what recognizes words")
    sure: float = Field(0.8, ge=0, le=1, description="an utterance of less confidence is asked again")
    longest_s: float = Field(2.0, gt=0.3, le=10, description="longer utterances are talk")
    body_m: float = Field(
        0.0, ge=0, le=1, description="radius of the body that the microphones stand on; 0: they hang in free air"
    )


class ListenForWordsParameters(BaseModel):
    """Parameters of a desire of class ListenForWords."""

    model_config = ConfigDict(extra="forbid", title="Listen for words")

    words: str = Field(
        "yes, no",
        max_length=500,
        title="Words",
        description="Words or short phrases, at most 20, with commas between them.",
    )
    language: Language = Field("en", title="Language", description="Their tag, as en.")

    @field_validator("words")
    @classmethod
    def _few(cls, words: str) -> str:
        phrases = phrases_of(words)
        if not 1 <= len(phrases) <= _MOST_WORDS:
            raise ValueError(f"must be 1 to {_MOST_WORDS} words or short phrases with commas between them")
        for phrase in phrases:
            if not all(character.isalpha() or character in " '" for character in phrase):
                raise ValueError(f"must be letters, apostrophes and spaces, not {phrase!r}")
        return words


LISTEN_FOR_WORDS = DesireClass(
    name="ListenForWords",
    title="Listen for words",
    description="Report which of a few words is said to the robot; for as long as a question is open.",
    parameters=ListenForWordsParameters,
)


class WordRecognizer(Module):
    """Listens for the words of the desire in force."""

    title = "Word recognizer"
    desire_classes = (LISTEN_FOR_WORDS,)
    auxiliary_inputs = frozenset({"played"})
    Settings = WordRecognizerSettings
    settings: WordRecognizerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._overruns = Overruns(self.log, self.clock)
        self._recognizer = RecognitionProcess(self.settings.recognizer)
        self._phrases: tuple[str, ...] = ()
        self._language = "en"
        self._listener: UtteranceListener | None = None
        self._p_BM: NDArray[np.float64] | None = None
        self._rate = 0
        self._awaited = -1
        self._waiting: list[NDArray[np.int16]] = []
        self._count = 0
        #: Number of the first sample that the loudspeaker cannot have caused.
        self._own_until = -1
        self._problems: set[str] = set()
        # Read with each frame of the microphones, not on arrival: what was played meanwhile has come before it.
        self.played = self.input("played", Audio, capacity=_CAPACITY, always_open=True, wants="if_wanted")
        self.audio = self.input("audio", Audio, capacity=_CAPACITY, lossless=True)
        self.words = self.output("words", HeardWords)
        self.on(self.audio, self._listen)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the words from the desire."""
        given = ListenForWordsParameters.model_validate(
            {key: parameters[key] for key in ListenForWordsParameters.model_fields if key in parameters}
        )
        wanted = phrases_of(given.words), given.language
        if wanted != (self._phrases, self._language):
            # What was said before the question is no answer to it.
            self._awaited = -1
        self._phrases, self._language = wanted

    async def stop(self) -> None:
        """End the recognizer's process."""
        await self.compute(self._recognizer.close)

    def overflowed(self, port: str, loss: InboxOverflow) -> None:
        """Lost sound is a gap."""
        self._overruns.lost(self.audio, loss)
        self._awaited = -1

    async def _listen(self, audio: Audio) -> None:
        self._overruns.heard()
        listener = await self._listener_for(audio)
        if audio.first_sample != self._awaited or audio.first_sample < self._played_until():
            listener.reset()
            self._waiting, self._count = [], 0
        self._awaited = audio.first_sample + len(audio.samples)
        if audio.first_sample < self._own_until:
            return
        self._waiting.append(audio.samples)
        self._count += len(audio.samples)
        if self._count < _BLOCK_S * audio.rate:
            return
        block, begin = np.concatenate(self._waiting), self._awaited - self._count
        self._waiting, self._count = [], 0
        for utterance in await self.compute(listener.process, block, begin):
            since = audio.first_sample - utterance.begin
            await self._recognize(utterance, audio.stamp - since / audio.rate)

    async def _listener_for(self, audio: Audio) -> UtteranceListener:
        same = self._p_BM is not None and np.array_equal(audio.p_BM, self._p_BM) and audio.rate == self._rate
        if self._listener is None or not same:
            self._p_BM, self._rate, self._awaited = audio.p_BM, audio.rate, -1
            self._listener = await self.compute(self._made, audio)
            # Its process takes a second to start: while a person still thinks.
            await self._recognized(np.zeros(0, np.int16))
        return self._listener

    def _made(self, audio: Audio) -> UtteranceListener:
        try:
            array = MicrophoneArray(audio.p_BM, body_m=self.settings.body_m)
            return UtteranceListener(array, audio.rate, self.settings.longest_s)
        except ValueError as mistake:
            raise ModuleFailed(f"words cannot be heard with these microphones: {mistake}") from None

    def _played_until(self) -> int:
        while self.played.connected and self.played.subscription.waiting:
            played = self.played.subscription.receive_nowait()
            self._own_until = played.first_sample + len(played.samples) + round(_ECHO_S * played.rate)
        return self._own_until

    async def _recognized(self, samples: NDArray[np.int16]) -> Recognition | None:
        """Which of the words it is; None where it is none, or they cannot be recognized."""
        try:
            return await self.compute(self._recognizer.recognize, samples, self._phrases, self._language)
        except RecognitionError as failure:
            if str(failure) not in self._problems:
                self._problems.add(str(failure))
                self.log.warning("%s; until then nothing that is said is understood", failure)
            return None
        except ConfigError as failure:
            raise ModuleFailed(str(failure)) from None

    async def _recognize(self, utterance: HeardUtterance, stamp: float) -> None:
        phrases, language = self._phrases, self._language
        found = await self._recognized(utterance.samples)
        if (phrases, language) != (self._phrases, self._language):
            return
        sure = found is not None and found.confidence >= self.settings.sure
        x, y, z = utterance.direction.tolist()
        self.words.publish(
            HeardWords(
                stamp,
                found.text if found is not None and sure else "",
                not sure,
                confidence=0.0 if found is None else found.confidence,
                likeliest="" if found is None else found.text,
                direction=(x, y, z),
                words=phrases,
                language=language,
            )
        )
