"""Where the joints must be for the eye to look at a point: against the model itself and a search over all positions."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.base.kinematic_model import KinematicModel, load_model
from app.link import JointLimits
from app.modules.behaviors.gaze.gaze_kinematics import aim

MODEL = load_model(Path(__file__).parents[4] / "config" / "robots" / "irl1_tr.urdf")
EYE = "kinect_optical_frame"
HEAD = [
    JointLimits(name, MODEL.joints[name].lower, MODEL.joints[name].upper, velocity=1, acceleration=5)
    for name in ("pan_joint", "tilt_joint")
]
#: Another body: tilt below, pan above, both askew, and the eye beside them.
ASKEW = """<robot name="askew">
  <link name="base_link"/><link name="tilted"/><link name="panned"/><link name="eye"/>
  <joint name="nod" type="revolute"><parent link="base_link"/><child link="tilted"/>
    <origin xyz="0.1 0.05 0.4" rpy="0.2 0 0.1"/><axis xyz="0 1 0"/><limit lower="-0.8" upper="0.8"/></joint>
  <joint name="turn" type="continuous"><parent link="tilted"/><child link="panned"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 0 -1"/></joint>
  <joint name="lens" type="fixed"><parent link="panned"/><child link="eye"/>
    <origin xyz="0.05 0.03 0.02" rpy="-1.5708 0 -1.5708"/></joint>
</robot>"""


def off_axis(model: KinematicModel, eye: str, positions: dict[str, float], p_BP: np.ndarray) -> float:
    """Angle (rad) between the eye's axis and the point."""
    p_EP = model.pose(eye, positions).inverse().transform(p_BP)
    return math.atan2(math.hypot(p_EP[0], p_EP[1]), p_EP[2])


def test_straight_ahead_of_the_eye_nothing_turns() -> None:
    eye = MODEL.pose(EYE)
    gaze = aim(MODEL, EYE, HEAD, eye.translation + 2.0 * eye.rotation[:, 2], {})
    assert gaze.positions == pytest.approx({"pan_joint": 0.0, "tilt_joint": 0.0}, abs=1e-4)


def test_a_point_to_the_left_turns_the_head_to_the_left_and_one_above_up() -> None:
    left = aim(MODEL, EYE, HEAD, np.array([0.0, 3.0, 1.3]), {}).positions
    assert left["pan_joint"] == pytest.approx(math.pi / 2, abs=0.05)
    up = aim(MODEL, EYE, HEAD, np.array([3.0, 0.0, 2.0]), {}).positions
    above = math.atan2(2.0 - MODEL.pose(EYE).translation[2], 3.0)
    assert abs(up["tilt_joint"]) == pytest.approx(above, abs=0.05)
    assert off_axis(MODEL, EYE, dict(up), np.array([3.0, 0.0, 2.0])) < 1e-3


@settings(max_examples=60)
@example(2.8125, 0.8125, 0.0, 0.0, 0.0)  # beside and below: many short steps
@given(
    st.floats(-math.pi, math.pi),
    st.floats(0.8, 6.0),
    st.floats(-0.5, 3.0),
    st.floats(-2.2, 2.2),
    st.floats(-0.29, 0.43),
)
def test_no_positions_within_the_limits_look_nearer_to_the_point(
    bearing: float, range_m: float, height_m: float, pan: float, tilt: float
) -> None:
    point = np.array([range_m * math.cos(bearing), range_m * math.sin(bearing), height_m])
    gaze = aim(MODEL, EYE, HEAD, point, {"pan_joint": pan, "tilt_joint": tilt})
    for joint in HEAD:
        assert joint.lower <= gaze.positions[joint.name] <= joint.upper
    assert gaze.error_rad == pytest.approx(off_axis(MODEL, EYE, dict(gaze.positions), point), abs=1e-9)
    searched = min(
        off_axis(MODEL, EYE, {"pan_joint": float(p), "tilt_joint": float(t)}, point)
        for p in np.linspace(HEAD[0].lower, HEAD[0].upper, 21)
        for t in np.linspace(HEAD[1].lower, HEAD[1].upper, 5)
    )
    assert gaze.error_rad <= searched + 0.01


def test_another_body_with_other_joints_is_aimed_by_the_same_function(tmp_path: Path) -> None:
    path = tmp_path / "askew.urdf"
    path.write_text(ASKEW)
    model = load_model(path)
    joints = [JointLimits("nod", -0.8, 0.8, 1, 5), JointLimits("turn", -math.inf, math.inf, 1, 5)]
    for point in ([2.0, 0.0, 0.6], [1.0, -2.0, 0.3], [-1.0, 1.5, 0.9]):
        gaze = aim(model, "eye", joints, np.array(point), {})
        assert off_axis(model, "eye", dict(gaze.positions), np.array(point)) < math.radians(0.5), point


def test_an_unknown_link_is_named() -> None:
    with pytest.raises(KeyError, match="nose"):
        aim(MODEL, "nose", HEAD, np.array([1.0, 0.0, 1.0]), {})
