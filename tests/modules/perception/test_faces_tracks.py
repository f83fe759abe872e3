"""Who is who: numbers that stay, over frames, cameras, turns and gaps."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2, Pose3
from app.modules.perception.faces.face_position import FaceSighting
from app.modules.perception.faces.face_tracks import FACE_M, FaceTracks, TrackedFace, TrackModel
from app.modules.perception.faces.yunet import Detection
from app.modules.perception.height_prior import range_from_height

HERE = Pose3.identity()
ORIGIN = np.array((0.1, 0.0, 1.25))
MARKS = np.zeros((5, 2), np.float32)


def sight(
    place: tuple[float, float, float], X_OB: Pose3 = HERE, *, depth: bool = True, rng: np.random.Generator | None = None
) -> FaceSighting:
    """A face at ``place`` in odom, as a camera with depth or without sees it, with the errors it says it has."""
    towards = X_OB.inverse().transform(np.array(place)) - ORIGIN
    distance = float(np.linalg.norm(towards))
    ray = towards / distance
    sigma = 0.004
    if rng is not None:
        ray = ray + sigma * rng.standard_normal(3)
        ray /= np.linalg.norm(ray)
    if depth:
        range_m, range_sigma_m = distance + (0.015 * rng.standard_normal() if rng else 0.0), 0.015
    else:
        range_m, range_sigma_m = range_from_height(ray.tolist(), float(ORIGIN[2]))
    # Boxes go with the azimuth: 300 px per rad about the middle of an image.
    left = 500 - 300 * math.atan2(ray[1], ray[0])
    face = Detection(0.9, (left, 200.0, 40.0, 50.0), MARKS)
    return FaceSighting(face, ORIGIN, ray, sigma, range_m, range_sigma_m, depth)


def sized(place: tuple[float, float, float], camera: tuple[float, float, float], larger: float = 0.0) -> FaceSighting:
    """A face at ``place`` that a ``camera`` without depth sees, ``larger`` (logarithm) than faces are in the mean."""
    towards = np.array(place) - np.array(camera)
    distance = float(np.linalg.norm(towards))
    range_m, range_sigma_m = range_from_height(towards.tolist(), camera[2])
    face = Detection(0.9, (500 - 300 * math.atan2(place[1], place[0]), 200.0, 10.0, 12.0), MARKS)
    return FaceSighting(
        face,
        np.array(camera),
        towards / distance,
        0.004,
        range_m=range_m,
        range_sigma_m=range_sigma_m,
        measured=False,
        size_rad=FACE_M / distance * math.exp(larger),
    )


def numbers(placed: Iterable[TrackedFace]) -> list[int]:
    return [p.track for p in placed]


def test_two_people_who_cross_keep_their_numbers() -> None:
    rng = np.random.default_rng(3)
    tracks = FaceTracks()
    for shot in range(40):
        t = shot / 15
        # They meet after 1.3 s, one 0.7 m behind the other.
        pair = [(2.0, -1.3 + t, 1.62), (2.7, 1.3 - t, 1.55)]
        assert numbers(tracks.see(t, "kinect", [sight(p, rng=rng) for p in pair], HERE)) == [1, 2]


def test_the_order_of_the_faces_in_an_image_says_nothing() -> None:
    tracks = FaceTracks()
    pair = [(2.0, -0.8, 1.6), (2.2, 0.6, 1.5)]
    assert numbers(tracks.see(0.0, "kinect", [sight(p) for p in pair], HERE)) == [1, 2]
    assert numbers(tracks.see(0.1, "kinect", [sight(p) for p in reversed(pair)], HERE)) == [2, 1]


def test_of_two_who_could_be_either_each_is_who_is_more_likely() -> None:
    """After a second unseen both could have gone to either place; they are taken to have moved least, together."""
    tracks = FaceTracks()
    for shot in range(5):
        pair = [sight((2.0, 0.0, 1.6)), sight((2.0, 0.4, 1.6))]
        assert numbers(tracks.see(shot / 10, "kinect", pair, HERE)) == [1, 2]
    later = [sight((2.0, 0.42, 1.6)), sight((2.0, 0.05, 1.6))]
    assert numbers(tracks.see(1.4, "kinect", later, HERE)) == [2, 1]


@pytest.mark.parametrize("depth", [True, False])
def test_a_number_outlives_missed_images_for_about_a_second_and_no_longer(depth: bool) -> None:
    tracks = FaceTracks()
    for shot in range(10):
        tracks.see(shot / 10, "panorama", [sight((2.0, 0.1 * shot, 1.6), depth=depth)], HERE)
    for shot in range(10, 19):
        tracks.see(shot / 10, "panorama", [], HERE)
    assert numbers(tracks.see(1.9, "panorama", [sight((2.0, 1.9, 1.6), depth=depth)], HERE)) == [1]
    assert tracks.numbers == (1,)
    tracks.see(3.2, "panorama", [], HERE)
    assert tracks.numbers == ()
    assert numbers(tracks.see(3.3, "panorama", [sight((2.0, 2.0, 1.6), depth=depth)], HERE)) == [2]


def test_a_stream_thinned_to_little_more_than_one_image_a_second_keeps_numbers_too() -> None:
    tracks = FaceTracks()
    seen = [tracks.see(0.8 * shot, "panorama", [sight((2.0, 0.3 * shot, 1.6), depth=False)], HERE) for shot in range(6)]
    assert [numbers(placed) for placed in seen] == [[1]] * 6
    tracks.see(4.8, "panorama", [], HERE)
    assert numbers(tracks.see(5.6, "panorama", [sight((2.0, 2.1, 1.6), depth=False)], HERE)) == [1], "one was missed"


def test_a_robot_that_turns_sees_the_same_faces() -> None:
    rng = np.random.default_rng(5)
    tracks = FaceTracks()
    for shot in range(20):
        X_OB = Pose2(0.02 * shot, 0.0, 0.1 * shot).to_pose3()
        # Without the pose, a turn of 0.1 rad at 3 m would be a walk at 3 m/s.
        pair = [sight(p, X_OB, rng=rng) for p in ((3.0, -0.4, 1.6), (3.1, 0.4, 1.5))]
        assert numbers(tracks.see(shot / 10, "kinect", pair, X_OB)) == [1, 2]


def test_both_cameras_give_one_number_and_depth_teaches_the_height_that_the_other_needs() -> None:
    rng = np.random.default_rng(9)
    tracks = FaceTracks()
    tall = (2.5, 0.3, 1.85)
    (alone,) = FaceTracks().see(0.0, "panorama", [sight(tall, depth=False)], HERE)
    assert np.linalg.norm(alone.p_BF - tall) > 0.6, "taken for a person of mean height, he is supposed too near"
    for shot in range(10):
        t = 0.1 * shot
        tracks.see(t, "kinect", [sight(tall, rng=rng)], HERE)
        (placed,) = tracks.see(t + 0.03, "panorama", [sight(tall, depth=False, rng=rng)], HERE)
        assert placed.track == 1
        assert np.linalg.norm(placed.p_BF - tall) < 0.1
    # He walks on, where only the panorama sees him.
    for shot in range(10, 25):
        place = (2.5, 0.3 + 0.1 * (shot - 9), 1.85)
        (placed,) = tracks.see(0.1 * shot, "panorama", [sight(place, depth=False, rng=rng)], HERE)
        assert placed.track == 1
        deviation = placed.p_BF - place
        assert np.linalg.norm(deviation) < 0.3
        assert deviation @ np.linalg.solve(placed.covariance, deviation) < 20


@pytest.mark.parametrize("height", [1.45, 1.566, 1.75])
def test_a_guess_repeated_is_not_taken_for_knowledge(height: float) -> None:
    """The deviation of a distance known from the height alone stays true however often it is seen."""
    rng = np.random.default_rng(11)
    tracks = FaceTracks()
    place = (2.0, 0.5, height)
    for shot in range(60):
        (placed,) = tracks.see(0.1 * shot, "panorama", [sight(place, depth=False, rng=rng)], HERE)
        assert placed.track == 1
        deviation = placed.p_BF - place
        assert deviation @ np.linalg.solve(placed.covariance, deviation) < 25
    assert 0.2 < math.sqrt(np.linalg.eigvalsh(placed.covariance)[-1]) < 2.5


UPPER, LOWER = (0.04, 0.0, 1.38), (0.1, 0.0, 0.89)


def polar(degrees: float, away_m: float, height_m: float) -> tuple[float, float, float]:
    return away_m * math.cos(math.radians(degrees)), away_m * math.sin(math.radians(degrees)), height_m


def test_faces_of_two_one_seen_by_either_camera_are_no_nearer_face_where_their_rays_pass() -> None:
    tracks = FaceTracks()
    far, near = polar(22.4, 5.8, 1.45), polar(31.6, 3.5, 1.6)
    for shot in range(30):
        (one,) = tracks.see(0.27 * shot, "kinect", [sized(far, UPPER)], HERE)
        (other,) = tracks.see(0.27 * shot + 0.1, "panorama", [sized(near, LOWER, 0.12)], HERE)
        assert (one.track, other.track) == (1, 2)
        assert math.dist(one.p_BF[:2], far[:2]) < 1.2
        assert math.dist(other.p_BF[:2], near[:2]) < 1.0


@given(st.floats(-25.0, 25.0), st.floats(1.0, 6.0), st.floats(1.45, 1.75), st.floats(-0.25, 0.25))
@settings(max_examples=60, deadline=None)
def test_a_face_of_any_usual_size_is_one_for_both_cameras(
    degrees: float, away_m: float, height_m: float, larger: float
) -> None:
    tracks = FaceTracks()
    place = polar(degrees, away_m, height_m)
    for shot in range(8):
        (one,) = tracks.see(0.27 * shot, "kinect", [sized(place, UPPER, larger)], HERE)
        (other,) = tracks.see(0.27 * shot + 0.1, "panorama", [sized(place, LOWER, larger)], HERE)
        assert one.track == other.track == 1
        for placed in (one, other):
            deviation = placed.p_BF - place
            assert deviation @ np.linalg.solve(placed.covariance, deviation) < 30


def test_where_the_height_says_nothing_the_size_says_how_far_a_face_is() -> None:
    (placed,) = FaceTracks().see(0.0, "kinect", [sized((3.0, 0.0, 1.38), UPPER)], HERE)
    assert placed.p_BF[0] == pytest.approx(3.0, abs=0.3)
    assert math.sqrt(placed.covariance[0, 0]) < 0.5


def test_a_person_who_comes_nearer_is_known_to_be_nearer() -> None:
    tracks = FaceTracks()
    for shot in range(40):
        place = (4.0 - 0.07 * shot, 0.2, 1.6)
        (placed,) = tracks.see(0.1 * shot, "panorama", [sight(place, depth=False)], HERE)
    assert placed.track == 1
    assert placed.p_BF[0] == pytest.approx(place[0], abs=0.25)


def test_without_a_pose_boxes_that_overlap_are_the_same_face() -> None:
    tracks = FaceTracks()
    a, b = sight((2.0, 0.5, 1.6)), sight((2.0, -0.5, 1.6))
    assert numbers(tracks.see(0.0, "kinect", [a, b], None)) == [1, 2]
    assert numbers(tracks.see(0.1, "kinect", [b, a], None)) == [2, 1]
    assert numbers(tracks.see(0.2, "kinect", [sight((2.0, 1.2, 1.6))], None)) == [3]
    # The pose comes back: from now on they are followed in space.
    assert numbers(tracks.see(0.3, "kinect", [a, b], HERE)) == [1, 2]
    assert numbers(tracks.see(0.5, "kinect", [sight((2.0, 0.6, 1.6)), b], HERE)) == [1, 2]


def test_an_image_that_comes_late_changes_nothing_of_the_numbers() -> None:
    tracks = FaceTracks()
    tracks.see(1.00, "kinect", [sight((2.0, 0.0, 1.6))], HERE)
    assert numbers(tracks.see(0.90, "panorama", [sight((2.0, 0.05, 1.6), depth=False)], HERE)) == [1]
    assert numbers(tracks.see(1.07, "kinect", [sight((2.0, 0.0, 1.6))], HERE)) == [1]


def test_memory_is_bounded() -> None:
    tracks = FaceTracks(TrackModel(most=10))
    for shot in range(5):
        crowd = [sight((3.0 + shot, 0.8 * i - 4, 1.6)) for i in range(10)]
        assert len(tracks.see(0.01 * shot, "kinect", crowd, HERE)) == 10
        assert len(tracks.numbers) <= 10


def test_numbers_begin_where_they_are_reported_to() -> None:
    assert numbers(FaceTracks(first=7).see(0.0, "kinect", [sight((2, 0, 1.6))], HERE)) == [7]
