from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.landmarks.landmark_map import LandmarkMap
from tests.modules.perception.landmarks.graphs import keyframes, only, seen, turned

DOOR = (4.0, 1.0, 1.25)
HEADING = math.pi - 0.2
POSES = st.builds(Pose2, st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3))


def test_a_landmark_moves_with_its_keyframe_when_a_loop_closes() -> None:
    landmarks = LandmarkMap()
    robot = Pose2(3.0, 0.5, 0.4)
    graph = {0: Pose2(), 1: robot}
    landmarks.follow(keyframes(graph, robot))
    landmarks.take(1.0, "door", seen(robot, DOOR, HEADING), robot)
    corrected = Pose2(3.3, 0.1, 0.25)
    landmarks.follow(keyframes({0: Pose2(), 1: corrected}, corrected, X_OB=robot, version=2))
    X_MM = corrected @ robot.inverse()
    found = only(landmarks)
    np.testing.assert_allclose(found.p_FQ, [*X_MM.transform(np.array(DOOR[:2])), DOOR[2]], atol=1e-9)
    assert found.heading is not None
    assert turned(found.heading, HEADING + X_MM.theta) < 1e-9


@given(POSES, POSES, POSES)
def test_a_landmark_stays_where_it_is_when_its_keyframe_is_pruned(robot: Pose2, other: Pose2, third: Pose2) -> None:
    landmarks = LandmarkMap()
    graph = {0: third, 1: other, 2: robot}
    landmarks.follow(keyframes(graph, robot))
    landmarks.take(1.0, "door", seen(robot, DOOR, HEADING), robot)
    # 2 goes to 1, and 1, in the same cut, to 0.
    removed = [(2, 1, other.inverse() @ robot), (1, 0, third.inverse() @ other)]
    landmarks.follow(keyframes({0: third}, robot, keyframe=0, removed=removed, version=2))
    found = only(landmarks)
    np.testing.assert_allclose(found.p_FQ, DOOR, atol=1e-9)
    # It belongs to the one that is left, and moves with it.
    away = Pose2(7.0, -3.0, 1.0)
    landmarks.follow(keyframes({0: away}, robot, keyframe=0, version=3))
    expected = (away @ third.inverse()).transform(np.array(DOOR[:2]))
    np.testing.assert_allclose(only(landmarks).p_FQ[:2], expected, atol=1e-9)


def test_a_keyframe_that_went_without_a_word_leaves_its_landmarks_to_the_nearest() -> None:
    landmarks = LandmarkMap()
    graph = {0: Pose2(), 1: Pose2(2.5, 0.0, 0.1), 2: Pose2(3.0, 0.5, 0.4)}
    landmarks.follow(keyframes(graph, graph[2]))
    landmarks.take(1.0, "door", seen(graph[2], DOOR, HEADING), graph[2])
    landmarks.follow(keyframes({0: graph[0], 1: graph[1]}, graph[2], keyframe=1, version=2))
    np.testing.assert_allclose(only(landmarks).p_FQ, DOOR, atol=1e-9)
    assert landmarks.known[0].sightings.anchors.tolist() == [1]


def test_the_gate_is_on_the_map_so_that_the_drift_of_odometry_doubles_nothing() -> None:
    landmarks = LandmarkMap()
    robot = Pose2(3.0, 0.5, 0.4)
    for visit, drift in enumerate([Pose2(), Pose2(1.7, -2.0, 0.6)]):
        X_OB = drift @ robot
        landmarks.follow(keyframes({0: robot}, robot, X_OB=X_OB, version=visit + 1))
        landmarks.take(float(visit), "door", seen(robot, DOOR, HEADING), X_OB)
    assert only(landmarks).sightings == 2
    np.testing.assert_allclose(only(landmarks).p_FQ, DOOR, atol=1e-9)


def test_before_a_loop_is_closed_a_landmark_may_be_double_and_is_one_again_after() -> None:
    landmarks = LandmarkMap()
    robot, drifted = Pose2(3.0, 0.5, 0.4), Pose2(5.0, 2.5, 0.8)
    landmarks.follow(keyframes({0: robot}, robot))
    landmarks.take(1.0, "door", seen(robot, DOOR, HEADING), robot)
    # Back at the same place, which the map has two metres further.
    landmarks.follow(keyframes({0: robot, 40: drifted}, drifted, X_OB=robot, version=2))
    landmarks.take(2.0, "door", seen(robot, DOOR, HEADING), robot)
    assert [mark.id for mark in landmarks.message(2.0).landmarks] == [1, 2]
    landmarks.follow(keyframes({0: robot, 40: robot}, robot, X_OB=robot, version=3))
    found = only(landmarks)
    assert (found.id, found.sightings, found.first_seen, found.last_seen) == (1, 2, 1.0, 2.0)
    np.testing.assert_allclose(found.p_FQ, DOOR, atol=1e-9)


def test_codes_of_one_text_on_both_sides_of_a_wall_are_two() -> None:
    landmarks = LandmarkMap()
    here, there = Pose2(3.0, 1.0, 0.0), Pose2(5.0, 1.0, math.pi)
    for robot, x, heading in ((here, 3.95, math.pi), (there, 4.05, 0.0)):
        landmarks.follow(keyframes({0: here, 1: there}, robot, keyframe=0, state="tracking"))
        landmarks.take(1.0, "room", seen(robot, (x, 1.0, 1.2), heading), robot)
    assert [round(mark.p_FQ[0], 2) for mark in landmarks.message(1.0).landmarks] == [3.95, 4.05]


