from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.messages import Audio, Odometry, SeparatedSound, SoundSources, read_only
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, drain
from tests.modules.perception.voices.sounds import ARRAY, RATE, as_int16, babble, heard, heard_turning, toward

FRAME = 512
P_BM = ARRAY.positions + np.array([0.0, 0.0, 0.8])


def bench(odometry: bool = True, **settings: object) -> Bench:
    inputs = {"audio": Audio, "odometry": Odometry} if odometry else {"audio": Audio}
    return Bench(
        "app.modules.perception.voice_localizer:VoiceLocalizer",
        inputs=inputs,
        outputs={"sources": SoundSources, "separated": SeparatedSound},
        settings=settings,
    )


@pytest.fixture(scope="module")
def talker() -> NDArray[np.int16]:
    """2 s of a talker to the left, in a little noise."""
    sound = heard(babble(0, 2.0), toward(60))
    return as_int16(sound + np.random.default_rng(1).normal(0, 1e-3, sound.shape))


def still(_: float) -> Pose2:
    return Pose2()


async def say(
    b: Bench,
    sound: NDArray[np.int16],
    *,
    first: int = 0,
    pose: Callable[[float], Pose2] | None = still,
    origin: float | None = None,
    p_BM: NDArray[np.float64] = P_BM,
    speed_mps: float = 0.0,
) -> None:
    """Feed frames as they would come, each when its last sample was taken; odometry 100 times a second, 20 ms late."""
    start = b.clock.now() if origin is None else origin
    fed = 0
    for begin in range(0, len(sound) - FRAME + 1, FRAME):
        await b.clock.sleep_until(start + (begin + FRAME) / RATE)
        while pose is not None and 0.01 * fed < (begin + FRAME) / RATE - 0.02:
            b.feed("odometry", Odometry(start + 0.01 * fed, pose(0.01 * fed), speed_mps, 0))
            fed += 1
        stamp = start + begin / RATE
        b.feed("audio", Audio(stamp, "mics", read_only(sound[begin : begin + FRAME]), RATE, first + begin, p_BM))
    await b.clock.sleep(0.1)


def off_deg(source: tuple[float, float, float], azimuth_deg: float) -> float:
    return math.degrees(math.acos(min(1.0, float(np.dot(source, toward(azimuth_deg))))))


