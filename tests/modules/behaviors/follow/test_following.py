"""Whom it follows, and what it does when they stop, are hidden, are lost, or are somebody else."""

from __future__ import annotations

import math

import pytest

from app.base.geometry import Pose2
from app.messages import Person
from app.modules.behaviors.follow.followed_person import FollowedPerson, look_round
from app.modules.behaviors.follow.following import Following, FollowRules, FollowStep, Side
from tests.modules.behaviors.follow.people import person, persons

HOME = Pose2()


class Scene:
    """Steps of a ``Following`` at a robot that stands at ``robot``, ten a second."""

    def __init__(self, number: int | None = None, side: Side = "behind") -> None:
        self.now = 100.0
        self.robot = HOME
        self.following = Following(number, FollowRules(side=side), self.now, 0.5)
        self.last: FollowStep | None = None

    def see(self, *seen: Person, seconds: float = 0.1) -> FollowStep:
        """Perceive these for so long; the last step."""
        for _ in range(round(seconds / 0.1)):
            self.now += 0.1
            self.last = self.following.step(self.now, self.robot, persons(self.now, *seen))
        assert self.last is not None
        return self.last


def test_the_nearest_is_followed_until_they_are_gone_though_another_comes_nearer() -> None:
    scene = Scene()
    step = scene.see(person(4, 0, track=1, number=5), person(3, 1, track=2, number=8))
    assert scene.following.name == "Person 8"
    assert step.keep == (3, 1)
    step = scene.see(person(1, 0, track=1, number=5), person(3, 1.1, track=2, number=8))
    assert step.keep == (3, 1.1)
    step = scene.see(person(1, 0, track=1, number=5), seconds=3)
    assert step.state == "hidden", "it does not take another for them"
    assert step.keep == (3, 1.1)


def test_a_person_by_number_is_waited_for_and_found_among_others() -> None:
    scene = Scene(number=3)
    step = scene.see(person(1, 0, number=5), person(2, 0, track=2, number=None, state="unsure"))
    assert (step.state, step.place) == ("waiting", None)
    assert "Person 3 is not seen" in step.reason
    step = scene.see(person(1, 0, number=5), person(2, 0, track=2, number=3))
    assert step.state == "following"
    assert step.place == Pose2(0.8, 0.0, 0.0)


def test_a_doubtful_identity_is_followed_on_but_not_started_with_in_place_of_a_known_one() -> None:
    scene = Scene(number=3)
    scene.see(person(2, 0, track=1, number=3))
    step = scene.see(person(2.2, 0, track=1, number=None, state="unsure"))
    assert step.keep == (2.2, 0), "the same track"
    step = scene.see(person(2.2, 0, track=1, number=4))
    assert step.keep == (2.2, 0)
    assert scene.see(person(2.9, 0, track=1, number=4), seconds=2).state == "hidden", "it is another after all"


def test_who_appears_alone_where_they_should_be_is_they() -> None:
    scene = Scene()
    scene.see(person(2, 0, track=1, number=None, state="unsure", v=(0.3, 0.0)))
    step = scene.see(person(2.5, 0.1, track=9, number=None, state="unsure"))
    assert step.keep == (2.5, 0.1)
    two = [person(2.5, y, track=10 + round(10 * y), number=None, state="unsure") for y in (0.4, -0.4)]
    assert scene.see(*two).keep == (2.5, 0.1), "either may be they"


@pytest.mark.parametrize("state", ["tentative", "lost"])
def test_chairs_and_predictions_are_not_followed(state: str) -> None:
    scene = Scene()
    step = scene.see(person(2, 0, number=1, state=state))  # type: ignore[arg-type]
    assert step.state == "waiting"
    assert step.place is None


def test_it_goes_on_to_where_they_should_be_then_looks_round_then_gives_up_for_good() -> None:
    scene = Scene()
    walking = person(3, 0, number=2, v=(0.4, 0.0))
    assert scene.see(walking).state == "following"
    step = scene.see(seconds=3)
    assert step.state == "hidden"
    assert step.keep == pytest.approx((3.8, 0.0)), "they go on for two seconds"
    assert step.place is not None
    assert step.place.x == pytest.approx(3.8 - 1.2)
    headings = []
    while (step := scene.see()).state != "given_up":
        if step.state == "searching":
            assert step.place is not None
            assert (step.place.x, step.place.y) == (0, 0), "it stands"
            headings.append(round(math.degrees(step.place.theta)))
    assert sorted(set(headings)) == [-180, -60, 0, 60] or sorted(set(headings)) == [-60, 0, 60, 180]
    assert headings[0] == 0, "first where they should be"
    assert step.place is None
    assert "Person 2 was lost" in step.reason
    assert "(3.0, 0.0)" in step.reason
    assert scene.see(walking).state == "given_up", "a robot that gave up does not set off by itself"


