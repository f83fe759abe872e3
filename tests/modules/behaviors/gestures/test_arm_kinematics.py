"""Where an arm's joints must be: against the forward kinematics of the model itself, of this body and of others."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.base.kinematic_model import KinematicModel, load_model
from app.link import JointLimits
from app.modules.behaviors.gestures.arm_kinematics import ArmKinematics, OtherArm, OutOfReach, arm_kinematics

MODEL = load_model(Path(__file__).parents[4] / "config" / "robots" / "irl1_tr.urdf")
SIDES = ("left", "right")
NEAR = np.zeros(4)
#: An arm that is reached forward at 0, whose axes point the other way, on a body that is turned.
FORWARD = """<robot name="forward">
  <link name="base_link"/><link name="body"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
  <link name="palm"/>
  <joint name="mount" type="fixed"><parent link="base_link"/><child link="body"/>
    <origin xyz="0.1 0.2 0.8" rpy="0 0 0.4"/></joint>
  <joint name="lift" type="revolute"><parent link="body"/><child link="a"/>
    <axis xyz="0 -1 0"/><limit lower="-2" upper="2"/></joint>
  <joint name="spread" type="revolute"><parent link="a"/><child link="b"/>
    <axis xyz="0 0 1"/><limit lower="-1.5" upper="1.5"/></joint>
  <joint name="turn" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0.1 0 0"/>
    <axis xyz="-1 0 0"/></joint>
  <joint name="fold" type="revolute"><parent link="c"/><child link="d"/><origin xyz="0.2 0.03 0"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="2.5"/></joint>
  <joint name="wrist" type="fixed"><parent link="d"/><child link="palm"/><origin xyz="0.25 -0.03 0"/></joint>
