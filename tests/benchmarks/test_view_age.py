"""How the benchmark of the view's age reads what a page noted."""

from __future__ import annotations

import math

import pytest

from app.console.live.protocol import CAMERA, VP9_DELTA, VP9_KEY, picture_header
from app.robots.simulated.guard_log import GuardRow
from benchmarks.view_age import Drawn, Watched, case_rows, mean_turn, pictures_of, rows_of


def test_age_is_from_the_stamp_to_the_acknowledgement() -> None:
    noted = [
        (list(picture_header(CAMERA, 7, 100.0, (640, 480), coding=coding)), 5000, 100.12)
        for coding in (0, VP9_KEY, VP9_DELTA)
    ]
    drawn = pictures_of(noted)
    assert [each.vp9 for each in drawn] == [False, True, True]
    assert {(round(each.age, 6), each.size, each.width) for each in drawn} == {(0.12, 5000, 640)}


def test_a_case_has_its_rows_beside_jpeg() -> None:
    def watched(age: float, size: int, *, vp9: bool) -> Watched:
        return Watched(10.0, [Drawn(age, size, 640, vp9)] * 100, program=2.0, renderers=1.0, turned=20.0)

    ours, peers = watched(0.1, 6_000, vp9=True), watched(0.2, 24_000, vp9=False)
    rows = {(each.metric, each.unit): each for each in case_rows("desk", [ours], [peers])}
    assert rows["age p95", "ms"].ratio == pytest.approx(0.5)
    assert (rows["bytes", "kB/s"].ours, rows["bytes", "kB/s"].peer) == (60, 240)
    assert rows["pictures", "1/s"].ours == 10
    assert (rows["as VP9", "%"].ours, rows["as VP9", "%"].peer) == (100, 0)
    assert (rows["program", "ms/picture"].ours, rows["program", "% of a core"].ours) == (20, 20)


def test_cases_without_a_round_are_left_out_and_none_at_all_ends_it_in_words() -> None:
    one = Watched(5.0, [Drawn(0.1, 6_000, 640, vp9=True)], program=0.0, renderers=0.0, turned=0.0)
    rows = rows_of({("desk", None): [], ("desk", 4.0): [(one, one)]})
    assert {each.case for each in rows} == {"desk, 4 Mbit/s"}
    with pytest.raises(SystemExit, match="too busy"):
        rows_of({("desk", None): []})


def test_turning_counts_by_time() -> None:
    rows = [GuardRow(0.0, 0.0, 0.0), GuardRow(5.0, 0.0, 1.0), GuardRow(12.0, 0.0, -0.5), GuardRow(30.0, 0.0, 9.0)]
    assert mean_turn(rows, 10.0, 14.0) == pytest.approx((2 * 1.0 + 2 * 0.5) / 4)
    assert mean_turn(rows[:2], 10.0, 14.0) == pytest.approx(1.0)
    assert mean_turn([], 10.0, 14.0) == 0.0
    assert math.isfinite(mean_turn(rows, 40.0, 50.0))
