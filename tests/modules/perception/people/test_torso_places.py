"""Where a torso is looked for without a face: above legs just seen, of whom nobody hides, and of no chair."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import Person, Persons, PersonState
from app.modules.perception.people.torso_places import torso_places

X_BC = Pose3.from_translation_rpy((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


def person(
    track: int, x: float, y: float, *, state: PersonState = "unsure", face: int | None = None, seen: float = 10.0
) -> Person:
    return Person(
        track,
        None,
        state,
        p_OP=(x, y, 1.57),
        v_O=(1.0, 0.0),
        covariance=0.05**2 * np.eye(2),
        face=face,
        voice=None,
        legs=True,
        speaking=False,
        last_seen=seen,
    )


def places(*people: Person, X_OB: Pose2 | None = None, measured: bool = False) -> dict[int, tuple[float, float, float]]:
    return torso_places(Persons(10.0, people), 10.1, {7}, (X_OB or Pose2(), X_BC), measured)


def test_a_person_without_a_face_is_looked_at_where_the_person_is_by_then() -> None:
    found = places(person(1, 3.0, 0.0), X_OB=Pose2(1.0, 0.0, math.pi / 2))
    assert found == {1: pytest.approx((0.0, -2.1, 1.57))}


def test_who_has_a_face_there_is_lost_or_too_far_is_left_out() -> None:
    assert places(person(1, 3.0, 0.0, face=7), person(2, 3.0, 2.0, seen=9.0), person(3, 9.0, -3.0)) == {}


def test_who_stands_behind_another_is_hidden() -> None:
    assert set(places(person(1, 2.0, 0.0), person(2, 4.0, 0.2), person(3, 4.0, 1.5))) == {1, 3}


def test_what_may_be_a_chair_is_looked_at_where_depth_is_measured_and_hides_nobody() -> None:
    chair = person(1, 2.0, 0.0, state="tentative")
    assert set(places(chair, person(2, 4.0, 0.0))) == {2}
    assert set(places(chair, person(2, 4.0, 0.0), measured=True)) == {1, 2}
