"""The queue before the loudspeaker: nothing lost, nothing late for ever, any rate."""

from __future__ import annotations

import numpy as np
import pytest

from app.robots.simulated.acoustics.loudspeaker_source import MOST_S, START_S, LoudspeakerSource

RATE = 48000


def tone(seconds: float, rate: int) -> np.ndarray[tuple[int], np.dtype[np.int16]]:
    return np.rint(10000 * np.sin(2 * np.pi * 400 * np.arange(round(seconds * rate)) / rate)).astype(np.int16)


@pytest.mark.parametrize("rate", [48000, 16000, 24000])
def test_what_is_given_in_pieces_is_played_whole_and_without_clicks(rate: int) -> None:
    speaker = LoudspeakerSource(RATE)
    whole = tone(0.3, rate)
    pieces = iter(np.array_split(whole, 15))
    for _ in range(3):
        speaker.play(next(pieces), rate)
    heard = []
    for number in range(40):
        if number % 2 == 0 and (piece := next(pieces, None)) is not None:
            speaker.play(piece, rate)
        heard.append(speaker.read(512 * number, 512))
    out = np.concatenate(heard)[: round(0.29 * RATE)]
    expected = 10000 / 32768 * np.sin(2 * np.pi * 400 * np.arange(out.size) / RATE)
    np.testing.assert_allclose(out[32:], expected[32:], atol=0.01)
    assert speaker.dropped == 0


def test_at_most_half_a_second_waits_and_the_oldest_goes() -> None:
    speaker = LoudspeakerSource(RATE)
    speaker.play(np.full(RATE, 1000, dtype=np.int16), RATE)
    speaker.play(np.full(RATE // 4, 2000, dtype=np.int16), RATE)
    assert speaker.waiting_s == pytest.approx(MOST_S, abs=0.001)
    assert speaker.dropped == pytest.approx(0.75 * RATE, abs=20)
    heard = np.concatenate([speaker.read(512 * n, 512) for n in range(60)])
    assert heard[12000 - 600 : 12000 - 100].max() < 0.04  # the younger half second is half of each
    assert heard[12400:23000].min() > 0.05
    assert not heard[25000:].any()


def test_it_waits_for_a_little_to_be_there_before_it_begins() -> None:
    speaker = LoudspeakerSource(RATE)
    speaker.play(tone(START_S / 2, RATE), RATE)
    assert not speaker.read(0, 512).any()
    speaker.play(tone(START_S, RATE), RATE)
    assert speaker.read(512, 512).any()


def test_what_was_just_played_can_be_read_again() -> None:
    speaker = LoudspeakerSource(RATE)
    speaker.play(tone(0.2, RATE), RATE)
    first, second = speaker.read(10_000, 512), speaker.read(10_512, 512)
    np.testing.assert_array_equal(speaker.read(10_400, 300), np.concatenate([first[400:], second[:188]]))
