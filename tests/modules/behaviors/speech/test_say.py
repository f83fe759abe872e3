"""Say: texts of desires, said in their order by sentences, interrupted and ended."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

import numpy as np
import pytest

from app.attention.desires import DesireClasses, InvalidDesire, Source
from app.attention.emotions import EMOTIONS
from app.attention.workspace import IntentionWorkspace
from app.messages import (
    Accomplishment,
    Audio,
    EmotionState,
    Exploitation,
    ShownEmotion,
    SoundSource,
    SoundSources,
    Speech,
    Twist,
)
from app.modules.behaviors.speech.feeling import MANNERS, MOST_CHANGE, manner_of
from app.modules.behaviors.speech.say import SAY
from app.runtime.clock import VirtualClock, run_virtual
from app.speech.config import EspeakConfig
from app.speech.estimate import estimated_mouth, estimated_words
from app.speech.manner import USUAL, Manner
from app.speech.utterance import SpeechError, Utterance
from tests.modules.fakes import Bench, drain

MODULE = "app.modules.behaviors.speech.say:Say"
RATE = 8000
LETTER_S = 0.05
T = TypeVar("T")


class Tone:
    """An engine whose samples are all 1000; a letter takes 50 ms. It knows no French, and notes how it is to speak."""

    def __init__(self) -> None:
        self.manners: list[tuple[str, Manner]] = []

    def synthesize(self, text: str, language: str, manner: Manner = USUAL) -> Utterance:
        if language == "fr":
            raise SpeechError("no French here")
        self.manners.append((text, manner))
        duration_s = LETTER_S * len(text)
        words = estimated_words(text, duration_s)
        samples = np.full(round(RATE * duration_s), 1000, np.int16)
        mouth = estimated_mouth(text, words)
        return Utterance(text, samples, RATE, duration_s=duration_s, words=words, mouth=mouth)


class Stage:
    """Say on its bench, with a workspace."""

    def __init__(self, bench: Bench, workspace: IntentionWorkspace) -> None:
        self.bench = bench
        self.workspace = workspace
        self.audio = bench.listen("audio", capacity=10_000)
        self.speech = bench.listen("speech", capacity=10_000)

    def say(self, text: str, **params: Any) -> str:
        source = Source("rest", "test")
        return self.workspace.add("Say", intensity=5, utility=5, params={"text": text, **params}, source=source).id

    async def wait(self, seconds: float) -> None:
        await self.bench.clock.sleep(seconds)

    def said(self) -> list[str]:
        """The sentences started since the last call."""
        said: list[str] = []
        for speech in drain(self.speech):
            new = speech.state == "speaking" and (not said or said[-1] != speech.text)
            if new:
                said.append(speech.text)
        return said


@pytest.fixture(autouse=True)
def tone(monkeypatch: pytest.MonkeyPatch) -> Tone:
    engine = Tone()
    monkeypatch.setattr(EspeakConfig, "make", lambda _: engine)
    return engine


def on_stage(script: Callable[[Stage], Awaitable[T]], *, followed: bool = True, **settings: Any) -> T:
    async def main() -> T:
        workspace = IntentionWorkspace(DesireClasses([SAY]), VirtualClock().now)
        bench = Bench(
            MODULE,
            inputs={"exploitation": Exploitation, "sources": SoundSources, "emotions": EmotionState},
            outputs={"audio": Audio, "speech": Speech, "accomplishments": Accomplishment},
            settings=settings,
            services={IntentionWorkspace: workspace},
            attended=("audio",),
        )
        if followed:
            bench.graph.channel("accomplishments").observe(workspace.accomplish)
        async with bench:
            bench.graph.filters.apply({"Tested.audio": 1})
            result = await script(Stage(bench, workspace))
        assert bench.problem == ""
        return result

    return run_virtual(main())


def test_a_text_is_said_by_sentences_and_its_desire_ends() -> None:
    async def script(stage: Stage) -> None:
        desire = stage.say("One two. Three!")
        await stage.wait(2.0)
        assert stage.workspace.desires() == ()
        report = stage.workspace.report(desire)
        assert (report.outcome, report.behavior, report.reason) == ("done", "Tested", "")
        frames = drain(stage.audio)
        assert sum(len(frame.samples) for frame in frames) == RATE * LETTER_S * len("One two.Three!")
        assert all(frame.samples.shape[1] == 1 and len(frame.samples) <= 0.04 * RATE for frame in frames)
        starts = [frame.first_sample for frame in frames]
        assert starts == list(np.cumsum([0, *(len(frame.samples) for frame in frames[:-1])]))
        speech = drain(stage.speech)
        words = [s.text[s.word_begin : s.word_end] for s in speech if s.state == "speaking"]
        assert list(dict.fromkeys(word for word in words if word)) == ["One", "two.", "Three!"]
        assert {s.viseme for s in speech} >= {"closed", "round"}
        assert (speech[-1].state, speech[-1].desire, speech[-1].waiting) == ("silent", "", 0)

    on_stage(script)


def test_frames_come_at_the_loudspeakers_pace() -> None:
    async def script(stage: Stage) -> None:
        stage.say("a" * 60)
        await stage.wait(1.0)
        sent_s = sum(len(frame.samples) for frame in drain(stage.audio)) / RATE
        assert 1.0 < sent_s < 1.0 + 0.15 + 0.04 + 0.001

    on_stage(script)


def test_without_an_intention_nothing_is_said() -> None:
    async def script(stage: Stage) -> None:
        stage.bench.graph.filters.apply({"Tested.audio": float("inf")})
        stage.say("Hello.")
        await stage.wait(2.0)
        assert len(stage.workspace.desires()) == 1
        assert drain(stage.audio) == []
        stage.bench.graph.filters.apply({"Tested.audio": 1})
        await stage.wait(2.0)
        assert stage.workspace.desires() == ()

    on_stage(script)


def test_removing_the_desire_silences_it() -> None:
    async def script(stage: Stage) -> None:
        desire = stage.say("a" * 100)
        await stage.wait(1.0)
        stage.workspace.remove(desire)
        await stage.wait(0.03)
        drain(stage.audio)
        await stage.wait(2.0)
        assert drain(stage.audio) == []
        assert drain(stage.speech)[-1].state == "silent"

    on_stage(script)


def test_a_text_is_said_once_though_nothing_ends_its_desire() -> None:
    async def script(stage: Stage) -> None:
        stage.say("Hello.")
        stage.say("World.")
        await stage.wait(5.0)
        assert stage.said() == ["Hello.", "World."]
        assert len(stage.workspace.desires()) == 2

    on_stage(script, followed=False)


def test_an_interrupted_text_goes_on_at_its_sentence() -> None:
    async def script(stage: Stage) -> None:
        stage.say("First one. Second one.")
        await stage.wait(0.7)
        stage.say("Fire!", priority=9)
        await stage.wait(0.5)
        stage.say("Last.")
        await stage.wait(3.0)
        assert stage.said() == ["First one.", "Second one.", "Fire!", "Second one.", "Last."]

    on_stage(script)


def test_what_is_not_interruptible_is_said_to_its_end() -> None:
    async def script(stage: Stage) -> None:
        stage.say("Firm words.", interruptible=False)
        await stage.wait(0.2)
        stage.say("Fire!", priority=9)
        await stage.wait(3.0)
        assert stage.said() == ["Firm words.", "Fire!"]

    on_stage(script)


def test_it_waits_while_another_is_heard() -> None:
    async def script(stage: Stage) -> None:
        now = stage.bench.clock.now
        stage.say("One. Two.")
        await stage.wait(0.1)
        for _ in range(20):
            stage.bench.feed("exploitation", Exploitation(now(), "Operator", Twist(now(), 0, 0), group="voice"))
            await stage.wait(0.1)
        drain(stage.audio)
        assert stage.said() == ["One."]
        stage.bench.feed("exploitation", Exploitation(now(), "Say", Twist(now(), 0, 0), group="voice"))
        await stage.wait(2.0)
        assert stage.said() == ["One.", "Two."]

    on_stage(script)


def test_it_yields_to_a_person_who_talks() -> None:
    async def script(stage: Stage) -> None:
        stage.say("a" * 100)
        await stage.wait(0.5)
        for _ in range(20):
            person = SoundSource(
                1, (1.0, 0.0, 0.0), power=1.0, level_db=-30.0, active=True, speech=0.9, range_m=1.0, range_sigma_m=0.3
            )
            stage.bench.feed("sources", SoundSources(stage.bench.clock.now(), (0.0, 0.0, 1.0), (person,)))
            await stage.wait(0.05)
        await stage.wait(0.2)
        assert drain(stage.speech)[-1].state == "silent"
        assert len(stage.workspace.desires()) == 1
        await stage.wait(7.0)
        assert stage.workspace.desires() == ()

    on_stage(script, barge_in_s=0.4, resume_s=0.5)


def test_what_the_engine_cannot_say_is_shown(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING, "hbba.Tested")

    async def script(stage: Stage) -> None:
        desire = stage.say("Bonjour. Merci.", language="fr")
        await stage.wait(5.0)
        assert stage.said() == ["Bonjour.", "Merci."]
        assert drain(stage.audio) == []
        assert stage.workspace.desires() == ()
        report = stage.workspace.report(desire)
        assert (report.outcome, report.reason) == ("failed", "no French here; it is shown in writing alone")

    on_stage(script)
    assert [record.message for record in caplog.records] == ["no French here; it is shown in writing alone"]


def test_a_language_has_its_own_engine() -> None:
    async def script(stage: Stage) -> None:
        stage.say("Bonjour.", language="fr-ca", volume=0.5)
        await stage.wait(5.0)
        assert {int(value) for frame in drain(stage.audio) for value in np.unique(frame.samples)} == {500}

    on_stage(script, engine={"engine": "text"}, engines={"fr": {"engine": "espeak"}})


def test_a_sentence_is_spoken_in_the_manner_of_the_emotion_that_shows(tone: Tone) -> None:
    async def script(stage: Stage) -> None:
        def feel(shown: ShownEmotion | None) -> None:
            stage.bench.feed("emotions", EmotionState(0.0, (), modulates=False, shows=True, shown=shown))

        for text, shown in (
            ("One.", None),
            ("Two.", ShownEmotion("sadness", 0.5)),
            ("Three.", ShownEmotion("joy", 1.0)),
            ("Four.", None),
        ):
            feel(shown)
            await stage.wait(0.1)
            stage.say(text)
            await stage.wait(1.0)

    on_stage(script)
    one, two, three, four = (manner for _, manner in tone.manners)
    assert one == four == USUAL
    assert (two.rate, two.pitch) == (pytest.approx(0.95), pytest.approx(0.975))
    assert three == MANNERS["joy"]


def test_no_emotion_changes_the_manner_of_speaking_by_much() -> None:
    for emotion in EMOTIONS:
        steps = [manner_of(ShownEmotion(emotion, strength / 4)) for strength in range(7)]
        assert steps[0] == USUAL
        assert steps[1] != USUAL
        assert steps[4:] == [MANNERS[emotion]] * 3, "a strength over 1 is 1"
        for value in (getattr(manner, name) for manner in steps for name in ("rate", "pitch")):
            assert abs(value - 1.0) <= MOST_CHANGE + 1e-9


@pytest.mark.parametrize(
    ("params", "field"),
    [({"text": "..."}, "params.text"), ({"text": "a", "language": "English"}, "params.language"), ({}, "params.text")],
)
def test_a_desire_without_words_is_refused(params: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidDesire) as refused:
        SAY.validated(params)
    assert refused.value.field == field