</robot>"""


def limits(model: KinematicModel, names: tuple[str, ...]) -> list[JointLimits]:
    return [JointLimits(n, model.joints[n].lower, model.joints[n].upper, velocity=1, acceleration=5) for n in names]


def arm(side: str) -> ArmKinematics:
    names = tuple(f"{side}_{joint}_joint" for joint in ("shoulder_pitch", "shoulder_roll", "upper_arm", "elbow"))
    return arm_kinematics(MODEL, limits(MODEL, names), f"{side}_hand_link")


def forward(tmp_path: Path, text: str = FORWARD) -> tuple[KinematicModel, ArmKinematics]:
    path = tmp_path / "forward.urdf"
    path.write_text(text)
    model = load_model(path)
    return model, arm_kinematics(model, limits(model, ("fold", "lift", "spread", "turn")), "palm")


def hand(model: KinematicModel, link: str, kinematics: ArmKinematics, positions: np.ndarray) -> np.ndarray:
    return np.asarray(model.pose(link, dict(zip(kinematics.names, positions.tolist(), strict=True))).translation)


@pytest.mark.parametrize("side", SIDES)
def test_three_hundred_reachable_points_are_reached_within_the_limits(side: str) -> None:
    kinematics, random = arm(side), np.random.default_rng(1)
    for positions in random.uniform(kinematics.lower, kinematics.upper, (300, 4)):
        point = hand(MODEL, f"{side}_hand_link", kinematics, positions)
        found = kinematics.reach(point, NEAR)
        assert ((found >= kinematics.lower) & (found <= kinematics.upper)).all()
        for posture in found:
            reached = hand(MODEL, f"{side}_hand_link", kinematics, posture)
            assert np.linalg.norm(reached - point) <= 0.005, (positions, posture)
        np.testing.assert_allclose(kinematics.hand(found), np.tile(point, (len(found), 1)), atol=1e-9)


def test_the_posture_nearest_to_the_one_asked_for_comes_first() -> None:
    kinematics = arm("left")
    point = kinematics.hand(np.array([-0.6, 0.3, 0.2, -1.0]))
    raised, lowered = (kinematics.reach(point, np.array([pitch, 0.4, 0.0, -1.0]))[0] for pitch in (-2.0, 0.5))
    assert raised[0] < lowered[0]


@pytest.mark.parametrize(
    ("beside", "problem"),
    [((0.56, 0.0, 0.0), "0.56 m from the shoulder.* reaches 0.5[0-9] m"), ((0.1, 0, 0), "comes no nearer than 0.2")],
)
def test_points_too_far_and_too_near_are_refused_with_their_distance(
    beside: tuple[float, float, float], problem: str
) -> None:
    kinematics = arm("left")
    with pytest.raises(OutOfReach, match=problem):
        kinematics.reach(kinematics.X_BS.translation + np.array(beside), NEAR)


def test_a_point_that_only_another_posture_than_the_limits_allow_would_reach_is_refused() -> None:
    kinematics = arm("left")
    with pytest.raises(OutOfReach, match="limits"):
        kinematics.reach(kinematics.X_BS.translation + np.array([-0.45, 0.0, 0.2]), NEAR)


def error_deg(kinematics: ArmKinematics, side: str, positions: np.ndarray, point: np.ndarray) -> float:
    """Angle at the shoulder between the hand of the model itself and the point."""
    shoulder = MODEL.pose(f"{side}_shoulder_link").translation
    to_hand, to_point = hand(MODEL, f"{side}_hand_link", kinematics, positions) - shoulder, point - shoulder
    return math.degrees(math.atan2(np.linalg.norm(np.cross(to_hand, to_point)), to_hand @ to_point))


def test_points_within_sixty_degrees_are_pointed_at_within_five_by_the_better_arm() -> None:
    arms, random = {side: arm(side) for side in SIDES}, np.random.default_rng(2)
    for _ in range(300):
        azimuth, elevation = random.uniform(-math.pi / 3, math.pi / 3), random.uniform(-0.9, 0.9)
        distance = random.uniform(1.0, 5.0)
        ahead, height = distance * math.cos(azimuth), 0.9 + distance * math.sin(elevation)
        point = np.array([ahead, distance * math.sin(azimuth), height])
        pointings = {side: kinematics.point(point, NEAR) for side, kinematics in arms.items()}
        for side, pointing in pointings.items():
            assert ((pointing.positions >= arms[side].lower) & (pointing.positions <= arms[side].upper)).all()
            seen = error_deg(arms[side], side, pointing.positions, point)
            assert math.degrees(pointing.error_rad) == pytest.approx(seen, abs=1e-4)
        assert min(pointing.error_rad for pointing in pointings.values()) <= math.radians(5), point


def test_a_hand_points_at_a_near_thing_without_touching_it() -> None:
    kinematics = arm("left")
    point = kinematics.X_BS.translation + np.array([0.4, 0.05, -0.1])
    pointing = kinematics.point(point, NEAR)
    assert np.linalg.norm(kinematics.hand(pointing.positions) - point) == pytest.approx(0.05, abs=1e-6)
    assert error_deg(kinematics, "left", pointing.positions, point) < 0.01


def test_another_body_with_other_axes_is_read_from_its_model(tmp_path: Path) -> None:
    model, kinematics = forward(tmp_path)
    assert kinematics.names == ("lift", "spread", "turn", "fold"), (
        "from the shoulder to the elbow, however they are listed"
    )
    assert (kinematics.upper_m, kinematics.forearm_m) == pytest.approx((0.3, 0.25))
    random = np.random.default_rng(3)
    low, high = np.maximum(kinematics.lower, -3), np.minimum(kinematics.upper, 3)
    for positions in random.uniform(low, high, (50, 4)):
        point = hand(model, "palm", kinematics, positions)
        np.testing.assert_allclose(kinematics.hand(positions), point, atol=1e-9)
        reached = hand(model, "palm", kinematics, kinematics.reach(point, NEAR)[0])
        assert np.linalg.norm(reached - point) < 0.005


@pytest.mark.parametrize(
    ("before", "after", "problem"),
    [
        ('<origin xyz="0.1 0 0"/>', '<origin xyz="0.1 0.02 0"/>', "lift, spread, turn must meet in one point"),
        ('xyz="0 0 1"', 'xyz="0 0.3 1"', "right angles"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 0 1"/>', "fold and lift must be parallel"),
        ('<origin xyz="0.25 -0.03 0"/>', '<origin xyz="0.25 0 0"/>', "palm must be on one line"),
        ('name="turn" type="continuous"', 'name="turn" type="prismatic"', "turn slides"),
        ('name="turn" type="continuous"', 'name="turn" type="fixed"', "the same four"),
    ],
)
def test_an_arm_of_another_kind_is_refused_in_words(tmp_path: Path, before: str, after: str, problem: str) -> None:
    text = FORWARD.replace(before, after)
    assert text != FORWARD
    with pytest.raises(OtherArm, match=problem):
        forward(tmp_path, text)


def test_joints_that_do_not_move_the_hand_are_refused() -> None:
    kinematics = arm("left")
    with pytest.raises(OtherArm, match="right_hand_link is moved by right_shoulder_pitch_joint"):
        arm_kinematics(MODEL, kinematics.joints, "right_hand_link")
    with pytest.raises(KeyError, match="paw"):
        arm_kinematics(MODEL, [replace(joint) for joint in kinematics.joints], "paw")
