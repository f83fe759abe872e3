"""When a robot counts as lost, and how its search begins, goes on and ends; no search is run here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.localization_quality import empty_grid
from app.modules.perception.slam.relocalization import PoseHypothesis, PoseSearch
from app.modules.perception.slam.relocalizer import Relocalizer, SearchStep
from app.modules.perception.slam.types import Match
from tests.modules.perception.slam.places import HALL, scan

SCAN = scan(HALL, Pose2(1.5, 3.0), 1.0)
OTHER = scan(HALL, Pose2(2.0, 3.0), 1.1)


@dataclass(eq=False)
class Search:
    """In the place of a search; each is another."""


def search() -> PoseSearch:
    return cast(PoseSearch, Search())


def relocalizer() -> Relocalizer:
    return Relocalizer(lost_after_s=1.0, search_after_s=2.0, sure_after_s=1.0)


def match(stamp: float, inliers: float) -> Match:
    return Match(
        stamp, Pose2(), X_MO=Pose2(), covariance=np.eye(3), overlap=1.0, inliers=inliers, matched=inliers > 0.25,
        keyframe=0, X_KB=Pose2(), added=False, moved=False,
    )  # fmt: skip


def hypothesis(x: float, score: float) -> PoseHypothesis:
    return PoseHypothesis(Pose2(x), score, worst=0.5, explained=np.zeros(0, np.int8), so_far=(0.0, 0))


def step(of: Relocalizer) -> SearchStep:
    found = of.next_step()
    assert found is not None
    return found


def test_misfitting_scans_make_it_lost_and_then_call_for_a_search() -> None:
    one = relocalizer()
    states = []
    for tenth in range(30):
        one.see(match(tenth / 10, 0.9 if tenth < 5 else 0.3), grows=False)
        states.append((one.lost, one.search_needed(tenth / 10)))
    assert states.index((True, False)) == 15
    assert states.index((True, True)) == 25
    assert one.doubtful
    one.request()
    assert not one.search_needed(5.0), "once is enough"
    assert one.due


def test_on_a_growing_map_few_misfits_count_for_nothing_and_trust_comes_back_late() -> None:
    one = relocalizer()
    one.see(match(0.0, 0.9), grows=True)
    one.see(match(60.0, 0.1), grows=True)
    one.see(match(120.0, 0.1), grows=True)
    assert not one.lost
    one.see(match(180.0, 0.1), grows=True)
    assert one.lost
    for tenth in range(30):
        one.see(match(181.0 + tenth / 10, 0.7), grows=True)
    assert one.lost, "a similar place may fit as well"
    for tenth in range(13):
        one.see(match(185.0 + tenth / 10, 0.9), grows=True)
    assert not one.lost


def test_each_step_of_a_search_has_the_newest_scan_and_what_landmarks_said_since() -> None:
    one = relocalizer()
    one.request()
    assert one.next_step() is None
    assert one.due
    first = search()
    one.begin(first)
    assert one.running
    assert not one.due
    assert one.next_step() is None, "no scan yet"
    one.suggest(Pose2(1.0))
    one.offer(SCAN, Pose2(0.1))
    one.offer(OTHER, Pose2(0.2))
    taken = step(one)
    assert (taken.search, taken.scan, taken.X_OB, taken.suggested) == (first, OTHER, Pose2(0.2), (Pose2(1.0),))
    assert one.next_step() is None, "no scan is given twice"
    one.offer(SCAN, Pose2(0.3))
    assert step(one).suggested == ()


def test_of_many_suggestions_the_newest_are_kept() -> None:
    one = relocalizer()
    one.begin(search())
    for x in range(20):
        one.suggest(Pose2(float(x)))
    one.offer(SCAN, Pose2())
    assert [X_MO.x for X_MO in step(one).suggested] == [12, 13, 14, 15, 16, 17, 18, 19]


def test_a_step_of_a_search_that_ended_belongs_to_no_other() -> None:
    one = relocalizer()
    one.begin(search())
    one.offer(SCAN, Pose2())
    late = step(one)
    assert one.belongs(late)
    one.end()
    assert not one.belongs(late)
    one.begin(search())
    assert not one.belongs(late)


def test_where_nothing_can_be_searched_on_the_request_is_over() -> None:
    one = relocalizer()
    one.request()
    one.begin(None)
    assert not one.due
    assert not one.running
    assert not one.doubtful


def test_scans_that_fit_after_all_end_a_search() -> None:
    one = relocalizer()
    for tenth in range(25):
        one.see(match(tenth / 10, 0.9 if tenth == 0 else 0.3), grows=False)
    one.request()
    one.begin(search())
    ended = [one.see(match(2.5 + tenth / 10, 0.9), grows=False) for tenth in range(20)]
    assert ended.count(True) == 1
    assert not one.running
    assert not one.doubtful


def test_a_new_pose_that_is_doubted_is_lost_until_scans_fit_there() -> None:
    one = relocalizer()
    one.end(doubted=True)
    assert one.doubtful
    for tenth in range(12):
        one.see(match(tenth / 10, 0.65), grows=True)
    assert not one.lost


def test_without_hypotheses_the_robot_may_be_anywhere_on_the_map() -> None:
    one, grid = relocalizer(), empty_grid(0.05, 12.0)
    X_OB, last = Pose2(1.0, 0.5, 0.3), Pose2(2.0, 1.0, -0.2)
    place = one.localization(4.0, X_OB, last, grid)
    assert (place.stamp, place.state, place.overlap, place.map) == (4.0, "searching", 0.0, "")
    assert last == place.X_MO
    assert last @ X_OB == place.X_MB
    assert math.sqrt(place.covariance[0, 0]) == pytest.approx(12.0 / math.sqrt(12))
    one.take((hypothesis(5.0, 0.7), hypothesis(7.0, 0.6)))
    place = one.localization(5.0, X_OB, last, grid)
    assert Pose2(5.0) == place.X_MO
    assert place.overlap == 0.7
    assert math.sqrt(place.covariance[0, 0]) == pytest.approx(math.hypot(math.sqrt(2.0), 0.3))
