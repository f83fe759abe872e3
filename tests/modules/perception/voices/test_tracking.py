"""Tracks of sources whose truth is known: numbers that stay, births, deaths, crossings, a robot that turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.modules.perception.voices.localization import NO_PEAKS, Peaks
from app.modules.perception.voices.tracking import SoundTrack, Tracker

STEP_S = 2048 / 48_000


def unit(azimuth_deg: float, elevation_deg: float = 15.0) -> NDArray[np.float64]:
    a, e = np.radians([azimuth_deg, elevation_deg])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def leading(*leads: float) -> NDArray[np.float64]:
    """Onsets of peaks that agree with what begins so many times as well as with the rest: 1.4 talkers, 1 echoes."""
    return np.array([[0.1 * times, 0.1, 1.0, 1.0] for times in leads]).reshape(-1, 4)


def seen(*azimuths: float, power: float = 0.2, recent: float = 0.2, echo: float = 0.0, leads: float = 1.4) -> Peaks:
    """Peaks at these azimuths, all alike."""
    count = len(azimuths)
    directions = np.array([unit(azimuth) for azimuth in azimuths]).reshape(-1, 3)
    echoes = np.full(count, echo)
    return Peaks(
        directions, np.full(count, power), np.full(count, recent), echoes, directions, leading(*[leads] * count)
    )


def angle(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


def test_a_source_is_born_at_once_if_strong_and_keeps_its_number() -> None:
    tracker = Tracker()
    born = [tracker.update(k * STEP_S, seen(30)) for k in range(50)]
    first = next(k for k, tracks in enumerate(born) if tracks)
    assert first <= 2
    assert {track.id for tracks in born for track in tracks} == {1}
    last = born[-1][0]
    assert angle(last.direction, unit(30)) < 1
    assert last.active
    assert last.born == first * STEP_S
    assert last.last_seen == 49 * STEP_S


def test_a_weak_one_must_go_on_longer_and_an_echo_never_becomes_one() -> None:
    patient, deaf = Tracker(), Tracker()
    waited = next(k for k in range(100) if patient.update(k * STEP_S, seen(30, power=0.03, recent=0.03)))
    assert waited * STEP_S > 0.2
    assert not any(deaf.update(k * STEP_S, seen(30, power=0.1, echo=0.7, leads=1.0)) for k in range(100))


def test_what_begins_of_itself_becomes_one_however_alike() -> None:
    tracker = Tracker()
    assert any(tracker.update(k * STEP_S, seen(30, power=0.1, echo=0.7)) for k in range(20))


def with_second(powers: tuple[float, float], recents: tuple[float, float], leads: float = 1.4) -> Peaks:
    """A strong peak at 30 degrees and another at 150, which may be its echo or not."""
    directions = np.array([unit(30), unit(150)])
    onsets = leading(1.4, leads)
    return Peaks(directions, np.array(powers), np.array(recents), np.array([0.0, 0.4]), directions, onsets)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_what_only_ever_follows_another_is_not_reported_for_long(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracker = Tracker()
    loud = 0.1 + 0.3 * np.repeat(rng.uniform(size=40), 4)
    reported = 0
    for k, power in enumerate(loud):
        # As loud in each syllable as its source lets it be; where that is silent, so is this.
        tracks = tracker.update(k * STEP_S, with_second((0.3, 0.1), (power, 0.5 * power), 1.0))
        reported += sum(bool(track.direction @ unit(150) > 0.9) for track in tracks)
    assert tracks[0].direction @ unit(30) > 0.9
    assert reported * STEP_S < 1


@pytest.mark.parametrize(("leads", "reported"), [(1.0, False), (1.4, True)])
def test_an_echo_that_is_loud_at_times_is_not_reported_for_long(leads: float, reported: bool) -> None:
    tracker = Tracker()
    for k in range(40):
        # Between two walls it goes on when its source is silent for a moment, and is then louder.
        recents = (0.1, 0.25) if k % 10 == 9 else (0.3, 0.2)
        tracks = tracker.update(k * STEP_S, with_second((0.3, 0.2), recents, leads))
    assert (len(tracks) == 2) is reported


def test_a_weak_one_who_sounds_in_anothers_pauses_is_reported() -> None:
    tracker = Tracker()
    for k in range(100):
        pause = k % 12 < 2
        tracks = tracker.update(k * STEP_S, with_second((0.3, 0.1), (0.05, 0.25) if pause else (0.3, 0.05)))
    assert [track.id for track in tracks] == [1, 2]


def test_what_a_room_leaves_in_a_talkers_pauses_is_not_reported_for_long() -> None:
    tracker = Tracker()
    reported = 0
    for k in range(200):
        pause = k % 50 > 30
        # Louder than the talker in his pauses, since he says nothing then, but never as loud as he was.
        powers, recents = ((0.03, 0.04), (0.0, 0.05)) if pause else ((0.3, 0.05), (0.3, 0.05))
        tracks = tracker.update(k * STEP_S, with_second(powers, recents, 1.0))
        reported += sum(bool(track.direction @ unit(150) > 0.9) for track in tracks)
    assert [track.id for track in tracks] == [1]
    assert reported * STEP_S < 1


def with_third(azimuth: float, powers: tuple[float, float], recents: tuple[float, float]) -> Peaks:
    """A strong peak at 120 degrees and another at ``azimuth``."""
    directions = np.array([unit(120), unit(azimuth)])
    echoes = np.array([0.0, 0.2])
    return Peaks(directions, np.array(powers), np.array(recents), echoes, directions, leading(1.4, 1.4))


def test_what_never_has_a_loud_moment_is_not_reported_for_long() -> None:
    tracker = Tracker()
    reported = 0
    for k in range(150):
        # The search finds it half as strong as the talker, as a wall in a live room; it never sounds louder by itself.
        tracks = tracker.update(k * STEP_S, with_second((0.3, 0.16), (0.3 if k % 10 else 0.15, 0.1)))
        reported += sum(bool(track.direction @ unit(150) > 0.9) for track in tracks)
    assert [track.id for track in tracks] == [1]
    assert reported * STEP_S < 1


def test_what_takes_a_silent_tracks_number_does_not_take_its_credit() -> None:
    tracker = Tracker()
    reported = 0
    for k in range(110):
        now = k * STEP_S
        if k < 40:
            peaks = seen(12 * now, 120) if k >= 26 else seen(120)
        elif 66 <= k < 72:
            # The talker is silent and no longer reported when a wall sounds aside for a moment.
            peaks = with_third(12 * 66 * STEP_S + 18, (0.3, 0.15), (0.3, 0.1))
        else:
            peaks = seen(120)
        tracks = tracker.update(now, peaks)
        if k == 65:
            assert [track.id for track in tracks] == [1]
        reported += k > 65 and any(track.id == 2 for track in tracks)
    assert reported * STEP_S < 0.8


def test_proof_is_earned_again_and_again() -> None:
    tracker = Tracker()
    for k in range(25):
        tracks = tracker.update(k * STEP_S, with_second((0.3, 0.2), (0.3, 0.3)))
    assert [track.id for track in tracks] == [1, 2]
    for k in range(25, 90):
        tracks = tracker.update(k * STEP_S, with_second((0.3, 0.08), (0.3, 0.1)))
    assert [track.id for track in tracks] == [1]


def test_what_the_search_does_not_find_is_soon_silent() -> None:
    tracker = Tracker()
    for k in range(50):
        tracker.update(k * STEP_S, seen(30))
    # A side lobe of someone else's: the short mean has it, the search has not.
    tracks = [tracker.update(k * STEP_S, seen(30, power=0.0, recent=0.1)) for k in range(50, 130)]
    assert tracks[5]
    assert not tracks[-1]


def test_a_walker_who_paused_has_one_track_where_he_goes_on() -> None:
    tracker = Tracker()
    for k in range(140):
        now = k * STEP_S
        pauses = 50 <= k < 68
        # Reverberation in the pause is where the talker was.
        peaks = seen(12 * 50 * STEP_S, power=0.03, recent=0.02) if pauses else seen(12 * now)
        tracks = tracker.update(now, peaks)
    assert [track.id for track in tracks] == [1]
    assert angle(tracks[0].direction, unit(12 * now)) < 3


def speed_radps(track: SoundTrack) -> float:
    """To the left, degrees a second."""
    return float(np.degrees(np.cross([0, 0, 1], track.direction) @ track.velocity))


def test_what_a_walkers_pause_leaves_beside_another_does_not_turn_him_round() -> None:
    tracker = Tracker()
    steady = np.array([[np.nan] * 3, unit(120)])
    for k in range(65):
        now = k * STEP_S
        pauses = k >= 50
        # An echo of a person who walks the other way moves along, a third as loud as the walker was.
        azimuth = 12 * 50 * STEP_S - 4 * (k - 50) * STEP_S if pauses else 12 * now
        powers, recents = np.array([0.12 if pauses else 0.3, 0.3]), np.array([0.12 if pauses else 0.35, 0.3])
        directions = np.array([unit(azimuth), unit(120)])
        tracks = tracker.update(now, Peaks(directions, powers, recents, np.full(2, 0.2), steady, leading(1.4, 1.4)))
    assert [track.id for track in tracks] == [1, 2]
    assert speed_radps(tracks[0]) > 2
    assert angle(tracks[0].direction, unit(12 * now)) < 7


def test_a_walker_lost_and_heard_again_goes_on_as_he_went() -> None:
    tracker = Tracker()
    for k in range(78):
        now = k * STEP_S
        # Farther on than predicted, too far to count at once as the same source.
        peaks = NO_PEAKS if 50 <= k < 75 else seen(12 * now + 25 * (k >= 75))
        tracks = tracker.update(now, peaks)
    assert [track.id for track in tracks] == [1]
    assert angle(tracks[0].direction, unit(12 * now + 25)) < 4
    assert speed_radps(tracks[0]) > 6


def test_what_is_only_remembered_and_no_longer_heard_dies() -> None:
    tracker = Tracker()
    for k in range(25):
        tracker.update(k * STEP_S, seen(30))
    tracks = [tracker.update(k * STEP_S, seen(30, recent=0.001)) for k in range(25, 125)]
    assert tracks[20][0].id == 1
    assert not tracks[20][0].active
    assert not tracks[-1]


def test_a_short_silence_ends_nothing() -> None:
    tracker = Tracker()
    for k in range(25):
        tracker.update(k * STEP_S, seen(30))
    for k in range(25, 45):
        tracker.update(k * STEP_S, NO_PEAKS)
    assert [track.id for track in tracker.update(45 * STEP_S, seen(32))] == [1]


def test_a_walker_is_led_without_lag() -> None:
    tracker = Tracker()
    for k in range(100):
        now = k * STEP_S
        # What was heard is 50 ms old, as the mean over it is; in the long mean it is 0.4 s old.
        peaks = seen(12 * (now - 0.05))
        peaks = replace(peaks, steady=unit(12 * (now - 0.4))[None])
        tracks = tracker.update(now, peaks)
    assert angle(tracks[0].direction, unit(12 * now)) < 1
    assert abs(np.degrees(np.linalg.norm(tracks[0].velocity)) - 12 * np.cos(np.radians(15))) < 3
    assert abs(tracks[0].velocity @ tracks[0].direction) < 1e-9


def test_two_that_cross_keep_their_numbers() -> None:
    tracker = Tracker()
    for k in range(160):
        now = k * STEP_S
        left, right = 40 - 12 * now, -40 + 12 * now
        # Nearer than 7 degrees they are one peak.
        tracks = tracker.update(now, seen(left, right) if abs(left - right) > 7 else seen((left + right) / 2))
        if k == 40:
            numbers = {track.id: track.direction @ unit(90) > 0 for track in tracks}
    assert {track.id: track.direction @ unit(90) < 0 for track in tracks} == numbers
    assert len(numbers) == 2


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(-180, 180), max_size=8), st.integers(0, 1000))
def test_there_are_never_more_than_four_and_numbers_are_never_used_again(azimuths: list[float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracker = Tracker()
    highest = 0
    for k in range(40):
        here = [azimuth + rng.normal(0, 1) for azimuth in azimuths if rng.uniform() < 0.8]
        tracks = tracker.update(k * STEP_S, seen(*here, power=float(rng.uniform(0, 0.3))))
        numbers = [track.id for track in tracks]
        assert len(numbers) <= 4
        assert numbers == sorted(set(numbers))
        new = [number for number in numbers if number > highest]
        assert new == list(range(highest + 1, highest + 1 + len(new)))
        highest = max([highest, *numbers])
        for track in tracks:
            assert abs(np.linalg.norm(track.direction) - 1) < 1e-9
            assert abs(track.direction @ track.velocity) < 1e-6
            assert track.born <= track.last_seen + 0.3


@settings(max_examples=10, deadline=None)
@given(st.lists(st.floats(0, 0.019), min_size=1, max_size=4))
def test_a_silent_room_gives_none(powers: list[float]) -> None:
    tracker = Tracker()
    azimuths = np.linspace(-90, 90, len(powers))
    for k in range(60):
        directions = np.array([unit(azimuth) for azimuth in azimuths])
        silence = np.zeros(len(powers))
        peaks = Peaks(directions, np.array(powers), np.array(powers) / 2, silence, directions, leading(*silence))
        assert not tracker.update(k * STEP_S, peaks)
