from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.messages import Audio
from app.modules.perception.audio_stream import amplified, front_microphone
from app.robots.stream_config import MicrophonesConfig
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain

MODULE = "app.modules.perception.audio_stream:AudioStream"


def frame(number: int, *, samples: int = 512, channels: int = 2, rate: int = 48_000) -> Audio:
    """Frame ``number``: sample i of channel c is 10 i + c, counted from the source's begin."""
    count = 10 * (number * samples + np.arange(samples))
    values = (count[:, None] + np.arange(channels)).astype(np.int16)
    places = np.array([[0.0, 0.0, 0.5], [0.1, 0.0, 0.5]])[:channels]
    return Audio(100.0 + number * samples / rate, "microphones", values, rate, number * samples, places)


def heard(frames: Sequence[Audio], **settings: Any) -> list[Audio]:
    """What the module makes of ``frames``."""

    async def run() -> list[Audio]:
        bench = Bench(MODULE, inputs={"audio": Audio}, outputs={"sound": Audio}, settings=settings)
        async with bench:
            out = bench.listen("sound")
            for audio in frames:
                bench.feed("audio", audio)
                await bench.settle()
            return drain(out)

    return run_virtual(run())


def test_frames_of_twenty_milliseconds_of_the_front_microphone() -> None:
    out = heard([frame(number) for number in range(5)], gain_db=0)
    assert [len(audio.samples) for audio in out] == [1024, 1024]
    first, second = out
    assert (first.stamp, first.first_sample, first.rate) == (100.0, 0, 48_000)
    assert second.stamp == pytest.approx(100.0 + 1024 / 48_000)
    np.testing.assert_array_equal(first.samples[:, 0], 10 * np.arange(1024) + 1)
    np.testing.assert_array_equal(first.p_BM, [[0.1, 0.0, 0.5]])
    assert not first.samples.flags.writeable


def test_another_microphone_can_be_chosen() -> None:
    (out,) = heard([frame(0), frame(1)], gain_db=0, microphone=0)
    assert out.samples[5, 0] == 50
    (out,) = heard([frame(0), frame(1)], gain_db=0, microphone=7)
    assert out.samples[5, 0] == 51, "there are only two"


def test_a_frame_has_no_gaps() -> None:
    """Frame 2 was lost: what waited before it is of another time."""
    out = heard([frame(number) for number in (0, 1, 3, 5, 6)], gain_db=0)
    assert [audio.first_sample for audio in out] == [0, 5 * 512]
    assert all((np.diff(audio.samples[:, 0]) == 10).all() for audio in out)


def test_frames_that_are_long_enough_go_on_as_they_come() -> None:
    assert len(heard([frame(number, samples=960) for number in range(3)])) == 3
    assert len(heard([frame(number, samples=160, rate=16_000) for number in range(4)])) == 2


def test_sound_is_made_louder_and_held_at_full_scale() -> None:
    samples = np.array([0, 1, -100, 20_000, -20_000, 32_767, -32_768], np.int16)
    np.testing.assert_array_equal(amplified(samples, 2.0), [0, 2, -200, 32_767, -32_768, 32_767, -32_768])


@given(st.lists(st.integers(-32_768, 32_767), min_size=1, max_size=50), st.floats(0.01, 100.0))
def test_louder_never_turns_over(values: list[int], gain: float) -> None:
    samples = np.array(values, np.int16)
    loud = amplified(samples, gain)
    assert (np.sign(loud) * np.sign(samples) >= 0).all()
    order = np.argsort(samples, kind="stable")
    assert (np.diff(loud[order].astype(int)) >= 0).all()


def test_the_front_microphone_is_the_highest_of_those_ahead() -> None:
    robot = np.array(MicrophonesConfig().positions)
    front = robot[front_microphone(robot)]
    assert front[0] == robot[:, 0].max()
    assert front[2] == robot[:, 2].max()
    assert front_microphone(np.zeros((0, 3))) == 0
    assert front_microphone(np.array([[0.0, 0.0, 1.0], [0.1, 0.0, 0.2], [0.102, 0.0, 0.1]])) == 1
