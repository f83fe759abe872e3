"""Viewpoints: where their cameras are, and what a glide between two of them is at any time."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2, wrap_angle
from app.console.view.viewpoints import (
    GLIDE_S,
    OFFSET_M,
    TARGET_M,
    VIEWPOINTS,
    Anchors,
    Glide,
    MapExtent,
    Shot,
    Viewpoint,
    shot,
    shot_of,
    stage_of,
)

angles = st.floats(-math.pi, math.pi)
lengths = st.floats(-50.0, 50.0)
poses = st.builds(Pose2, lengths, lengths, angles)
viewpoints = st.sampled_from(VIEWPOINTS)
anchored = st.builds(
    Anchors,
    poses,
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(0.2, 1.8)),
    st.tuples(angles, st.floats(-1.5, 1.5)),
    angles,
    map=st.none() | st.builds(MapExtent, poses, st.tuples(st.floats(0.1, 80.0), st.floats(0.1, 80.0))),
    aspect=st.floats(0.3, 4.0),
)
shots = st.builds(
    Shot,
    st.tuples(lengths, lengths, lengths),
    angles,
    st.floats(-1.55, 1.55),
    st.floats(0.01, 100.0),
    st.floats(0.3, 2.0),
)


def is_sound(at: Shot) -> None:
    """viser takes it: finite, and neither on what it looks at nor exactly above it."""
    eye, target = np.array(at.eye), np.array(at.target)
    assert np.isfinite([*eye, *target, at.fov]).all()
    assert np.linalg.norm(eye - target) > 0
    assert math.hypot(*(eye - target)[:2]) > 0
    assert 0 < at.fov < math.pi


@given(viewpoints, anchored)
def test_every_viewpoint_is_a_camera_that_can_be_set(viewpoint: Viewpoint, anchors: Anchors) -> None:
    is_sound(shot(viewpoint, anchors))
    stage = stage_of(viewpoint, anchors)
    assert np.isfinite([stage.x, stage.y, stage.theta]).all()


@given(anchored)
def test_from_behind_the_target_ahead_is_in_the_middle_and_the_robot_what_the_view_turns_about(
    anchors: Anchors,
) -> None:
    for viewpoint in ("behind", "aligned", "head"):
        at = shot(viewpoint, anchors)
        eye, about = np.array(at.eye), np.array(at.target)
        way = (about - eye) / np.linalg.norm(about - eye)
        ahead = eye + way * (TARGET_M - eye[0]) / way[0]
        assert ahead[:2] == pytest.approx((TARGET_M, 0.0), abs=1e-6)
        assert 0.0 < ahead[2] < 1.0
        assert about[:2] == pytest.approx((0.0, 0.0), abs=1e-6)


@given(poses, angles)
def test_a_view_along_the_head_turns_with_it_and_one_from_behind_with_the_base(robot: Pose2, pan: float) -> None:
    anchors = Anchors(robot, gaze=(pan, 0.1))
    assert stage_of("behind", anchors).theta == robot.theta
    assert wrap_angle(stage_of("head", anchors).theta - robot.theta - pan) == pytest.approx(0.0, abs=1e-9)
    assert stage_of("free", Anchors(robot, gaze=(pan, 0.1), kept_heading=0.5)).theta == 0.5


@given(anchored)
def test_through_the_camera_the_eye_is_the_camera_s(anchors: Anchors) -> None:
    stage = stage_of("first_person", anchors)
    at = shot("first_person", anchors)
    x, y, z = at.eye
    seen_from = stage.to_pose3().transform(np.array([x, y, z]))
    assert seen_from == pytest.approx(anchors.X_OB.to_pose3().transform(np.array(anchors.p_BC)), abs=1e-6)
    assert abs(at.heading) < 1e-9


@given(anchored)
def test_straight_down_is_a_little_beside_the_vertical_with_what_is_ahead_on_top(anchors: Anchors) -> None:
    for viewpoint in ("top", "map"):
        at = shot(viewpoint, anchors)
        assert np.array(at.target) - np.array(at.eye) == pytest.approx((OFFSET_M, 0.0, -at.eye[2]), abs=1e-6)


def test_the_whole_map_is_in_the_view_and_its_y_points_up() -> None:
    extent = MapExtent(Pose2(3.0, -2.0, 0.4), (20.0, 10.0))
    anchors = Anchors(Pose2(1.0, 1.0, 2.0), map=extent, aspect=1.6)
    at = shot("map", anchors)
    half = at.eye[2] * math.tan(at.fov / 2)
    assert 2 * half >= 10.0
    assert 2 * half * 1.6 >= 20.0
    stage = stage_of("map", anchors)
    assert (stage.x, stage.y) == (3.0, -2.0)
    assert stage.theta == pytest.approx(0.4 + math.pi / 2)


@given(shots, viewpoints, anchored, poses, st.floats(0.0, GLIDE_S))
def test_a_glide_is_a_camera_at_any_time_and_ends_exactly(
    begin: Shot, viewpoint: Viewpoint, anchors: Anchors, offset: Pose2, passed: float
) -> None:
    glide = Glide(viewpoint, 10.0, begin, offset)
    is_sound(glide.shot(10.0 + passed, anchors))
    assert glide.shot(10.0 + GLIDE_S + 1e-6, anchors) == shot(viewpoint, anchors)
    assert glide.stage(10.0 + GLIDE_S + 1e-6, anchors) == stage_of(viewpoint, anchors)
    assert math.dist(glide.shot(10.0, anchors).eye, begin.eye) < 1e-6 * (1 + begin.distance)
    lies = glide.stage(10.0, anchors)
    wanted = stage_of(viewpoint, anchors) @ offset
    assert math.dist((lies.x, lies.y), (wanted.x, wanted.y)) < 1e-6


@given(shots)
def test_a_camera_that_a_browser_reports_is_the_shot_that_it_was_set_to(at: Shot) -> None:
    again = shot_of(np.array(at.eye), np.array(at.target), at.fov)
    assert math.dist(again.eye, at.eye) < 2 * OFFSET_M


def test_a_camera_on_its_target_is_moved_off_it() -> None:
    is_sound(shot_of(np.zeros(3), np.zeros(3), 1.0))
    is_sound(shot_of(np.array([0.0, 0.0, 5.0]), np.zeros(3), 1.0))


def test_a_glide_that_is_held_stays_where_it_is_then_and_goes_on() -> None:
    glide = Glide("top", 0.0, shot("behind", Anchors()), Pose2(), hold=0.4)
    there = replace(glide, hold=1.0)
    assert glide.shot(0.2 * GLIDE_S, Anchors()) == there.shot(0.2 * GLIDE_S, Anchors())
    held = there.shot(0.4 * GLIDE_S, Anchors())
    assert math.dist(glide.shot(99.0, Anchors()).eye, held.eye) < 1e-9
    assert there.shot(99.0, Anchors()) == shot("top", Anchors())
