"""Joint positions at an instant: interpolated, bounded in time, never extrapolated far."""

from __future__ import annotations

import math

import pytest

from app.base.joint_buffer import JointBuffer


def test_positions_are_those_of_the_instant_of_a_turning_head() -> None:
    joints = JointBuffer()
    turn = math.radians(60)  # per second, sampled at 30 Hz
    for sample in range(31):
        joints.add(sample / 30, {"pan": turn * sample / 30, "tilt": -0.1})
    for stamp in (0.0, 0.01, 0.5, 0.9999, 1.0):
        found = joints.at(stamp)
        assert found is not None
        assert found["pan"] == pytest.approx(turn * stamp, abs=1e-12)
        assert found["tilt"] == pytest.approx(-0.1)


def test_a_stamp_beyond_the_ends_takes_the_nearest_or_nothing() -> None:
    joints = JointBuffer(span_s=1.0, tolerance_s=0.1)
    assert joints.at(0.0) is None
    for stamp in (0.0, 1.0, 2.0):
        joints.add(stamp, {"pan": stamp})
    joints.add(1.5, {"pan": 7.0})  # older than the last
    assert joints.at(2.05) == {"pan": 2.0}
    assert joints.at(2.2) is None
    assert joints.at(0.95) == {"pan": 1.0}
    assert joints.at(0.5) is None, "it was forgotten"
    assert joints.at(1.5) == {"pan": 1.5}


def test_a_joint_that_counts_within_a_turn_does_not_swing_back() -> None:
    joints = JointBuffer()
    joints.add(0.0, {"wheel": 3.1, "new": 0.0})
    joints.add(1.0, {"wheel": -3.1})
    assert joints.at(0.4) == {"wheel": 3.1}
    assert joints.at(0.6) == {"wheel": -3.1}
