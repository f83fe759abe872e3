"""The shoebox against what is known of rooms: images, spreading, decay, and how alike a diffuse field is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from app.base.geometry import Pose3
from app.robots.simulated.acoustics.diffraction import SPEED_OF_SOUND_MPS, BaffledMicrophones
from app.robots.simulated.acoustics.room import (
    MOUTH_MEAN,
    Shoebox,
    diffuse_noise,
    images,
    mouth,
    response,
)
from tests.robots.simulated.acoustics.decay import reverberation_time

RATE = 48000
ROOM = Shoebox((1.0, 2.0, 0.0), (6.0, 5.0, 3.0), (0.45, 0.45))
X_WA = Pose3.from_translation_rpy((3.0, 4.0, 1.0), (0.0, 0.0, 0.4))
P_WS = (5.2, 3.1, 1.6)


def test_the_first_images_are_the_source_mirrored_in_each_wall() -> None:
    found = images(ROOM, P_WS, X_WA.translation, 12.0)
    np.testing.assert_allclose(found.p_W[0], P_WS)
    mirrored = [(2 * 1 - 5.2, 3.1, 1.6), (2 * 7 - 5.2, 3.1, 1.6), (5.2, 2 * 2 - 3.1, 1.6), (5.2, 2 * 7 - 3.1, 1.6),
                (5.2, 3.1, -1.6), (5.2, 3.1, 2 * 3 - 1.6)]  # fmt: skip
    for place in mirrored:
        number = int(np.argmin(np.linalg.norm(found.p_W - place, axis=1)))
        np.testing.assert_allclose(found.p_W[number], place, atol=1e-9)
        assert found.gains[number, 0] == pytest.approx(
            ROOM.reflection[0] * 10 ** (-0.003 * found.distances[number] / 20)
        )
        # The way from the true source by that wall: it leaves toward the wall
        toward = (np.array(place) - P_WS) / np.linalg.norm(np.array(place) - P_WS)
        assert found.departures[number] @ toward > 0


def test_images_fill_space_as_rooms_fill_it() -> None:
    reach = 30.0
    count = images(ROOM, P_WS, X_WA.translation, reach).distances.size
    assert count == pytest.approx(4 / 3 * math.pi * reach**3 / ROOM.volume_m3, rel=0.05)


@pytest.mark.parametrize("rt60_s", [0.3, 0.6])
@pytest.mark.parametrize("shadow", [False, True])
def test_reverberation_dies_away_as_asked(
    shaded: BaffledMicrophones, free: BaffledMicrophones, rt60_s: float, shadow: bool
) -> None:
    room = Shoebox(ROOM.corner, ROOM.size, (rt60_s, rt60_s))
    impulses = response(room, P_WS, X_WA, shaded if shadow else free, early_s=0.03)
    assert reverberation_time(impulses, RATE) == pytest.approx(rt60_s, rel=0.15)


def test_the_handover_from_images_to_statistics_keeps_the_energy(free: BaffledMicrophones) -> None:
    soon, later = (response(ROOM, P_WS, X_WA, free, early_s=s) for s in (0.02, 0.1))
    # Above the room's single modes, where images still add up in step
    soon, later = (sosfilt(butter(4, 200, "high", fs=RATE, output="sos"), h) for h in (soon, later))
    assert 10 * math.log10(np.sum(soon**2) / np.sum(later**2)) == pytest.approx(0.0, abs=0.7)
    levels = [float(np.mean(later[:, start : start + 960] ** 2)) for start in range(3000, 9000, 960)]
    steps = np.diff(10 * np.log10(levels))
    assert np.all(np.abs(steps + 60 * 0.02 / 0.45) < 3.0)  # dB in 20 ms, also where one gives way to the other


def test_the_late_field_is_as_alike_between_microphones_as_a_diffuse_one() -> None:
    apart = 0.2
    pair = BaffledMicrophones(np.array([[-apart / 2, 0, 0], [apart / 2, 0, 0]]), RATE, shadow=False)
    noise = diffuse_noise(pair, 1 << 17, 3).sum(0)
    frames = np.fft.rfft(noise.reshape(2, -1, 512) * np.hanning(512))
    cross = np.mean(frames[0] * np.conj(frames[1]), axis=0).real
    coherence = cross / np.sqrt(np.prod(np.mean(np.abs(frames) ** 2, axis=1), axis=0))
    f = np.fft.rfftfreq(512, 1 / RATE)
    band = (f > 200) & (f < 4000)
    expected = np.sinc(2 * f * apart / SPEED_OF_SOUND_MPS)
    assert np.sqrt(np.mean((coherence - expected)[band] ** 2)) < 0.12


def test_delays_and_levels_of_the_direct_sound_do_not_depend_on_the_room(free: BaffledMicrophones) -> None:
    outdoors, indoors = response(None, P_WS, X_WA, free), response(ROOM, P_WS, X_WA, free)
    direct = round(float(np.linalg.norm(np.array(P_WS) - X_WA.translation)) / SPEED_OF_SOUND_MPS * RATE)
    np.testing.assert_allclose(indoors[:, : direct + 40], outdoors[:, : direct + 40], atol=1e-5)


def test_a_mouth_is_louder_in_front_and_more_so_at_high_frequencies() -> None:
    front, side, back = mouth(np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0]]), np.array([1.0, 0, 0]))
    np.testing.assert_allclose(front, 1.0)
    assert np.all(back < side)
    assert np.all(side < front)
    np.testing.assert_allclose(20 * np.log10(back), [-4.0, -14.0], atol=0.2)
    rng = np.random.default_rng(1)
    everywhere = rng.standard_normal((20000, 3))
    everywhere /= np.linalg.norm(everywhere, axis=1)[:, None]
    rms = np.sqrt(np.mean(mouth(everywhere, np.array([0, 0, 1.0])) ** 2, axis=0))
    np.testing.assert_allclose(MOUTH_MEAN, rms, rtol=0.02)


def test_points_at_and_beyond_the_walls_are_brought_inside() -> None:
    assert ROOM.contains((3, 3, 1))
    assert not ROOM.contains((0.9, 3, 1))
    assert ROOM.contains((0.9, 3, 1), margin_m=0.2)
    assert ROOM.contains(ROOM.clamp((-5.0, 9.0, -1.0)))
