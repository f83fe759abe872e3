from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.messages import Audio, LoudNoise
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain

RATE = 48_000
P_BM = np.zeros((8, 3))


def bench(**settings: float) -> Bench:
    return Bench(
        "app.modules.perception.loud_noise_detector:LoudNoiseDetector",
        inputs={"audio": Audio},
        outputs={"noises": LoudNoise},
        settings=settings,
    )


def room(seconds: float, claps: list[float], seed: int = 0) -> NDArray[np.int16]:
    """One microphone: fans at -50 dB, and a clap (-14 dB in its first 10 ms) at each of ``claps`` (s)."""
    rng = np.random.default_rng(seed)
    samples = rng.normal(0, 104, round(seconds * RATE))
    for at in claps:
        begin = round(at * RATE)
        t = np.arange(RATE // 4) / RATE
        samples[begin : begin + len(t)] += rng.normal(0, 9000, len(t)) * np.exp(-t / 0.006)
    return np.clip(samples, -32768, 32767).astype(np.int16)


async def play(
    b: Bench,
    sound: NDArray[np.int16],
    *,
    channel: int = 0,
    channels: int = 8,
    first: int = 0,
    size: int = 512,
    begin_s: float | None = None,
) -> float:
    """Feed ``sound`` on one of ``channels`` in frames of ``size``, each when its last sample is; returns its begin."""
    begin = b.clock.now() if begin_s is None else begin_s
    for at in range(0, len(sound) - size + 1, size):
        samples = np.zeros((size, channels), np.int16)
        samples[:, channel] = sound[at : at + size]
        await b.clock.sleep_until(begin + (at + size) / RATE)
        b.feed("audio", Audio(begin + at / RATE, "microphones", samples, RATE, first + at, P_BM[:channels]))
    await b.settle()
    return begin


def test_each_clap_is_reported_once_with_the_frame_it_came_in() -> None:
    claps = [1.5, 2.3, 4.0]

    async def main() -> None:
        async with bench() as b:
            noises = b.listen("noises")
            begin = await play(b, room(5.0, claps))
            found = drain(noises)
            assert len(found) == len(claps)
            for noise, at in zip(found, claps, strict=True):
                assert -512 / RATE <= noise.stamp - begin - at <= 512 / RATE
                assert noise.ratio > 100
                assert -25 < noise.level_db < -8

    run_virtual(main())


@pytest.mark.parametrize("size", [256, 480, 512, 1024, 4096])
def test_frames_of_another_size_make_no_difference(size: int) -> None:
    claps = [1.5, 2.6]

    async def main() -> None:
        async with bench() as b:
            noises = b.listen("noises")
            begin = await play(b, room(3.5, claps), size=size, channels=1)
            found = [noise.stamp - begin for noise in drain(noises)]
            assert len(found) == 2
            assert all(-0.0107 <= stamp - at <= 0.0107 for stamp, at in zip(found, claps, strict=True))

    run_virtual(main())


def test_it_listens_to_the_configured_microphone() -> None:
    async def main() -> None:
        for channel, found in ((1, 1), (2, 0)):
            async with bench(microphone=1) as b:
                noises = b.listen("noises")
                await play(b, room(2.0, [1.5]), channel=channel)
                assert len(drain(noises)) == found

    run_virtual(main())


def test_a_microphone_that_is_not_there_is_said() -> None:
    async def main() -> None:
        async with bench(microphone=3) as b:
            await play(b, room(0.1, []), channels=1)
            assert "set `microphone` to 0 … 0" in b.problem

    run_virtual(main())


def test_a_short_gap_changes_nothing_and_after_a_long_one_it_listens_afresh() -> None:
    async def main() -> None:
        async with bench() as b:
            noises = b.listen("noises")
            await play(b, room(2.0, []))
            await play(b, room(0.5, [0.2]), first=2 * RATE + RATE // 2)
            assert len(drain(noises)) == 1, "half a second was lost: the background still holds"
            await play(b, room(2.5, [0.5, 1.8]), first=60 * RATE)
            assert len(drain(noises)) == 1, "the first clap came before anything was known"
            await play(b, room(2.5, [0.5, 1.8]), first=0)
            assert len(drain(noises)) == 1, "another source counts from zero again"

    run_virtual(main())


def test_sound_that_was_lost_is_said_and_it_listens_afresh(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        async with bench() as b:
            noises = b.listen("noises")
            await play(b, room(1.5, []))
            flood = room(2.0, [0.5])
            for at in range(0, len(flood) - 511, 512):
                samples = np.repeat(flood[at : at + 512, None], 8, axis=1)
                b.feed("audio", Audio(b.clock.now(), "microphones", samples, RATE, 72_000 + at, P_BM))
            await b.settle()
            assert b.supervisor.states["Tested"].restarts == 0
            drain(noises)
            await play(b, room(2.0, [1.6]), first=72_000 + len(flood))
            assert len(drain(noises)) == 1

    run_virtual(main())
    assert len([r for r in caplog.records if "listening begins afresh" in r.message]) == 1


@pytest.mark.slow
def test_the_desire_says_how_loud_is_loud_and_how_far_apart() -> None:
    async def main() -> None:
        async with bench() as b:
            noises = b.listen("noises")
            b.slot.configure({"ratio": 1e6})
            await play(b, room(2.0, [1.5]))
            assert drain(noises) == []
            b.slot.configure({"ratio": 20, "hold_off_s": 3.0})
            await play(b, room(4.0, [0.5, 1.5, 2.5]), first=187 * 512)
            assert len(drain(noises)) == 1
            b.slot.configure({})
            await play(b, room(6.0, [4.0, 5.0]), first=(187 + 375) * 512)
            assert len(drain(noises)) == 2

    run_virtual(main())


def test_what_the_loudspeaker_plays_is_no_noise() -> None:
    async def main() -> list[float]:
        b = Bench(
            "app.modules.perception.loud_noise_detector:LoudNoiseDetector",
            inputs={"audio": Audio, "played": Audio},
            outputs={"noises": LoudNoise},
        )
        async with b:
            noises = b.listen("noises")
            begin = b.clock.now()
            for second in (1.9, 2.0):
                samples = np.zeros((RATE // 10, 1), np.int16)
                b.feed("played", Audio(begin + second, "loudspeaker", samples, RATE, round(second * RATE), P_BM[:0]))
            await play(b, room(4.5, [2.05, 3.5]))
            return [noise.stamp - begin for noise in drain(noises)]

    assert run_virtual(main()) == [pytest.approx(3.5, abs=0.02)]
