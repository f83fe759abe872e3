"""A group: who comes along is counted, and who is missing is looked for, called, and driven back for."""

from __future__ import annotations

import itertools
import math

import pytest

from app.base.geometry import Pose2
from app.modules.motivations.tour_guide.company import DIRECTIONS, MAY_BE_FAR_S
from app.modules.motivations.tour_guide.perceptions import perceptions
from app.modules.motivations.tour_guide.progress import Ended
from app.modules.motivations.tour_guide.visitors import FOUND_S, SEEN_S, Visitors
from app.modules.motivations.tour_guide.waiting import (
    ASTRAY_M,
    GOES_BACK_FOR_ALL_S,
    GOES_BACK_S,
    LOOKED_S,
    LOOKS_S,
)
from tests.modules.motivations.tour_guide.run import Run

#: Where all were seen last, on the map.
BACK = (3.0, 4.0)


def looking_back(people: int = 1) -> Run:
    """Two came along; as the robot looks back, it sees so many."""
    run = Run().started().until("leading").see(people=0, driven_m=5.1, back=BACK, behind=3.0)
    assert run.progress.state == "waiting"
    return run.see(people=people, farthest_m=1.5 if people else 0.0)


def test_it_does_not_go_on_when_one_of_two_is_seen() -> None:
    run = looking_back()
    assert run.see(after_s=10).progress.state == "waiting"
    assert (run.texts(), run.progress.reason) == (["I am waiting for you."], "1 of 2 visitors are seen")
    assert run.see(people=2).progress.state == "leading"


def test_it_looks_along_its_way_then_to_the_other_side_for_who_is_missing() -> None:
    run = looking_back().see(towards=1.0, looked_s=0.0)
    assert [wish.cls for wish in run.wishes()] == ["LookAt", "RotateToHeading"], "the head would stay at who is near"
    assert run.wish("RotateToHeading").params == {"heading": 3.0}
    run.see(after_s=LOOKS_S)
    assert run.wish("RotateToHeading").params == {"heading": round(3.0 - math.pi, 2)}
    run.see(people=2, farthest_m=3.5, looked_s=9.0)
    assert run.see().see().wish("RotateToHeading").params == {"heading": 1.0}, "to those who are there"
    assert run.wish("TrackFace").params == {}


@pytest.mark.parametrize(("behind", "towards"), [(3.0, None), (None, 1.0), (None, None)])
def test_where_nobody_is_seen_it_looks_all_around(behind: float | None, towards: float | None) -> None:
    run = looking_back(people=0).see(back=None, behind=behind, towards=towards)
    headings = []
    for _ in range(7):
        run.see(after_s=LOOKS_S)
        headings += [wish.params["heading"] for wish in run.wishes() if wish.cls == "RotateToHeading"]
    assert run.progress.state == "waiting"
    for quarter in range(4):
        there = (behind or towards or 0.0) + quarter * math.pi / 2
        assert any(math.cos(heading - there) > 0.99 for heading in headings)
    assert run.see(people=2, farthest_m=1.5, towards=-2.0, looked_s=2.0).see().progress.state == "leading"


def test_it_drives_back_for_who_is_missing_and_leads_on_once_all_are_seen() -> None:
    run = looking_back().see(after_s=GOES_BACK_S)
    assert run.progress.state == "searching"
    going = {"x": 3.0, "y": 4.0, "tolerance_m": 0.5, "speed": 0.4}
    assert (run.wish("GoTo").params, run.texts()) == (going, ["I am coming back for you."])
    assert {"faces", "slam"} <= {wish.key for wish in perceptions(run.progress, run.scene)}
    stuck = run.view.now
    assert run.see(stuck_since=stuck, after_s=8.5).texts()[-1] == "Excuse me, may I pass?"
    assert run.see(people=2, farthest_m=3.5).progress.state == "waiting", "they are there, and come"
    assert run.see(farthest_m=2.0).progress.state == "leading"
    assert run.wish("GoTo").params["place"] == "one"


