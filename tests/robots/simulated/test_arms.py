"""The arms in the physics: what they give way by, what they do without a command, and what their hands hold."""

from __future__ import annotations

import numpy as np
import pytest

from app.messages import JointCommand
from app.robots.config import RobotConfig, StartPose
from app.robots.simulated.world_config import WorldConfig
from tests.robots.conftest import make_hall
from tests.robots.simulated.arms import BENT, Arms, left_arm


@pytest.fixture
def standing(robot: RobotConfig) -> RobotConfig:
    return robot.model_copy(update={"start": StartPose(x=5, y=10, heading_deg=0)})


@pytest.fixture
def arms(standing: RobotConfig, hall: WorldConfig) -> Arms:
    return Arms(standing, hall)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "damping", "gives_m", "back_m"),
    [
        (0.0, 2.0, (0.5, 1.0), None),
        (5.0, 2.0, (0.28, 0.45), None),
        (20.0, 3.0, (0.06, 0.10), 0.02),
        (60.0, 6.0, (0.015, 0.035), 0.012),
        (300.0, 15.0, (0.0, 0.015), 0.012),
    ],
)
def test_pushed_by_10_newtons_it_gives_way_by_its_stiffness_and_returns(
    arms: Arms, stiffness: float, damping: float, gives_m: tuple[float, float], back_m: float | None
) -> None:
    arms.run(2.5, left_arm())
    command = left_arm(BENT, stiffness, damping)
    arms.run(0.5, command)
    before = arms.hand()
    arms.force = np.array([-10.0, 0.0, 0.0])
    arms.run(1.0, command)
    assert gives_m[0] <= np.linalg.norm(arms.hand() - before) <= gives_m[1]
    assert arms.status("left_arm").guard == "moving", "this is no contact to yield to"
    arms.force = np.zeros(3)
    arms.run(0.5, command)
    if back_m is not None:
        assert np.linalg.norm(arms.hand() - before) < back_m


def test_a_free_arm_stays_where_it_is(arms: Arms) -> None:
    arms.run(2.5, left_arm())
    before = arms.hand()
    arms.run(2.0, left_arm(BENT, 0.0, 0.5))
    assert np.linalg.norm(arms.hand() - before) < 0.005


def test_a_rise_of_stiffness_does_not_jump(arms: Arms) -> None:
    arms.run(2.5, left_arm())
    soft = left_arm((-1.2, 0.3, 0.2, -0.9), 0.0, 4.0)  # far from where it is
    arms.run(0.5, soft)
    before = arms.hand()
    stiff = left_arm((-1.2, 0.3, 0.2, -0.9), 300.0, 15.0)
    arms.run(0.1, stiff)
    assert np.linalg.norm(arms.hand() - before) < 0.5 * 4.0 * 0.1**2 * 0.55 + 0.005, "within its acceleration"
    arms.run(2.0, stiff)
    assert arms.positions()["left_shoulder_pitch_joint"] == pytest.approx(-1.2, abs=0.01)


def test_a_command_beyond_the_ranges_is_refused_by_name(arms: Arms) -> None:
    arms.run(0.1, left_arm(BENT, 60.0, 80.0))
    status = arms.status("left_arm")
    assert (status.guard, status.reason) == (
        "refused",
        "damping 80 of left_shoulder_pitch_joint lies outside 0.5 to 40 N m s/rad, the range of left_arm",
    )


def test_pushed_beyond_its_limit_it_yields_and_begins_again_with_a_later_command(arms: Arms) -> None:
    arms.run(2.5, left_arm())
    before = arms.hand()
    arms.force = np.array([-40.0, 0.0, 0.0])
    arms.run(0.3, left_arm())
    status = arms.status("left_arm")
    assert status.guard == "yielding"
    assert status.reason.startswith("contact: left_")
    arms.force = np.zeros(3)
    arms.run(0.5, left_arm())
    pushed = arms.hand()
    assert np.linalg.norm(pushed - before) > 0.1
    assert arms.status("left_arm").guard == "yielding", "for a second"
    arms.run(4.0, left_arm())
    assert arms.status("left_arm").guard == "moving"
    assert np.linalg.norm(arms.hand() - before) < 0.02


def test_a_fast_move_in_the_open_is_no_contact(arms: Arms) -> None:
    modes: set[str] = set()
    for position in ((-2.4, 1.7, 1.5, -2.1), (0.9, -0.1, -1.5, 0.0)):
        swing = left_arm(position, 300.0, 15.0)
        arms.run(1.5, swing, each=lambda: modes.add(arms.status("left_arm").guard))
    assert modes == {"moving"}


