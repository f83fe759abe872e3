"""Which tracks are reported: moments of one's own, who leads and who only follows, trial, and trust that runs out."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.modules.perception.voices.confirmation import TrackCandidate, TrackerSettings, confirm, reported
from app.modules.perception.voices.kalman import DirectionState

SETTINGS = TrackerSettings()


def source(recent: float, share: float, number: int = 1) -> TrackCandidate:
    motion = DirectionState(np.array([1.0, 0.0, 0.0]), np.zeros(3), 0.01, 0.0, 0.01)
    return TrackCandidate(
        motion, 0.2, 5.0, 0.0, 0.0, 0.0, id=number, recent=recent, share=share, level=recent, heard_s=5.0, last_sure=9.0
    )


@pytest.mark.parametrize(("recent", "share", "confirmed"), [(0.2, 0.5, True), (0.09, 0.5, False), (0.2, 0.1, False)])
def test_proof_takes_a_share_and_a_loud_moment(recent: float, share: float, confirmed: bool) -> None:
    weak, strong = source(recent, share), source(0.4, 1.0, number=2)
    confirm([weak, strong], 0.4, 9.0, SETTINGS)
    assert weak.confirmed is confirmed
    assert strong.confirmed
    assert reported(weak, [weak, strong], 9.0, SETTINGS) is confirmed


def test_a_loud_moment_is_remembered_as_long_as_proof_is() -> None:
    talker = source(0.1, 0.5)
    talker.since_moment_s = SETTINGS.confirmed_s - 0.1
    confirm([talker], 0.4, 9.0, SETTINGS)
    assert reported(talker, [talker], 9.0, SETTINGS)
    talker.since_moment_s = SETTINGS.confirmed_s
    assert not reported(talker, [talker], 9.0, SETTINGS)


def test_who_is_tried_again_is_reported_for_the_trial_and_no_longer() -> None:
    talker = source(0.3, 1.0)
    confirm([talker], 0.3, 9.0, SETTINGS)
    talker.restart_trial(9.0)
    assert not talker.confirmed
    assert math.isinf(talker.since_moment_s)
    talker.last_sure = 9.0 + 0.9 * SETTINGS.trial_s
    assert reported(talker, [talker], talker.last_sure, SETTINGS)
    talker.last_sure = 9.0 + 1.1 * SETTINGS.trial_s
    assert not reported(talker, [talker], talker.last_sure, SETTINGS)


@pytest.mark.parametrize(("echo", "recent", "trusted"), [(0.1, 0.17, True), (0.5, 0.17, False), (0.5, 0.27, True)])
def test_who_may_be_a_copy_needs_a_louder_moment(echo: float, recent: float, trusted: bool) -> None:
    talker = source(recent, 1.0)
    talker.echo, talker.last_gap = echo, 9.0
    confirm([talker], 0.4, 9.0, SETTINGS)
    assert talker.confirmed
    assert reported(talker, [talker], 9.0, SETTINGS) is trusted


@pytest.mark.parametrize("breaks", [False, True])
def test_who_may_be_a_copy_but_sounds_without_a_break_is_trusted(breaks: bool) -> None:
    talker = source(0.17, 1.0)
    talker.echo = 0.5
    talker.restart_trial(1.0)
    times = np.linspace(1.0, 1.0 + 1.5 * SETTINGS.trial_s, 31)
    for k, now in enumerate(times.tolist()):
        talker.last_sure = now if not breaks or k % 10 else talker.last_sure
        confirm([talker], 0.4, now, SETTINGS)
        talker.heard_s += SETTINGS.trial_s / 20
    assert talker.confirmed
    assert reported(talker, [talker], float(times[-1]), SETTINGS) is not breaks


def leading(recent: float, leads: float, share: float = 1.0, number: int = 1) -> TrackCandidate:
    """One that agrees with what begins so many times as well as with the rest."""
    heard = source(recent, share, number)
    heard.add_onsets(np.array([0.1 * leads, 0.1, 1.0, 1.0]), 0.0)
    return heard


@pytest.mark.parametrize(
    ("leads", "echo", "other", "trusted"),
    [
        (1.0, 0.2, 1.4, False),
        (1.07, 0.15, 1.4, True),  # surely no copy
        (1.15, 0.35, 1.4, True),
        (1.15, 0.5, 1.4, False),  # a copy, probably
        (1.3, 0.65, 1.4, False),  # a copy too soon after its source for its onsets to differ
        (1.15, 0.35, 1.8, False),  # what is heard beside it leads by far more
        (0.95, 0.5, 1.2, True),  # too dry a room for echoes, or a sound without onsets, as a fan's
    ],
)
def test_beside_a_louder_one_only_who_leads_is_reported(leads: float, echo: float, other: float, trusted: bool) -> None:
    weak, strong = leading(0.3, leads), leading(0.4, other, number=2)
    weak.echo = echo
    confirm([weak, strong], 0.4, 9.0, SETTINGS)
    assert weak.confirmed
    assert reported(weak, [weak, strong], 9.0, SETTINGS) is trusted
    assert reported(strong, [weak, strong], 9.0, SETTINGS)


@pytest.mark.parametrize(("leads", "echo", "trusted"), [(1.35, 0.4, True), (1.2, 0.4, False), (1.35, 0.5, False)])
def test_who_leads_plainly_need_not_be_loud_for_long(leads: float, echo: float, trusted: bool) -> None:
    weak, strong = leading(0.2, leads, share=0.2), leading(0.4, 1.4, number=2)
    weak.echo = echo
    confirm([weak, strong], 0.4, 9.0, SETTINGS)
    assert not weak.confirmed
    assert reported(weak, [weak, strong], 9.0, SETTINGS) is trusted
    weak.since_moment_s = SETTINGS.confirmed_s
    assert not reported(weak, [weak, strong], 9.0, SETTINGS)


def test_who_is_loudest_need_not_lead() -> None:
    steady, talker = leading(0.4, 1.0), leading(0.3, 1.4, number=2)
    confirm([steady, talker], 0.4, 9.0, SETTINGS)
    assert reported(steady, [steady, talker], 9.0, SETTINGS)


@pytest.mark.parametrize(("sounded", "trusted"), [(0.9, True), (1.1, False)])
def test_what_only_follows_is_reported_for_a_moment(sounded: float, trusted: bool) -> None:
    weak, strong = leading(0.3, 1.0), leading(0.4, 1.4, number=2)
    weak.restart_trial(9.0)
    weak.heard_s = sounded * SETTINGS.soon_s
    weak.last_sure = 9.0 + weak.heard_s
    assert weak.heard_s < SETTINGS.trial_s
    assert reported(weak, [weak, strong], weak.last_sure, SETTINGS) is trusted


def test_nothing_heard_yet_does_not_lead() -> None:
    new = source(0.2, 1.0)
    assert new.leads == 1
    new.add_onsets(np.array([0.2, -0.1, 1.0, 1.0]), 1.0)
    assert new.leads == 1
    new.add_onsets(np.array([0.0, 0.3, 1.0, 1.0]), 0.5)
    assert new.leads == pytest.approx(0.1 / 1.5 / (0.25 / 1.5))
