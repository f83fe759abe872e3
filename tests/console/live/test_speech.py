"""Push-to-talk: one operator at a time speaks through the robot."""

from __future__ import annotations

import pytest

from app.console.live.speech import LATE_S, PAUSE_S, OperatorSpeech
from app.messages import Audio
from app.runtime.channel import Channel
from tests.console.live_client import voice
from tests.console.program import Body


class Now:
    """A clock that a test moves."""

    def __init__(self) -> None:
        self.time = 1000.0

    def now(self) -> float:
        return self.time

    async def sleep(self, seconds: float) -> None: ...

    async def sleep_until(self, deadline: float) -> None: ...


class Floor:
    """Speech, its notices, and what is played."""

    def __init__(self, **options: bool) -> None:
        self.clock = Now()
        self.channel = Channel("operator_voice", Audio, self.clock.now)
        self.spoken: list[Audio] = []
        self.channel.observe(self.spoken.append)
        self.notices: list[tuple[str, str]] = []
        self.speech = OperatorSpeech(
            self.clock, Body(), self.channel, lambda session, _, text: self.notices.append((session, text)), **options
        )
        self.sequence = 0

    def say(self, who: str, *, after_s: float = 0.02, **frame: float) -> None:
        self.clock.time += after_s
        self.sequence += 1
        self.speech.hear(who, who.title(), voice(self.sequence, **frame))  # type: ignore[arg-type]


@pytest.fixture
def floor() -> Floor:
    return Floor()


def test_what_is_said_is_played_in_order(floor: Floor) -> None:
    for _ in range(3):
        floor.say("ann")
    assert [audio.first_sample for audio in floor.spoken] == [0, 320, 640]
    assert floor.spoken[0].samples.shape == (320, 1)
    assert not floor.spoken[0].samples.flags.writeable
    assert floor.spoken[0].p_BM.shape == (0, 3)
    assert floor.spoken[0].rate == 16_000
    assert floor.speech.speaker == ("ann", "Ann")
    assert floor.notices == []


def test_one_speaks_at_a_time_and_the_second_gets_one_notice(floor: Floor) -> None:
    floor.say("ann")
    floor.say("ben")
    floor.say("ben")
    assert len(floor.spoken) == 1
    assert len(floor.notices) == 1
    assert floor.notices[0][0] == "ben"
    assert "in use by Ann" in floor.notices[0][1]
    floor.say("ann", samples=0)
    assert floor.speech.speaker is None
    floor.say("ben")
    assert len(floor.spoken) == 1, "his hold was refused: he is heard when he presses again"
    floor.say("ben", samples=0)
    floor.say("ben")
    assert len(floor.spoken) == 2
    assert floor.speech.speaker == ("ben", "Ben")


def test_a_pause_and_a_lost_connection_end_a_talk(floor: Floor) -> None:
    floor.say("ann")
    floor.clock.time += PAUSE_S + 0.01
    assert floor.speech.speaker is None
    floor.say("ben")
    assert floor.speech.speaker == ("ben", "Ben")
    floor.speech.gone("ben")
    assert floor.speech.speaker is None
    floor.say("ann")
    assert floor.speech.speaker == ("ann", "Ann")


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (voice(1)[:20], "header of 24 bytes, not 20"),
        (voice(1)[:-1], "320 samples take 640 bytes, not 639"),
        (voice(1) + b"\0\0", "not 642"),
        (voice(1, rate=44_100), "48000 or 16000 samples a second, not 44100"),
        (voice(1, samples=1600), "at most 40 ms, not 100"),
        (voice(1, channels=2), "1 channel, not 2"),
        (voice(1, stamp=float("nan")), "not nan"),
        (voice(1, stamp=-1.0), "not -1.0"),
        (b"\x11", "not 1 in all"),
    ],
)
def test_a_malformed_frame_is_passed_over_with_one_notice(floor: Floor, frame: bytes, words: str) -> None:
    for _ in range(3):
        floor.speech.hear("ann", "Ann", frame)
    assert len(floor.notices) == 1
    assert words in floor.notices[0][1]
    assert floor.spoken == []
    floor.say("ann", samples=640)
    assert len(floor.spoken) == 1


def test_a_talk_that_is_never_played_gets_the_reason(floor: Floor) -> None:
    for _ in range(100):
        floor.say("ann", stamp=10.0)
    assert not floor.spoken
    ((session, text),) = floor.notices
    assert session == "ann"
    assert "arrives too late" in text


def test_what_comes_late_is_passed_over(floor: Floor) -> None:
    floor.say("ann", stamp=1000.0 - LATE_S - 0.1)
    assert floor.spoken == []
    floor.say("ann", stamp=999.9)
    assert floor.spoken[0].stamp == 999.9
    floor.say("ann", stamp=2000.0)
    assert floor.spoken[1].stamp == floor.clock.time, "nothing was said in the future"


def test_more_than_real_time_is_not_hoarded(floor: Floor) -> None:
    """Ten seconds of speech in one moment."""
    for _ in range(500):
        floor.say("ann", after_s=0.0)
    assert 0.5 <= sum(len(audio.samples) / audio.rate for audio in floor.spoken) <= 0.55


def test_a_frame_that_came_twice_is_played_once(floor: Floor) -> None:
    floor.say("ann")
    floor.sequence -= 1
    floor.say("ann")
    assert len(floor.spoken) == 1


def test_a_recording_takes_no_speech() -> None:
    floor = Floor(recording=True)
    floor.say("ann")
    floor.say("ann")
    assert floor.spoken == []
    assert [session for session, _ in floor.notices] == ["ann"]
    assert floor.speech.speaker is None
