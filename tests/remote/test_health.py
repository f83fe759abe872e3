"""When a node is used, and when it is not: stepped, without a clock."""

from __future__ import annotations

import math
from itertools import pairwise

from app.remote.health import BEAT_S, GOOD_BEATS, LONGEST_REST_S, MISSED_BEATS, WINDOW, LinkHealth

DEADLINE_S = 0.5


def well(now: float = 0.0) -> LinkHealth:
    health = LinkHealth("desk", DEADLINE_S)
    health.join()
    beats(health, now, GOOD_BEATS)
    assert health.usable
    return health


def beats(health: LinkHealth, now: float, count: int, round_trip_s: float = 0.01) -> float:
    """``count`` beats that are answered; returns the time after them."""
    for _ in range(count):
        health.beat(now)
        health.answered(now + round_trip_s, round_trip_s)
        now += BEAT_S
    return now


def test_a_node_has_to_answer_before_it_is_used() -> None:
    health = LinkHealth("desk", DEADLINE_S)
    assert (health.usable, health.why) == (False, "desk has not joined")
    health.join()
    beats(health, 0.0, GOOD_BEATS - 1)
    assert not health.usable
    beats(health, 1.0, 1)
    assert (health.usable, health.why) == (True, "")


def test_a_node_that_does_not_answer_is_given_up_within_a_second() -> None:
    health, sent = well(), 0
    while health.usable:
        health.beat(10.0 + sent * BEAT_S)
        sent += 1
    # The last of them is sent to find out.
    assert sent == MISSED_BEATS + 1
    assert (MISSED_BEATS + 1) * BEAT_S <= 1.0
    assert health.why == "desk does not answer"


def test_a_program_that_was_held_up_itself_blames_nobody() -> None:
    health = well()
    health.beat(1.0)
    health.beat(31.0)
    assert health.usable


def test_one_late_message_is_no_reason_and_two_of_few_are() -> None:
    health = well()
    health.trip(2.0, math.inf)
    for _ in range(WINDOW):
        health.trip(2.0, 0.1)
    assert health.usable
    health.trip(3.0, 0.6)
    assert health.usable
    health.trip(3.1, 0.7)
    assert not health.usable
    assert health.why == "desk answers too late: p95 0.60 s within 0.5 s"


def test_a_node_whose_module_is_down_is_not_used_and_says_why() -> None:
    health = well()
    health.beat(5.0)
    health.answered(5.0, 0.01, "FaceDetector is failed: no memory")
    assert (health.usable, health.why) == (False, "at desk, FaceDetector is failed: no memory")


def test_it_is_used_again_once_it_is_well_and_rests_longer_each_time() -> None:
    health, now = well(), 1.0
    rests: list[float] = []
    for _ in range(10):
        health.trip(now, math.inf)
        health.trip(now, math.inf)
        assert not health.usable
        failed = now
        while not health.usable:
            now = beats(health, now, 1)
        rests.append(now - failed)
    assert all(after > 1.5 * before for before, after in pairwise(rests[:5]))
    assert rests[0] < 3.0
    assert LONGEST_REST_S <= rests[-1] < LONGEST_REST_S + 1.0


def test_beats_that_come_too_late_prove_nothing() -> None:
    health = LinkHealth("desk", DEADLINE_S)
    health.join()
    beats(health, 0.0, 50, round_trip_s=0.6)
    assert not health.usable


def test_a_node_that_left_is_absent_until_it_joins_again() -> None:
    health = well()
    health.leave("desk is lost")
    beats(health, 5.0, 50)
    assert (health.usable, health.why) == (False, "desk is lost")
    health.join()
    beats(health, 20.0, GOOD_BEATS)
    assert health.usable


def test_beats_that_wait_behind_what_was_sent_are_a_reason() -> None:
    """Sound is not confirmed: only beats say that it piles up."""
    health = well()
    beats(health, 2.0, 2, round_trip_s=0.7)
    assert (health.usable, health.why) == (False, "desk answers too late: p95 0.70 s within 0.5 s")
