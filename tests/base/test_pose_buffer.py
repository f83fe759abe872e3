from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2, wrap_angle
from app.base.pose_buffer import PoseBuffer


def filled(*stamps: float, span_s: float = 10.0, tolerance_s: float = 0.1) -> PoseBuffer:
    """A base that drives along x at 1 m/s and turns at 0.5 rad/s."""
    buffer = PoseBuffer(span_s, tolerance_s)
    for stamp in stamps:
        buffer.add(stamp, Pose2(stamp, -stamp, wrap_angle(0.5 * stamp)))
    return buffer


def test_an_empty_buffer_knows_nothing() -> None:
    assert PoseBuffer().at(0.0) is None


@given(st.lists(st.floats(0, 9), min_size=2, unique=True), st.floats(0, 1))
def test_between_two_poses_it_interpolates(stamps: list[float], fraction: float) -> None:
    stamps = sorted(stamps)
    buffer = filled(*stamps)
    stamp = stamps[0] + fraction * (stamps[-1] - stamps[0])
    pose = buffer.at(stamp)
    assert pose is not None
    assert pose.x == pytest.approx(stamp, abs=1e-9)
    assert pose.y == pytest.approx(-stamp, abs=1e-9)
    # Over more than half a turn between two poses the shorter arc is the other one.
    if max(b - a for a, b in itertools.pairwise(stamps)) < 2 * math.pi - 1e-6:
        assert math.cos(pose.theta - 0.5 * stamp) == pytest.approx(1, abs=1e-9)


def test_a_stored_stamp_gives_exactly_the_stored_pose() -> None:
    buffer = filled(1.0, 2.0, 3.0)
    for stamp in (1.0, 2.0, 3.0):
        pose = buffer.at(stamp)
        assert pose is not None
        assert (pose.x, pose.y) == (stamp, -stamp)


@pytest.mark.parametrize(
    ("stamp", "x"), [(0.89, None), (0.95, 1.0), (1.0, 1.0), (3.05, 3.0), (3.11, None), (-5, None), (99, None)]
)
def test_a_little_beyond_either_end_the_nearest_pose_holds_further_out_there_is_none(
    stamp: float, x: float | None
) -> None:
    pose = filled(1.0, 2.0, 3.0).at(stamp)
    assert (pose and pose.x) == x


def test_the_angle_turns_through_the_seam_the_short_way() -> None:
    buffer = PoseBuffer()
    buffer.add(0.0, Pose2(theta=math.pi - 0.1))
    buffer.add(1.0, Pose2(theta=-math.pi + 0.1))
    middle = buffer.at(0.5)
    assert middle is not None
    assert abs(wrap_angle(middle.theta - math.pi)) < 1e-9


def test_what_is_older_than_the_span_is_forgotten() -> None:
    buffer = filled(*(n / 10 for n in range(200)), span_s=2.0, tolerance_s=0.0)
    assert buffer.at(17.8) is None
    pose = buffer.at(17.95)
    assert pose is not None
    assert pose.x == pytest.approx(17.95)


def test_a_pose_that_is_not_newer_is_ignored() -> None:
    buffer = filled(1.0, 2.0)
    buffer.add(2.0, Pose2(99, 99, 0))
    buffer.add(1.5, Pose2(99, 99, 0))
    pose = buffer.at(2.0)
    assert pose is not None
    assert pose.x == 2.0


@given(st.lists(st.tuples(st.floats(0, 100), st.floats(-5, 5)), max_size=40), st.floats(-5, 105))
def test_an_answer_always_lies_between_its_neighbours(poses: list[tuple[float, float]], stamp: float) -> None:
    buffer = PoseBuffer(span_s=20.0)
    for when, x in poses:
        buffer.add(when, Pose2(x))
    pose = buffer.at(stamp)
    if pose is not None:
        xs = [x for _, x in poses]
        assert min(xs) - 1e-9 <= pose.x <= max(xs) + 1e-9