def test_seen_again_they_are_followed_again() -> None:
    scene = Scene()
    scene.see(person(3, 0, number=2))
    assert scene.see(seconds=9).state == "searching"
    step = scene.see(person(-3, 1, track=5, number=2))
    assert step.state == "following"
    assert step.keep == (-3, 1)


def test_without_anybody_it_looks_round_from_its_own_heading_and_fails() -> None:
    scene = Scene(number=7)
    step = scene.see(seconds=7)
    assert step.state == "searching"
    assert step.place == Pose2(0, 0, 0.5)
    assert step.keep is None
    assert scene.see(seconds=16).reason == "Person 7 was not seen for 22 s"


def test_stale_persons_say_nothing() -> None:
    following = Following(None, FollowRules(), 100.0, 0.0)
    seen = persons(100.0, person(2, 0))
    assert following.step(100.1, HOME, seen).state == "following"
    for now in (100.6, 103.0, 110.0):
        step = following.step(now, HOME, seen)
        assert (step.state, step.place) == ("waiting", None)
        assert "nothing tracks persons" in step.reason
    assert following.step(122.5, HOME, seen).state == "given_up"
    assert Following(None, FollowRules(), 100.0, 0.0).step(100.1, HOME, None).place is None


def test_behind_who_walks_the_way_leads_to_where_they_will_be() -> None:
    scene = Scene()
    step = scene.see(person(3, 0, v=(0.4, 0.0)))
    assert step.place is not None
    assert step.place.x == pytest.approx(3 + 1.5 * 0.4 - 1.2)
    assert step.keep == (3, 0)
    step = scene.see(person(3, 0, v=(0.05, 0.0)))
    assert step.place is not None
    assert step.place.x == pytest.approx(1.8)
    assert step.there


def test_from_the_front_it_stands_before_who_walks_on_their_way() -> None:
    scene = Scene(side="front")
    step = scene.see(person(3, 0, v=(-0.4, 0.0)))
    assert step.place is not None
    assert (step.place.x, step.place.y) == (pytest.approx(1.8), pytest.approx(0))
    assert step.there
    step = scene.see(person(3, 0, v=(0.4, 0.0)))
    assert not step.there, "first it goes round them"


def test_a_person_faces_where_they_walk_or_walked_and_a_robot_that_sees_their_face() -> None:
    someone = FollowedPerson(None)
    with pytest.raises(ValueError, match="not seen yet"):
        someone.facing((0, 0))
    someone.see(persons(1.0, person(3, 0)), (0, 0), 1.0)
    assert someone.facing((0, 0)) == pytest.approx(math.pi), "nothing is known"
    someone.see(persons(1.1, person(3, 0, v=(0.0, 0.5))), (0, 0), 1.1)
    assert someone.facing((0, 0)) == pytest.approx(math.pi / 2)
    someone.see(persons(1.2, person(3, 0)), (0, 0), 1.2)
    assert someone.facing((0, 0)) == pytest.approx(math.pi / 2), "they stopped"
    someone.see(persons(1.3, person(3, 0, face=True)), (0, 0), 1.3)
    assert someone.facing((0, 0)) == pytest.approx(math.pi), "they turned round"
    assert someone.facing((2.0, 2.0)) == pytest.approx(math.pi / 2), "as far as a face can be seen aside"


def test_it_looks_round_to_all_sides_in_its_time() -> None:
    looked = [look_round(1.0, share) for share in (-1.0, 0.0, 0.3, 0.6, 0.99, 5.0)]
    assert looked[:2] == [1.0, 1.0]
    assert looked[2] - 1.0 == pytest.approx(math.radians(60))
    assert looked[3] - 1.0 == pytest.approx(-math.radians(60))
    assert looked[4] == looked[5] == pytest.approx(1.0 - math.pi)
