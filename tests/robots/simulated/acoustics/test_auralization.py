"""Block after block: no clicks from anything that moves, Doppler as it is, echoes on time, and silence left alone."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.auralization import Auralizer, Emission, OneRoom
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS, BaffledMicrophones
from app.robots.simulated.acoustics.dry_sound import SampledSound
from app.robots.simulated.acoustics.room import Shoebox

RATE, BLOCK = 48000, 512
ROOM = Shoebox((0.0, 0.0, 0.0), (10.0, 6.8, 2.7), (0.4, 0.35))
SINE_HZ = 1000.0


def sine(seconds: float = 4.0, hz: float = SINE_HZ) -> SampledSound:
    return SampledSound(np.sin(2 * np.pi * hz * np.arange(round(seconds * RATE)) / RATE).astype(np.float32))


def at(x: float, y: float, turn: float = 0.0) -> Pose3:
    return Pose3.from_translation_rpy((x, y, 1.1), (0.0, 0.0, turn))


def spectrum_db(samples: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies and levels under the strongest, through a window whose sidelobes are below -120 dB."""
    window = np.kaiser(samples.size, 18)
    power = np.abs(np.fft.rfft(samples * window)) ** 2
    return np.fft.rfftfreq(samples.size, 1 / RATE).astype(np.float64), 10 * np.log10(power / power.max() + 1e-20)


@pytest.mark.parametrize("room", [None, ROOM])
def test_neither_a_moving_source_nor_a_turning_robot_clicks(shaded: BaffledMicrophones, room: Shoebox | None) -> None:
    hearing = Auralizer(shaded, OneRoom(room), late_s=0.3)
    blocks = []
    for number in range(180):
        t = (number + 1) * BLOCK / RATE
        walker = np.array([7.0 - 1.4 * t, 2.0 + 1.0 * t, 1.6])
        emission = Emission("sine", sine(), 0, walker, looks=np.array([-1.0, 0.0, 0.0]))
        blocks.append(hearing.block([emission], at(3.0 + 0.3 * t, 3.0, 0.8 * t)))
    heard = np.concatenate(blocks, axis=1)[:, 20 * BLOCK :]
    assert hearing.kernels > 20
    for channel in heard:
        f, level = spectrum_db(channel)
        away = (f > 3000) & (f < 20000)  # a click is as loud there as anywhere
        assert level[away].max() < -75.0
        # Each block's edge is as smooth as the rest: the largest step is that of a sine this loud
        loudest = np.abs(channel).max()
        assert np.abs(np.diff(channel)).max() < 1.1 * 2 * np.pi * SINE_HZ / RATE * loudest


def test_a_source_that_comes_near_sounds_higher(free: BaffledMicrophones) -> None:
    hearing = Auralizer(free, OneRoom(None))
    speed = 3.0
    blocks = []
    for number in range(150):
        place = np.array([9.0 - speed * (number + 1) * BLOCK / RATE, 0.0, 0.0])
        blocks.append(hearing.block([Emission("sine", sine(), 0, place)], Pose3.identity()))
    f, level = spectrum_db(np.concatenate(blocks, axis=1)[0, 20 * BLOCK :])
    assert f[np.argmax(level)] == pytest.approx(SINE_HZ / (1 - speed / SPEED_OF_SOUND_MPS), abs=0.8)


def test_a_jump_goes_over_without_a_step(free: BaffledMicrophones) -> None:
    hearing = Auralizer(free, OneRoom(None))
    places = [np.array([2.0, 0.0, 0.0])] * 20 + [np.array([0.0, 5.0, 0.0])] * 20
    heard = np.concatenate(
        [hearing.block([Emission("s", sine(hz=300.0), 0, p)], Pose3.identity()) for p in places], axis=1
    )
    assert np.abs(np.diff(heard[0])).max() < 0.6 * 2 * np.pi * 300 / RATE


def test_delay_and_level_are_those_of_the_way(free: BaffledMicrophones) -> None:
    """Of a pulse from 3 m in the free field, whichever block it begins in."""
    pulse = SampledSound(np.eye(1, 64, dtype=np.float32)[0])
    for begin in (700, 1024, 3001):
        hearing = Auralizer(free, OneRoom(None))
        place = np.array([3.0, 0.0, 0.0])
        heard = np.concatenate(
            [hearing.block([Emission("p", pulse, begin, place)], Pose3.identity()) for _ in range(12)], axis=1
        )
        ways = np.linalg.norm(place - free.p_AM, axis=1)
        np.testing.assert_array_equal(np.argmax(heard, axis=1), np.rint(begin + ways / SPEED_OF_SOUND_MPS * RATE))
        energy = np.sum(heard.astype(float) ** 2, axis=1) * ways**2
        np.testing.assert_allclose(energy, 0.85, atol=0.1)  # what passes of a full-band pulse of 1
        np.testing.assert_allclose(energy, energy[0], rtol=0.02)


def test_silence_costs_nothing_and_what_is_too_soft_is_not_computed(free: BaffledMicrophones) -> None:
    hearing = Auralizer(free, OneRoom(ROOM), late_s=0.3, floor=1e-3, voices=2)
    place = np.array([5.0, 2.0, 1.5])
    soft = Emission("soft", sine(), 0, place, gain=1e-4)
    assert not hearing.block([soft], at(2, 2)).any()
    assert hearing.kernels == 0
    loud = [Emission(f"{n}", sine(), 0, place, gain=0.1 * (n + 1)) for n in range(4)]
    for _ in range(3):
        heard = hearing.block([soft, *loud], at(2, 2))
    assert heard.any()
    assert hearing.kernels == 2  # the two loudest


def test_a_voice_that_becomes_inaudible_fades_and_its_echoes_end(free: BaffledMicrophones) -> None:
    hearing = Auralizer(free, OneRoom(ROOM), late_s=0.3)
    source = Emission("s", sine(), 0, np.array([4.0, 2.0, 1.5]))
    for _ in range(20):
        hearing.block([source], at(2, 2))
    ringing = [float(np.abs(hearing.block([], at(2, 2))).max()) for _ in range(60)]
    assert ringing[0] > 0.01
    assert ringing[-1] == 0.0


def test_left_out_blocks_are_left_out_of_the_sound_too(free: BaffledMicrophones) -> None:
    """After a gap the source has gone on: the sine's phase is where it would be."""
    whole, gapped = Auralizer(free, OneRoom(None)), Auralizer(free, OneRoom(None))
    source = [Emission("s", sine(), 0, np.array([2.0, 0.0, 0.0]))]
    expected = [whole.block(source, Pose3.identity()) for _ in range(30)]
    for _ in range(10):
        gapped.block(source, Pose3.identity())
    gapped.skip(5)
    assert gapped.position == 15 * BLOCK
    after = [gapped.block(source, Pose3.identity()) for _ in range(15)]
    np.testing.assert_allclose(np.concatenate(after[2:], 1), np.concatenate(expected[17:], 1), atol=1e-4)