def test_what_was_seen_in_odom_is_on_the_map_once_the_robot_is_localized() -> None:
    landmarks = LandmarkMap()
    X_OB = Pose2(1.0, 2.0, 0.3)
    landmarks.take(1.0, "door", seen(X_OB, DOOR, HEADING), X_OB)
    assert landmarks.frame == "odom"
    sure = only(landmarks)
    np.testing.assert_allclose(sure.p_FQ, DOOR, atol=1e-9)
    landmarks.drive(10.0)
    X_MO = Pose2(-1.0, 0.5, 1.1)
    landmarks.follow(keyframes({0: X_MO @ X_OB}, X_MO @ X_OB, X_OB=X_OB))
    found = only(landmarks)
    assert landmarks.frame == "map"
    np.testing.assert_allclose(found.p_FQ, [*X_MO.transform(np.array(DOOR[:2])), DOOR[2]], atol=1e-9)
    # Ten metres of odometry lie between: 0.2 m of drift.
    assert found.sigma_m > 0.1 > sure.sigma_m


def test_a_lost_robot_places_nothing() -> None:
    landmarks = LandmarkMap()
    robot = Pose2(3.0, 0.5, 0.4)
    landmarks.follow(keyframes({0: robot}, robot))
    landmarks.follow(keyframes({0: robot}, robot, state="searching", version=2))
    assert landmarks.take(1.0, "door", seen(robot, DOOR, HEADING), robot) is None
    assert landmarks.known == ()


def test_odometry_without_a_localization_makes_sightings_less_sure() -> None:
    robot = Pose2(3.0, 0.5, 0.4)
    sigmas = []
    for driven in (0.0, 20.0):
        landmarks = LandmarkMap()
        landmarks.follow(keyframes({0: robot}, robot))
        landmarks.drive(driven)
        landmarks.take(1.0, "door", seen(robot, DOOR, HEADING), robot)
        sigmas.append(only(landmarks).sigma_m)
    assert sigmas[1] > 5 * sigmas[0]


@given(st.lists(st.tuples(POSES, st.floats(0.02, 0.1)), min_size=1, max_size=5), st.randoms())
def test_kept_landmarks_are_the_same_when_loaded_and_are_merged_with_new_sightings(sights, random) -> None:  # type: ignore[no-untyped-def]
    graph = {id: pose for id, (pose, _) in enumerate(sights)}
    landmarks = LandmarkMap()
    for id, (pose, sigma_m) in enumerate(sights):
        landmarks.follow(keyframes(graph, pose, keyframe=id, state="tracking", version=id + 1))
        landmarks.take(float(id), "door", seen(pose, DOOR, HEADING, sigma_m), pose)
    ids, X_MK = landmarks.anchors()
    kept = only(landmarks)
    # The map was kept without some of its keyframes, but for the first.
    left = {id: pose for id, pose in graph.items() if id == 0 or random.random() < 0.5}
    other = LandmarkMap()
    robot = graph[0]
    other.load(landmarks.known, ids, X_MK, keyframes(left, robot, keyframe=0, state="searching"))
    found = only(other)
    np.testing.assert_allclose(found.p_FQ, kept.p_FQ, atol=1e-6)
    assert found.heading is not None
    assert kept.heading is not None
    assert turned(found.heading, kept.heading) < 1e-6
    assert (found.id, found.sightings) == (kept.id, kept.sightings)
    other.follow(keyframes(left, robot, keyframe=0, state="tracking", version=2))
    merged = other.take(9.0, "door", seen(robot, DOOR, HEADING), robot)
    assert merged is not None
    assert (merged.id, merged.sightings) == (kept.id, kept.sightings + 1)
    assert merged.sigma_m <= found.sigma_m + 1e-9


def test_a_landmark_that_hangs_elsewhere_is_reported_and_does_not_move() -> None:
    robot = Pose2(3.0, 0.5, 0.4)
    graph = {0: robot}
    former = LandmarkMap()
    former.follow(keyframes(graph, robot, state="tracking"))
    former.take(1.0, "door", seen(robot, DOOR, HEADING), robot)
    landmarks = LandmarkMap()
    landmarks.load(former.known, *former.anchors(), keyframes(graph, robot, state="tracking"))
    now = (4.0, 1.6, 1.25)
    for stamp in (10.0, 11.0):
        landmarks.take(stamp, "door", seen(robot, now, HEADING), robot)
        assert landmarks.displaced() == ()
    landmarks.take(12.0, "door", seen(robot, now, HEADING), robot)
    (displaced,) = landmarks.displaced()
    assert (displaced.id, displaced.text, displaced.now) == (1, "door", 2)
    assert displaced.p_MQ == pytest.approx(DOOR)
    assert displaced.p_MR == pytest.approx(now)
    # The old one is seen after all: there are two.
    landmarks.take(13.0, "door", seen(robot, DOOR, HEADING), robot)
    assert landmarks.displaced() == ()
    assert len(landmarks.known) == 2
