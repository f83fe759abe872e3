"""The rest of the robot's own voice is not taken for another's, however much is left: also while the robot drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from app.modules.perception.voices.own_voice import BLOCK_S, OwnVoiceFilter
from app.modules.perception.voices.residual_echo import ResidualEcho
from app.robots.simulated.acoustics.sound_library import SPEECH

RATE = 16_000
BLOCK = round(BLOCK_S * RATE)
CHANNELS = 4
Sound = NDArray[np.float32]


def spoken(names: tuple[str, ...], seconds: float, level: float = 0.1) -> Sound:
    """Recorded speech (N,), ``level`` of its active parts."""
    sound = np.concatenate([soundfile.read(SPEECH / f"{name}.flac", dtype="float32")[0] for name in names])
    active = np.abs(sound) > 0.05 * np.abs(sound).max()
    return np.asarray(np.resize(sound / np.sqrt((sound[active] ** 2).mean()) * level, round(seconds * RATE)))


def room(seed: int) -> Sound:
    """0.15 s of reflections and reverberation (C, N) at each microphone, of power 1."""
    decay = np.exp(-np.arange(2400) / 300)
    paths = np.random.default_rng(seed).normal(size=(CHANNELS, 2400)) * decay
    return np.asarray(paths / np.sqrt((paths**2).sum(axis=1, keepdims=True)), np.float32)


def reverberated(sound: Sound, seed: int) -> Sound:
    """``sound`` in a room, at each microphone (C, N)."""
    return np.asarray(fftconvolve(sound[None], room(seed), axes=1)[:, : sound.size], np.float32)


def reverberated_in(sound: Sound, seeds: Sequence[int]) -> Sound:
    """``sound`` in one room after the other, an eighth of a second each, with crossfades."""
    hop = RATE // 8
    fade = np.concatenate([np.arange(hop), np.arange(hop, 0, -1)]).astype(np.float32) / hop
    padded = np.concatenate([np.zeros(hop, np.float32), sound])
    heard = np.zeros((CHANNELS, padded.size + hop + 2400), np.float32)
    for begin, seed in zip(range(0, sound.size, hop), seeds, strict=True):
        piece = padded[begin : begin + 2 * hop]
        part = fftconvolve((piece * fade[: piece.size])[None], room(seed), axes=1)
        heard[:, begin : begin + part.shape[1]] += part
    return heard[:, hop : padded.size]


def shares(judge: ResidualEcho, echo: Sound, left: Sound) -> NDArray[np.float64]:
    """Another's share of each block."""
    begins = range(0, echo.shape[1] - BLOCK + 1, BLOCK)
    return np.array([judge.others(echo[:, i : i + BLOCK], left[:, i : i + BLOCK]) for i in begins])


def loud(sound: Sound) -> NDArray[np.bool_]:
    """In which blocks ``sound`` (C, N) is not far below its loudest."""
    whole = sound[:, : sound.shape[1] // BLOCK * BLOCK].reshape(len(sound), -1, BLOCK)
    power = np.asarray((whole**2).mean(axis=(0, 2)))
    return power > 0.03 * power.max()


ROBOT = spoken(("kennedy_1", "kennedy_2"), 8.0)
ECHO = np.stack([np.roll(ROBOT, number) for number in range(CHANNELS)])
REST = reverberated(ROBOT, 5)
TALKER = reverberated(spoken(("austen_1", "austen_2"), 8.0), 11)


def db(level: float) -> np.float32:
    return np.float32(10 ** (level / 20))


@pytest.mark.parametrize("rest_db", [-30, -14])
def test_the_rest_of_the_echo_is_no_other_sound(rest_db: float) -> None:
    assert shares(ResidualEcho(BLOCK, RATE), ECHO, REST * db(rest_db)).max() < 0.03


@pytest.mark.parametrize("rest_db", [-30, -14])
def test_a_voice_much_softer_than_the_echo_is_another_sound(rest_db: float) -> None:
    another = shares(ResidualEcho(BLOCK, RATE), ECHO, REST * db(rest_db) + TALKER * db(-8))
    assert (another[loud(TALKER)] > 0.05).mean() > 0.9


def test_a_voice_is_another_sound_where_nothing_is_played_and_a_steady_noise_is_not() -> None:
    silence = np.zeros_like(ECHO)
    noise = np.random.default_rng(3).normal(0, 1e-4, TALKER.shape).astype(np.float32)
    assert shares(ResidualEcho(BLOCK, RATE), silence, noise).max() < 0.03
    another = shares(ResidualEcho(BLOCK, RATE), silence, noise + TALKER * db(-20))
    assert (another[loud(TALKER)] > 0.05).mean() > 0.9


def test_a_driving_robot_hears_a_talker_and_not_itself() -> None:
    own_voice = OwnVoiceFilter(CHANNELS, RATE)
    played = spoken(("kennedy_1", "kennedy_2", "kennedy_3"), 12.0)
    at_rest, alone = 6 * RATE, 9 * RATE
    rooms = reverberated_in(played, [5] * 48 + list(range(100, 148)))
    direct = np.stack([np.roll(played, 10 + number) for number in range(CHANNELS)])
    hum = np.random.default_rng(3).normal(0, 1e-4, rooms.shape).astype(np.float32)
    talker = np.zeros_like(rooms)
    talker[:, alone:] = TALKER[:, : talker.shape[1] - alone] * db(-8)
    heard = direct + db(-14) * rooms + hum + talker
    clean = np.concatenate(
        [
            own_voice.process(i, as_int16(heard[:, i : i + BLOCK].T), [(i, as_int16(played[i : i + BLOCK]))])[1]
            for i in range(0, played.size, BLOCK)
        ]
    )
    through = np.abs(clean[: clean.shape[0] // BLOCK * BLOCK]).reshape(-1, BLOCK * CHANNELS).max(axis=1) > 16
    first, last = at_rest // BLOCK, alone // BLOCK
    assert through[first:last].mean() < 0.05
    assert through[last + 1 :][loud(talker[:, : through.size * BLOCK])[last + 1 :]].mean() > 0.9


def as_int16(sound: Sound) -> NDArray[np.int16]:
    return np.asarray(np.clip(np.rint(sound * 32768), -32768, 32767), np.int16)
