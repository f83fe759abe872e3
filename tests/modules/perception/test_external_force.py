"""Forces on the hands: the inverse of what a force does to the joints, and where no joint can know it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base import paths
from app.base.kinematic_model import load_model
from app.modules.perception.external_force import HIGHEST_CONDITION, felt_efforts, force_on

MODEL = load_model(paths.config_dir() / "robots" / "irl1_tr.urdf")
ARM = ("left_shoulder_pitch_joint", "left_shoulder_roll_joint", "left_upper_arm_joint", "left_elbow_joint")
HAND = "left_hand_link"
BENT = dict(zip(ARM, (-0.5, 0.3, 0.2, -0.9), strict=True))


def felt_from(force: tuple[float, float, float], positions: dict[str, float]) -> dict[str, float]:
    torques = MODEL.jacobian(HAND, ARM, positions).T @ np.array(force)
    return dict(zip(ARM, torques.tolist(), strict=True))


@given(
    st.tuples(st.floats(-2.0, 0.5), st.floats(0.0, 1.5), st.floats(-1.0, 1.0), st.floats(-2.0, -0.1)),
    st.tuples(*[st.floats(-30, 30)] * 3),
)
def test_the_force_that_the_joints_feel_is_found_or_there_is_none(
    arm: tuple[float, float, float, float], force: tuple[float, float, float]
) -> None:
    positions = dict(zip(ARM, arm, strict=True))
    found = force_on(MODEL, HAND, positions, felt_from(force, positions))
    stretch = np.linalg.svd(MODEL.jacobian(HAND, ARM, positions), compute_uv=False)
    if found is None:
        assert stretch[0] >= HIGHEST_CONDITION * stretch[-1] * 0.999
    else:
        assert stretch[0] < HIGHEST_CONDITION * stretch[-1] * 1.001
        np.testing.assert_allclose(found.f_B, force, atol=1e-6)
        np.testing.assert_allclose(found.p_B, MODEL.pose(HAND, positions).translation)


def test_along_a_stretched_arm_there_is_no_estimate() -> None:
    straight = dict(zip(ARM, (-1.5, 0.1, 0.0, -0.05), strict=True))
    assert force_on(MODEL, HAND, straight, felt_from((-10.0, 0.0, 0.0), straight)) is None


def test_fewer_than_three_joints_do_not_know_a_force() -> None:
    assert force_on(MODEL, "head_link", {}, {"pan_joint": 1.0, "tilt_joint": 1.0}) is None


def test_damping_is_no_force_from_outside() -> None:
    # The motor of a joint that moves freely exerts what its damping takes.
    damping = MODEL.joints[ARM[0]].damping
    assert damping == 0.6
    felt = felt_efforts(MODEL, {ARM[0]: 0.6, ARM[3]: 2.0, "another": 1.0}, {ARM[0]: 1.0})
    assert felt == {ARM[0]: pytest.approx(0.0), ARM[3]: -2.0}