def test_a_talker_is_located_within_a_quarter_of_a_second_and_heard_alone(talker: NDArray[np.int16]) -> None:
    onset = int(np.flatnonzero(np.abs(talker[:, 0]) > 300)[0]) / RATE
    quiet = as_int16(np.random.default_rng(2).normal(0, 1e-3, (RATE // 2, 8)))

    async def main() -> None:
        async with bench() as b:
            sources, separated = b.listen("sources"), b.listen("separated")
            arrived: list[tuple[float, SoundSources]] = []
            b.graph.channel("sources").observe(lambda m: arrived.append((b.clock.now(), m)))
            start = b.clock.now()
            await say(b, np.concatenate([quiet, talker]))
            spoke = start + 0.5 + onset
            when = next(at for at, message in arrived if message.sources)
            assert 0 < when - spoke < 0.25
            last = [message for message in drain(sources) if message.sources][-1]
            assert off_deg(last.sources[0].direction, 60) < 4
            assert 0 <= last.sources[0].speech <= 1
            blocks = drain(separated)
            assert {block.rate for block in blocks} == {16_000}
            assert all(
                later.first_sample == block.first_sample + len(block.samples) for block, later in pairwise(blocks)
            )
            assert last.sources[0].track in blocks[-1].tracks
            assert not blocks[-1].samples.flags.writeable

    run_virtual(main())


def test_a_turning_robot_with_late_odometry_follows_by_the_sounds_own_time() -> None:
    voice = babble(0, 2.5) + 0.3 * babble(7, 2.5) + 0.3 * babble(8, 2.5)  # together without a pause
    turning = heard_turning(voice, 60, 50)
    sound = as_int16(turning + np.random.default_rng(1).normal(0, 1e-3, turning.shape))

    async def main() -> None:
        async with bench(separation=False, speech=False) as b:
            sources = b.listen("sources")
            start = b.clock.now()
            await say(b, sound, pose=lambda seconds: Pose2(0, 0, math.radians(50) * seconds))
            messages = [message for message in drain(sources) if message.stamp - start > 1.2 and message.sources]
            assert len(messages) > 20
            assert len({message.sources[0].track for message in messages}) == 1
            errors = [off_deg(message.sources[0].direction, 60 - 50 * (message.stamp - start)) for message in messages]
            assert np.median(errors) < 4

    run_virtual(main())


def test_without_odometry_it_goes_on_and_says_so_once(
    talker: NDArray[np.int16], caplog: pytest.LogCaptureFixture
) -> None:
    async def main() -> None:
        async with bench(separation=False, speech=False) as b:
            sources, separated = b.listen("sources"), b.listen("separated")
            await say(b, talker[:RATE], pose=None)
            assert drain(sources)[-1].sources
            assert drain(separated) == []
        async with bench(odometry=False, separation=False, speech=False) as b:
            sources = b.listen("sources")
            await say(b, talker[:RATE], pose=None)
            assert drain(sources)[-1].sources

    run_virtual(main())
    assert len([r for r in caplog.records if "as if the robot stood still" in r.message]) == 1


def test_a_gap_begins_afresh_and_parameters_make_another_pipeline_without_using_a_number_twice(
    talker: NDArray[np.int16],
) -> None:
    second = talker[:RATE]

    async def main() -> None:
        async with bench(speech=False) as b:
            sources, separated = b.listen("sources"), b.listen("separated")
            await say(b, second)
            (first,) = drain(sources)[-1].sources
            drain(separated)
            await say(b, second, first=3 * RATE)
            blocks = drain(separated)
            assert blocks[0].first_sample == RATE, "numbers are those of the sound"
            drain(sources)
            b.slot.configure({"microphones": 4, "separation": False})
            await say(b, second, first=5 * RATE)
            (four,) = drain(sources)[-1].sources
            assert four.track > first.track
            assert off_deg(four.direction, 60) < 8
            assert drain(separated) == []
            # A message that cannot be sound makes the module fail; its next instance uses new numbers, whatever was
            # published last.
            b.graph.channel("sources").publish(SoundSources(b.clock.now(), (0.0, 0.0, 0.0), ()))
            b.feed("audio", None)
            await b.clock.sleep(2.0)
            assert b.supervisor.states["Tested"].restarts == 1
            await say(b, second, first=8 * RATE)
            (last,) = drain(sources)[-1].sources
            assert last.track > four.track

    run_virtual(main())


def test_microphones_that_cannot_report_directions_are_a_failure_in_words(talker: NDArray[np.int16]) -> None:
    async def main() -> None:
        async with bench(speech=False) as b:
            await say(b, talker[: 8 * FRAME, :1], p_BM=P_BM[:1])
            assert "voices cannot be located with these microphones: positions are (M, 3) of 2 to 32" in b.problem

    run_virtual(main())


@pytest.fixture(scope="module")
def two_talkers() -> NDArray[np.int16]:
    """What the microphones hear of two talkers, and a little noise."""
    sound = heard(babble(0, 4.0), toward(60)) + heard(babble(1, 4.0), toward(-75, 5))
    return as_int16(sound + np.random.default_rng(1).normal(0, 1e-3, sound.shape))


#: The microphones in another order than the robot's file says.
EXCHANGED = [0, 2, 1, 3, 4, 5, 6, 7]


def doubts(caplog: pytest.LogCaptureFixture) -> int:
    return len([r for r in caplog.records if "positions do not explain what they hear" in r.message])


def test_microphones_in_another_order_than_the_robots_file_says_are_said_once(
    two_talkers: NDArray[np.int16], caplog: pytest.LogCaptureFixture
) -> None:
    async def main(order: list[int]) -> None:
        async with bench(odometry=False, separation=False, speech=False) as b:
            await say(b, two_talkers[:, order], pose=None)
            b.slot.configure({"separation": True})
            await say(b, two_talkers[:, order], first=5 * RATE, pose=None)

    run_virtual(main(list(range(8))))
    assert doubts(caplog) == 0
    run_virtual(main(EXCHANGED))
    assert doubts(caplog) == 1


def test_what_is_heard_while_the_robot_drives_is_no_evidence_against_its_microphones(
    two_talkers: NDArray[np.int16], caplog: pytest.LogCaptureFixture
) -> None:
    """Noise of its own wheels is too near for any direction to explain it, wherever the microphones are."""

    async def main() -> None:
        async with bench(separation=False, speech=False) as b:
            await say(b, two_talkers[:, EXCHANGED], speed_mps=0.3)

    run_virtual(main())
    assert doubts(caplog) == 0


def test_nor_is_what_is_heard_while_nothing_is_known_of_its_motion(
    two_talkers: NDArray[np.int16], caplog: pytest.LogCaptureFixture
) -> None:
    async def main() -> None:
        async with bench(separation=False, speech=False) as b:
            await say(b, two_talkers[:, EXCHANGED], pose=None)

    run_virtual(main())
    assert doubts(caplog) == 0