def test_it_drives_back_for_all_of_them_too() -> None:
    run = looking_back(people=0).see(after_s=GOES_BACK_FOR_ALL_S - 0.2)
    assert run.progress.state == "waiting"
    assert run.see(after_s=0.3).progress.state == "searching"


@pytest.mark.parametrize("reached", [True, False])
def test_where_it_saw_them_last_it_waits_and_drives_back_no_farther(reached: bool) -> None:
    run = looking_back().see(after_s=GOES_BACK_S)
    run.see(Ended(run.wish("GoTo").key, reached))
    assert run.see(after_s=GOES_BACK_S + 1).progress.state == "waiting"


def test_it_stays_where_it_saw_them_last() -> None:
    assert looking_back().see(back=None, after_s=GOES_BACK_S).progress.state == "waiting"


def looked_around(run: Run, beat_s: float = 0.25) -> list[float]:
    """The robot turns at once to wherever it wants to look; the headings, until it looks for them no more."""
    headings: list[float] = []
    looked_s = 0.0
    for _ in range(round(DIRECTIONS * LOOKS_S / beat_s)):
        if run.progress.state not in ("waiting", "searching"):
            return headings
        turns = [wish.params["heading"] for wish in run.wishes() if wish.cls == "RotateToHeading"]
        looked_s = looked_s + beat_s if turns == headings[-1:] else 0.0
        headings += turns if turns != headings[-1:] else []
        run.see(after_s=beat_s, looked_s=looked_s)
    raise AssertionError(f"it looks still: {run.progress}")


@pytest.mark.parametrize("state", ["waiting", "searching"])
def test_it_calls_and_looks_all_around_before_it_ends(state: str) -> None:
    run = looking_back(people=0).see(after_s=GOES_BACK_FOR_ALL_S if state == "searching" else 1.0)
    assert run.progress.state == state
    run.see(after_s=60.0).see()
    assert (run.progress.state, run.texts()) == ("waiting", ["Are you still with me?"])
    assert run.progress.reason == "no visitor is seen; it looks all around"
    began = run.view.now
    headings = looked_around(run)
    for degrees in range(0, 360, 10):
        nearest = max(math.cos(math.radians(degrees) - heading) for heading in headings)
        assert nearest > math.cos(math.pi / DIRECTIONS + 0.02), f"it never looked towards {degrees} degrees"
    assert run.view.now - began >= DIRECTIONS * LOOKED_S
    assert (run.progress.state, run.progress.reason) == ("parting", "all visitors have left")


def test_those_who_followed_behind_it_are_found_as_it_looks_all_around() -> None:
    run = looking_back(people=0).see(after_s=GOES_BACK_FOR_ALL_S).see(after_s=60.0).see().see(after_s=5.0)
    assert run.see(people=1, farthest_m=1.5).progress.state == "waiting", "the other may be near, too"
    assert run.see(people=2).progress.state == "leading"
    run.see(people=0, driven_m=10.3).see(after_s=61.0).see()
    assert run.texts()[-1] == "Are you still with me?", "the next time it looks all around once more"


def test_who_was_seen_as_it_looked_all_around_is_there_in_the_end() -> None:
    run = looking_back(people=0).see(back=None).see(after_s=60.0).see().see(people=1, farthest_m=1.5)
    run.see(people=0, farthest_m=0.0)
    looked_around(run)
    assert (run.progress.state, run.progress.reason) == ("leading", "1 of 2 visitors are seen; it goes on")
    assert run.progress.company.size == 1
    assert run.progress.company.apart_m == run.scene.tour.pace.wait_m, "where they are now is not known"


def test_it_looks_all_around_though_it_cannot_turn() -> None:
    run = looking_back(people=0).see(back=None, looked_s=0.0).see(after_s=60.0)
    for _ in range(DIRECTIONS):
        assert run.progress.state == "waiting"
        run.see(after_s=LOOKS_S)
    assert run.progress.state == "parting"


def test_it_looks_first_to_a_voice_that_answers() -> None:
    run = looking_back(people=0).see(back=None).see(after_s=60.0).see(speaking=True, towards=-1.1).see()
    assert run.wish("RotateToHeading").params == {"heading": -1.1}


