"""Scores of tracks by hand-made cases."""

from __future__ import annotations

import pytest

from benchmarks.tracking_metrics import Frame, Hypothesis, score

A, B = (0.0, 0.0), (5.0, 0.0)


def at(*found: tuple[int, int | None, tuple[float, float]]) -> list[Hypothesis]:
    return [Hypothesis(track, identity, place) for track, identity, place in found]


def test_two_objects_with_their_own_identities_are_perfect() -> None:
    scores = score([Frame({"a": A, "b": B}, at((1, 1, A), (2, 2, B)))] * 10, 1.0)
    assert (scores.mota, scores.idf1, scores.swaps, scores.identities) == (1.0, 1.0, 0, 2)


def test_one_missed_of_two_and_one_false_cost_a_half_each() -> None:
    scores = score([Frame({"a": A, "b": B}, at((1, 1, A), (2, 2, (9.0, 9.0))))] * 10, 1.0)
    assert (scores.misses, scores.false, scores.objects) == (10, 10, 20)
    assert scores.mota == 0.0
    assert scores.idf1 == pytest.approx(2 * 10 / (20 + 20))


def test_exchanged_identities_are_two_swaps_and_half_of_idf1() -> None:
    before, after = at((1, 1, A), (2, 2, B)), at((1, 2, A), (2, 1, B))
    scores = score([*[Frame({"a": A, "b": B}, before)] * 5, *[Frame({"a": A, "b": B}, after)] * 5], 1.0)
    assert scores.swaps == 2
    assert scores.mota == pytest.approx(1 - 2 / 20)
    assert scores.idf1 == pytest.approx(0.5)


def test_a_second_identity_of_an_object_counts_as_wrong_from_then_on() -> None:
    frames = [Frame({"a": A}, at((1, 1, A)))] * 6 + [Frame({"a": A}, at((2, 2, A)))] * 4
    scores = score(frames, 1.0)
    assert (scores.swaps, scores.identities) == (1, 2)
    assert scores.idf1 == pytest.approx(0.6)


def test_unsure_is_found_and_no_swap_and_yet_not_identified() -> None:
    frames = [Frame({"a": A}, at((1, identity, A))) for identity in (1, None, None, 1)]
    scores = score(frames, 1.0)
    assert (scores.mota, scores.swaps, scores.identities, scores.unsure) == (1.0, 0, 1, 0.5)
    assert scores.idf1 == pytest.approx(0.5)


def test_what_stands_at_an_ignored_object_is_not_false() -> None:
    scores = score([Frame({"a": A}, at((1, 1, A), (2, 2, B)), ignored={"b": B})], 1.0)
    assert (scores.false, scores.mota, scores.idf1) == (0, 1.0, 1.0)


def test_a_pair_stays_while_near_though_another_is_nearer() -> None:
    near = at((1, 1, (0.4, 0.0)), (2, 2, (0.1, 0.0)))
    scores = score([Frame({"a": A}, at((1, 1, A))), Frame({"a": A}, near)], 1.0)
    assert (scores.swaps, scores.false, scores.identities) == (0, 1, 1)
