"""The robot's own voice goes, others stay as they are; sound is neither lost nor moved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.own_voice import BLOCK_S, EchoCanceller, OwnVoiceFilter

RATE = 16_000
BLOCK = round(BLOCK_S * RATE)
CHANNELS = 3


def speech_like(seconds: float, seed: int, level: float = 0.1) -> NDArray[np.float32]:
    """Noise with the loudness of syllables."""
    times = np.arange(round(seconds * RATE)) / RATE
    noise = np.random.default_rng(seed).normal(size=times.size)
    return np.asarray(noise * level * (0.2 + np.sin(2 * np.pi * 2 * times) ** 2), np.float32)


def echo_of(sound: NDArray[np.float32]) -> NDArray[np.float32]:
    """``sound`` at each microphone (C, N): a direct path and 0.1 s of a room, other at each."""
    decay = np.exp(-np.arange(1600) / 250)
    paths = np.random.default_rng(7).normal(size=(CHANNELS, 1600)) * decay * 0.1
    paths[:, 10] += 0.7
    return np.stack([np.convolve(sound, path)[: sound.size] for path in paths]).astype(np.float32)


def cancelled(
    canceller: EchoCanceller, reference: NDArray[np.float32], sound: NDArray[np.float32]
) -> NDArray[np.float32]:
    pieces = [
        canceller.process(reference[i : i + BLOCK], sound[:, i : i + BLOCK])
        for i in range(0, reference.size - BLOCK + 1, BLOCK)
    ]
    return np.concatenate(pieces, axis=1)


def power_db(sound: NDArray[np.float32]) -> float:
    return float(10 * np.log10(np.mean(sound.astype(np.float64) ** 2) + 1e-20))


def noise(shape: tuple[int, ...], seed: int) -> NDArray[np.float32]:
    return np.random.default_rng(seed).normal(0, 1e-4, shape).astype(np.float32)


def test_the_echo_is_removed_and_at_once_in_the_next_sentence() -> None:
    canceller = EchoCanceller(CHANNELS, BLOCK)
    first, second = speech_like(4.0, 1), speech_like(2.0, 2)
    sound = echo_of(first) + noise((CHANNELS, first.size), 3)
    rest = cancelled(canceller, first, sound)
    assert power_db(sound[:, 2 * RATE :]) - power_db(rest[:, 2 * RATE :]) > 20
    canceller.forget_past()
    sound = echo_of(second) + noise((CHANNELS, second.size), 4)
    rest = cancelled(canceller, second, sound)
    assert power_db(sound) - power_db(rest) > 25


def test_a_talker_meanwhile_keeps_level_and_phase() -> None:
    canceller = EchoCanceller(CHANNELS, BLOCK)
    first, second, talker = speech_like(4.0, 1), speech_like(4.0, 2), speech_like(4.0, 5, level=0.05)
    cancelled(canceller, first, echo_of(first) + noise((CHANNELS, first.size), 3))
    there = np.stack([np.roll(talker, 5 * number) for number in range(CHANNELS)])
    rest = cancelled(canceller, second, echo_of(second) + there)
    there = there[:, : rest.shape[1]]
    assert power_db(rest - there) < power_db(there) - 10
    assert power_db(rest) == pytest.approx(power_db(there), abs=0.5)


def test_only_used_microphones_are_processed() -> None:
    canceller = EchoCanceller(CHANNELS, BLOCK)
    reference = speech_like(2.0, 1)
    sound = echo_of(reference)
    whole = EchoCanceller(CHANNELS, BLOCK)
    for i in range(0, reference.size - BLOCK + 1, BLOCK):
        some = canceller.process(reference[i : i + BLOCK], sound[[0, 2], i : i + BLOCK], (0, 2))
        every = whole.process(reference[i : i + BLOCK], sound[:, i : i + BLOCK])
        np.testing.assert_allclose(some, every[[0, 2]], atol=1e-5)


def as_int16(sound: NDArray[np.float32]) -> NDArray[np.int16]:
    return np.asarray(np.clip(np.rint(sound * 32768), -32768, 32767), np.int16)


def test_while_nothing_is_played_frames_pass_as_they_are() -> None:
    own_voice = OwnVoiceFilter(CHANNELS, RATE)
    frame = as_int16(noise((160, CHANNELS), 1))
    first, out = own_voice.process(17, frame)
    assert first == 17
    assert out is frame


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(1, 900), min_size=1, max_size=12), st.integers(0, 3000), st.integers(0, 2000))
def test_no_sample_is_lost_or_moved(sizes: list[int], begin: int, length: int) -> None:
    own_voice = OwnVoiceFilter(1, RATE)
    sound = np.full((sum(sizes) + 20 * RATE // 10, 1), 100, np.int16)
    sizes = [*sizes, sound.shape[0] - sum(sizes)]
    at, expected = 5000, 5000
    for size in sizes:
        played = [(5000 + begin, np.full(length, 3000, np.int16))] if at == 5000 and length else []
        first, out = own_voice.process(at, sound[at - 5000 : at - 5000 + size], played)
        assert not len(out) or first == expected
        expected += len(out)
        at += size
    assert at - BLOCK < expected <= at


def test_a_talker_is_let_through_and_the_rest_of_the_echo_is_not() -> None:
    own_voice = OwnVoiceFilter(CHANNELS, RATE)

    def heard(reference: NDArray[np.float32], sound: NDArray[np.float32], number: int) -> NDArray[np.float32]:
        pieces = []
        for i in range(0, reference.size - 159, 160):
            played = [(number + i, as_int16(reference[i : i + 160]))]
            pieces.append(own_voice.process(number + i, as_int16(sound[:, i : i + 160].T), played)[1])
        return np.asarray(np.concatenate(pieces).T / 32768, np.float32)

    first, second = speech_like(4.0, 1), speech_like(4.0, 2)
    sound = echo_of(first) + noise((CHANNELS, first.size), 3)
    alone = heard(first, sound, 0)
    assert power_db(alone[:, :RATE]) < power_db(sound) - 40
    assert power_db(alone[:, RATE:]) < power_db(sound) - 40
    talker = np.zeros(second.size, np.float32)
    talker[2 * RATE :] = speech_like(2.0, 5, level=0.1)
    sound = echo_of(second) + talker + noise((CHANNELS, second.size), 4)
    both = heard(second, sound, first.size)
    assert power_db(both[:, : 2 * RATE - BLOCK]) < power_db(sound) - 40
    after = both[:, 2 * RATE : talker.size - BLOCK]
    assert power_db(after) == pytest.approx(power_db(talker[2 * RATE :]), abs=1.5)