def test_it_drives_back_along_no_other_way() -> None:
    run = looking_back().see(after_s=GOES_BACK_S).see(astray_m=ASTRAY_M - 0.1)
    assert run.progress.state == "searching"
    run.see(astray_m=ASTRAY_M + 0.1)
    assert (run.progress.state, run.progress.reason) == ("waiting", "visitors are in its way back")
    assert run.see(people=2, farthest_m=1.5).progress.state == "leading"


@pytest.mark.parametrize("state", ["waiting", "searching"])
def test_in_the_end_it_goes_on_without_and_says_so(state: str) -> None:
    run = looking_back().see(after_s=GOES_BACK_S if state == "searching" else 1.0)
    assert run.progress.state == state
    run.see(after_s=60.0).see()
    assert (run.progress.state, run.texts()) == ("waiting", ["Are you still with me?"])
    looked_around(run)
    assert (run.progress.state, run.texts()) == ("leading", ["I go on with those who are here."])
    assert run.progress.reason == "1 of 2 visitors are seen; it goes on"
    run.see(people=0, driven_m=10.3).see(people=1)
    assert run.progress.state == "leading", "who has left is not waited for again"
    run.see(people=0, driven_m=15.5).see(people=2).see(people=0, driven_m=20.7).see(people=1)
    assert run.see(after_s=5.0).progress.state == "waiting", "who is back is"


def test_who_was_seen_since_it_looks_is_there_though_out_of_sight() -> None:
    assert looking_back().see(found=2, found_m=2.0).progress.state == "leading"


def test_it_looks_along_its_way_before_it_goes_on() -> None:
    run = Run().see(people=0, near=0).started()
    run.see(people=1).until("leading").see(people=0, driven_m=5.1, behind=3.0, looked_s=0.0)
    assert run.see(people=1, farthest_m=1.5).progress.state == "waiting", "another may be beside it"
    assert run.see(people=2, farthest_m=2.0, looked_s=1.6).progress.state == "leading"
    run.see(people=0, driven_m=10.3).see(people=1)
    assert run.see(after_s=2.0).progress.state == "waiting", "two came along"


def test_visitors_who_stand_behind_one_another_are_not_waited_for() -> None:
    run = looking_back(people=2).see(farthest_m=1.0, driven_m=10.0).see(people=0, driven_m=15.2)
    run.see(people=2, farthest_m=3.6)
    assert run.see(farthest_m=3.1, after_s=1.0).progress.state == "waiting", "they come"
    assert run.see(after_s=1.5).progress.state == "waiting"
    assert run.see(after_s=1.0, nearest_m=2.8).progress.state == "waiting", "none of them is near"
    assert run.see(nearest_m=2.2).progress.state == "leading"
    assert run.see(people=2, farthest_m=3.2).wish("GoTo").params["speed"] == 0.8, "nobody has fallen behind"
    assert run.see(farthest_m=3.7).wish("GoTo").params["speed"] == 0.4


def test_it_looks_back_before_one_who_stopped_is_far_behind_for_long() -> None:
    run = Run().started().until("leading").see(farthest_m=3.0).see(people=0, driven_m=0.9, after_s=20.0)
    assert run.progress.state == "leading", "4 m away at most"
    run.see(driven_m=1.1).see(driven_m=1.6, after_s=MAY_BE_FAR_S - 0.5)
    assert run.progress.state == "leading"
    assert run.see(after_s=0.6).progress.state == "waiting"


def test_who_is_not_seen_as_it_sets_out_may_be_far() -> None:
    run = Run().started().until("presenting").see(people=1, driven_m=2.0).until("leading")
    run.see(people=0, driven_m=2.1)
    assert run.see(driven_m=2.5, after_s=MAY_BE_FAR_S + 0.1).progress.state == "waiting"


# --- where they are looked for ------------------------------------------------------------------------------------