def test_an_arm_that_meets_a_wall_does_not_press_on(standing: RobotConfig) -> None:
    wall = {"kind": "box", "at": (5.55, 10.0), "size": (0.1, 1.0, 1.4)}
    arms = Arms(standing, make_hall(objects=[wall]))
    arms.run(2.0, left_arm((0.0, 0.0, 0.0, -2.1)))
    pressed: list[float] = []
    elbow = arms.physics.joint_numbers(["left_elbow_joint", "left_shoulder_pitch_joint"])
    stretched = left_arm((-1.5, 0.0, 0.0, 0.0), 300.0, 15.0)
    arms.run(
        3.0, stretched, each=lambda: pressed.append(float(np.abs(arms.physics.motor_efforts()[elbow]).max()))
    )  # fmt: skip
    above = np.array(pressed) > 8.0
    longest = max(len(run) for run in "".join("x" if a else " " for a in above).split())
    assert longest * 0.004 <= 0.12, "no joint presses for longer than a tenth of a second"


def test_without_a_command_an_arm_is_held_softly_where_it_was_going(arms: Arms) -> None:
    arms.run(1.0, left_arm())
    arms.run(1.5)
    held = arms.hand()
    assert arms.status("left_arm").guard == "idle"
    arms.force = np.array([0.0, 10.0, 0.0])
    arms.run(1.0)
    assert 0.01 < np.linalg.norm(arms.hand() - held) < 0.1
    arms.force = np.zeros(3)
    arms.run(1.5)
    assert np.linalg.norm(arms.hand() - held) < 0.015


def test_an_emergency_stop_lets_the_arm_be_pushed_away(arms: Arms) -> None:
    arms.run(1.0, left_arm((-1.5, 0.3, 0.2, -0.9)))
    arms.e_stop = "a test"
    arms.run(1.0, left_arm((-1.5, 0.3, 0.2, -0.9)))
    assert arms.status("left_arm").guard == "yielding"
    before = arms.hand()
    arms.run(1.0)
    assert np.linalg.norm(arms.hand() - before) < 0.005, "its weight is compensated"
    arms.force = np.array([-10.0, 0.0, 0.0])
    arms.run(1.0)
    arms.force = np.zeros(3)
    arms.run(1.0)
    pushed = arms.hand()
    assert np.linalg.norm(pushed - before) > 0.15
    arms.run(1.0)
    assert np.linalg.norm(arms.hand() - pushed) < 0.01, "and stays there"


def test_a_hand_closes_on_a_box_lifts_it_and_keeps_it_without_commands(standing: RobotConfig) -> None:
    pillar = {"kind": "box", "at": (5.42, 10.2), "size": (0.1, 0.12, 0.66)}
    box = {"kind": "box", "at": (5.43, 10.2), "z": 0.661, "size": (0.04, 0.04, 0.12), "mass_kg": 0.2}
    arms = Arms(standing, make_hall(objects=[pillar, box]))

    def gripper(position: float) -> JointCommand:
        return JointCommand(0.0, "left_gripper", ("left_gripper_joint",), (position,))

    def lift() -> float:
        return float(arms.physics.data.body("box1").xpos[2]) - 0.66

    arms.run(2.5, left_arm((0.0, 0.0, 0.0, -2.1)), gripper(0.04))  # up before forward, or it hits the pillar
    arms.run(1.5, left_arm((-0.8, 0.0, 0.0, -2.1)), gripper(0.04))
    around = left_arm((-0.8, 0.0, 0.0, -0.77))
    arms.run(2.0, around, gripper(0.04))
    assert abs(lift()) < 0.001, "nothing touched it"
    arms.run(1.0, around, gripper(0.0))
    assert arms.positions()["left_gripper_joint"] == pytest.approx(0.02, abs=0.004), "half of its 40 mm"
    above = left_arm((-0.8, 0.0, 0.0, -1.4))
    arms.run(1.5, above, gripper(0.0))
    lifted = lift()
    assert lifted > 0.14
    arms.run(3.0, above, gripper(0.0))
    arms.run(3.0)
    assert arms.status("left_gripper").guard == "idle"
    assert lift() == pytest.approx(lifted, abs=0.004), "it stays in the hand"
    arms.run(1.0, gripper(0.04))
    assert lift() < 0.01, "and falls when the hand opens"
