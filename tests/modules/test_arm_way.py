"""The way of an arm's joints, against the guard that moves them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.modules.arm_way import stopping, touching, way
from app.robots.joint_guard import advance
from tests.modules.actuation.arms import COLLISION, INTO_THE_TORSO, LEFT, REST, RIGHT_CROSSING, RIGHT_NAMES

STEP_S = 0.002
postures = st.tuples(*(st.floats(joint.lower, joint.upper) for joint in LEFT.joints))


@settings(max_examples=30)
@given(postures, postures)
def test_the_way_is_the_one_by_which_the_guard_moves_the_joints(
    begin: tuple[float, ...], goal: tuple[float, ...]
) -> None:
    found = way(LEFT.joints, np.array(begin), np.array(goal))
    np.testing.assert_allclose(found[[0, -1]], [begin, goal], atol=1e-9)
    position, velocity = list(begin), [0.0] * 4
    moved = [begin]
    for _ in range(3000):
        for n, joint in enumerate(LEFT.joints):
            position[n], velocity[n] = advance(position[n], velocity[n], goal[n], joint, STEP_S)
        moved.append(tuple(position))
        if tuple(position) == goal:
            break
    guarded = np.array(moved)
    for posture in found:
        assert np.abs(guarded - posture).max(axis=1).min() < 0.01
    assert np.abs(np.diff(found, axis=0)).max() < 0.2


def test_a_way_of_no_length_is_its_one_posture() -> None:
    found = way(LEFT.joints, np.array(REST), np.array(REST))
    assert np.unique(found, axis=0).tolist() == [list(REST)]


def test_a_moving_joint_stops_where_the_guard_brakes_it() -> None:
    joint = LEFT.joints[0]
    now, braking, stands = stopping(LEFT.joints, np.zeros(4), np.array([-1.2, 0, 0, 0]), 0.05)[:, 0]
    assert (now, braking) == pytest.approx((0.0, -0.06))
    position, velocity = braking, -1.2
    while velocity:
        position, velocity = advance(position, velocity, stands, joint, STEP_S)
    assert position == pytest.approx(stands, abs=1e-6)
    held = stopping(LEFT.joints, np.zeros(4), np.array([-1.2, 0, 0, 0]), 0.05, np.array([-0.2, 0, 0, 0]))[-1, 0]
    assert held == -0.2, "the guard stops it at its goal"
    passed = stopping(LEFT.joints, np.zeros(4), np.array([-1.2, 0, 0, 0]), 0.05, np.array([-0.1, 0, 0, 0]))[-1, 0]
    assert passed <= stands, "which is too near to brake at"
    assert stopping(LEFT.joints, np.array([0.99, 0, 0, 0]), np.array([1.2, 0, 0, 0]), 0.05)[-1, 0] == joint.upper


def test_a_way_through_the_body_is_named_by_what_touches_first() -> None:
    into = way(LEFT.joints, np.array(REST), np.array(INTO_THE_TORSO))
    assert touching(COLLISION, into, {}) == "left_forearm_link would touch torso_link"
    assert touching(COLLISION, into[:2], {}) == ""


def test_a_goal_that_is_free_behind_the_other_arm_is_not_reached_through_it() -> None:
    right = dict(zip(RIGHT_NAMES, RIGHT_CROSSING, strict=True))
    # From above the other forearm to below it.
    begin, goal = np.array([-1.9, 0.1, -0.9, -1.2]), np.array([-0.5, 0.1, -0.9, -1.2])
    ends = np.stack([begin, goal])
    assert touching(COLLISION, ends, right) == ""
    assert "would touch right_" in touching(COLLISION, way(LEFT.joints, begin, goal), right)
    assert touching(COLLISION, way(LEFT.joints, begin, goal), {}) == ""


def test_an_arm_that_touches_already_may_leave_but_not_go_deeper() -> None:
    into, out = np.array([0.0, 0.02, 0.0, 0.0]), np.array(REST)
    pressed = np.array([0.0, -0.06, 0.0, 0.0])
    assert COLLISION.clearances(pressed[None], {})[0].distance_m < 0.0
    assert touching(COLLISION, way(LEFT.joints, pressed, out), {}) == ""
    assert touching(COLLISION, way(LEFT.joints, into, np.array(INTO_THE_TORSO)), {}) != ""