def driven(*places: tuple[float, float]) -> tuple[Visitors, Pose2]:
    """A robot that drove straight from place to place (m)."""
    visitors, at = Visitors(), Pose2(*places[0])
    for before, after in itertools.pairwise(places):
        steps = round(math.dist(before, after) / 0.05)
        for step in range(steps + 1):
            share = step / steps
            at = Pose2(before[0] + share * (after[0] - before[0]), before[1] + share * (after[1] - before[1]))
            visitors.drive(at)
    return visitors, at


def test_it_looks_back_along_its_way_and_not_past_the_corner_of_a_door() -> None:
    visitors, at = driven((0.0, 0.0), (3.0, 0.0), (3.0, 2.0))
    behind = visitors.around(0.0, at, within_m=2.0, behind=False).behind
    assert behind == pytest.approx(-math.pi / 2, abs=0.2), "to the corner, and not to who may be beyond it"
    visitors, at = driven((0.0, 0.0), (0.3, 0.0))
    assert visitors.around(0.0, at, within_m=2.0, behind=False).behind is None


def test_it_drives_back_along_its_way_to_where_it_saw_them() -> None:
    visitors, _ = driven((0.0, 0.0), (3.0, 0.0), (3.0, 2.0))
    back = visitors.back(2.0)
    assert back is not None
    assert math.dist(back, (2.0, 0.0)) < 0.3
    assert visitors.back(4.8) is None, "that is here"
    visitors, _ = driven((0.0, 0.0), (12.0, 0.0))
    back = visitors.back(0.0)
    assert back is not None
    assert 3.5 < back[0] < 4.5, "and no farther than that"


def test_the_way_back_is_no_new_way() -> None:
    visitors, _ = driven((0.0, 0.0), (4.0, 0.0))
    visitors.returns = True
    for step in range(41):
        visitors.drive(Pose2(4.0 - 0.05 * step, 0.0))
    visitors.returns = False
    behind = visitors.around(0.0, Pose2(2.0, 0.0), within_m=2.0, behind=False).behind
    assert behind == pytest.approx(math.pi), "where it came from, not where it was before"


def test_a_robot_that_drives_back_another_way_is_astray() -> None:
    visitors, _ = driven((0.0, 0.0), (4.0, 0.0))
    assert visitors.astray_m == 0.0
    visitors.returns = True
    for step in range(21):
        visitors.drive(Pose2(4.0 - 0.05 * step, 0.4))
    assert visitors.astray_m == pytest.approx(0.4, abs=0.1), "it passes somebody"
    for step in range(41):
        visitors.drive(Pose2(3.0, 0.4 + 0.05 * step))
    assert visitors.astray_m == pytest.approx(2.4, abs=0.1)
    visitors.returns = False
    visitors.drive(Pose2(3.0, 2.5))
    assert visitors.astray_m == 0.0, "it is on a new way"


def test_a_person_who_is_seen_again_is_one() -> None:
    visitors = Visitors()
    visitors.see(10.0, {1: (2.0, 0.0), 2: (2.0, 1.0)})
    visitors.see(11.5, {3: (2.3, 0.1)})
    people = visitors.around(11.6, Pose2(), within_m=2.0, behind=False)
    assert people.people == 2, "the first, seen again with another number, and the second"
    visitors.see(11.7, {3: (2.3, 0.1), 4: (2.4, 0.3)})
    assert visitors.around(11.7, Pose2(), within_m=2.0, behind=False).people == 2, "and the second again"
    visitors.see(11.8, {3: (2.3, 0.1), 4: (2.4, 0.3), 5: (1.0, -1.0)})
    assert visitors.around(11.8, Pose2(), within_m=2.0, behind=False).people == 3


def test_those_who_are_looked_for_are_remembered() -> None:
    visitors = Visitors()
    visitors.see(10.0, {1: (2.0, 0.0)})
    visitors.see(20.0, {2: (-3.0, 0.0)})
    found = visitors.around(20.0 + SEEN_S + 0.1, Pose2(), within_m=2.0, behind=False, sought_since=15.0)
    assert (found.people, found.found, found.found_m) == (0, 1, 3.0)
    found = visitors.around(20.0 + FOUND_S + 0.1, Pose2(), within_m=2.0, behind=False, sought_since=15.0)
    assert found.found == 0
