"""VoiceMouth: visemes from the level of a voice."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import soundfile

import app
from app.modules.behaviors.face.expression import with_mouth
from app.modules.behaviors.face.voice_mouth import VoiceMouth

RATE = 48_000
SPEECH = Path(app.__file__).parent / "robots" / "simulated" / "acoustics" / "speech"
OPENNESS = {name: float(with_mouth(np.zeros(9), name)[-1]) for name in ("closed", "narrow", "mid", "open")}


def frame(level: int, seconds: float = 0.02) -> np.ndarray:
    return np.full((round(RATE * seconds), 1), level, np.int16)


@pytest.mark.parametrize("level", [600, 3000, 30000])
def test_it_opens_with_the_level_compared_with_the_loudest_of_late(level: int) -> None:
    mouth, seen = VoiceMouth(), []
    for number, share in enumerate((1.0, 0.5, 0.2, 0.05)):
        begin = 0.1 * number
        mouth.take(frame(round(share * level), 0.1), RATE, begin)
        seen.append(mouth.viseme(begin + 0.09))
    assert seen == ["open", "mid", "narrow", "closed"]


def test_what_is_silent_opens_nothing() -> None:
    mouth = VoiceMouth()
    mouth.take(frame(30), RATE, 0.0)
    assert mouth.viseme(0.01) == "closed"
    mouth.take(frame(0), RATE, 1.0)
    assert mouth.viseme(1.01) == "closed"


def test_there_is_no_viseme_before_or_after_a_voice_but_in_a_short_gap() -> None:
    mouth = VoiceMouth()
    assert mouth.viseme(0.0) is None
    mouth.take(frame(0)[:0], RATE, 0.0)
    assert mouth.viseme(0.0) is None
    mouth.take(frame(3000), RATE, 0.0)
    assert mouth.viseme(0.1) == "closed"
    assert mouth.viseme(0.2) is None


def test_frames_that_come_at_once_are_played_one_after_the_other() -> None:
    mouth = VoiceMouth()
    for level in (3000, 3000, 100, 100):
        mouth.take(frame(level, 0.1), RATE, 0.0)
    assert [mouth.viseme(time) for time in (0.05, 0.15, 0.25, 0.35, 0.6)] == ["open", "open", "closed", "closed", None]


def test_a_lower_voice_opens_the_mouth_as_far_after_a_while() -> None:
    mouth, seen = VoiceMouth(), []
    for number in range(100):
        begin = 0.1 * number
        mouth.take(frame(20000 if number < 10 else 4000, 0.1), RATE, begin)
        seen.append(mouth.viseme(begin + 0.09))
    assert seen[9] == seen[-1] == "open"
    assert seen[10] != "open"


@pytest.mark.parametrize("name", ["austen_1", "austen_3", "kennedy_2"])
def test_it_moves_with_the_syllables_of_recorded_speech(name: str) -> None:
    samples, rate = soundfile.read(SPEECH / f"{name}.flac", dtype="int16", always_2d=True)
    mouth, seen, length = VoiceMouth(), [], rate // 50
    for number in range(len(samples) // length):
        mouth.take(samples[number * length :][:length], rate, 0.02 * number)
        seen.append(OPENNESS[mouth.viseme(0.02 * number + 0.019) or "closed"])
    turns = sum(one < OPENNESS["mid"] <= other for one, other in pairwise(seen)) / (0.02 * len(seen))
    assert 1.5 < turns < 8, "people say three to six syllables a second"
    assert min(seen.count(each) for each in OPENNESS.values()) > 0.03 * len(seen)
