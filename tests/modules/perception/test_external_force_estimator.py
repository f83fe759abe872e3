"""The module of forces on the hands: on joints given by hand, and on the simulated body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.base import paths
from app.base.kinematic_model import load_model
from app.link import RobotDescription
from app.messages import ExternalForces, JointState
from app.modules.perception.external_force import felt_efforts, force_on
from app.robots.config import StartPose, load_robot_config
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, FakeLink, drain
from tests.modules.perception.test_external_force import ARM, BENT, HAND, MODEL, felt_from
from tests.robots.conftest import make_hall
from tests.robots.simulated.arms import Arms, left_arm

ROBOT = paths.config_dir() / "robots" / "irl1_tr.yaml"
URDF = paths.config_dir() / "robots" / "irl1_tr.urdf"


class Irl1Link(FakeLink):
    """A body with IRL-1's model."""

    description: RobotDescription

    def __init__(self) -> None:
        super().__init__()
        self.description = replace(self.description, model_path=URDF)


def bench(*links: str) -> Bench:
    return Bench(
        "app.modules.perception.external_force_estimator:ExternalForceEstimator",
        inputs={"joints": JointState},
        outputs={"forces": ExternalForces},
        settings={"links": list(links or (HAND, "right_hand_link"))},
        link=Irl1Link(),
    )


async def estimated(b: Bench, *states: JointState) -> list[ExternalForces]:
    heard = b.listen("forces")
    for state in states:
        b.feed("joints", state)
        await b.settle()
    return drain(heard)


def pushed(stamp: float, force: tuple[float, float, float], share: float = 1.0) -> JointState:
    efforts = tuple(-share * effort for effort in felt_from(force, BENT).values())
    return JointState(stamp, ARM, tuple(BENT.values()), efforts)


def test_a_push_is_published_with_its_hand_and_a_touch_below_the_least_is_not() -> None:
    async def main() -> None:
        async with bench() as b:
            strong, weak, unmeasured = pushed(1.0, (-10.0, 2.0, 0.0)), pushed(2.0, (-10.0, 2.0, 0.0), 0.05), BENT
            found = await estimated(b, strong, weak, JointState(3.0, ARM, tuple(unmeasured.values())))
            assert [forces.stamp for forces in found] == [1.0, 2.0], "a body that measures no efforts has none"
            (force,) = found[0].forces
            assert force.link == HAND
            assert force.f_B == pytest.approx((-10.0, 2.0, 0.0))
            assert found[1].forces == ()

    run_virtual(main())


def test_a_joint_that_moves_freely_feels_nothing() -> None:
    async def main() -> None:
        async with bench() as b:
            still = JointState(1.0, ARM, (0.0, 0.3, 0.2, -0.9), (3.0, 0.0, 0.0, 0.0))
            moving = JointState(1.1, ARM, (0.5, 0.3, 0.2, -0.9), (3.0, 0.0, 0.0, 0.0))
            found = await estimated(b, still, moving)
            assert [len(forces.forces) for forces in found] == [1, 0], "5 rad/s against 0.6 N m s/rad are its 3 N m"

    run_virtual(main())


def test_a_link_that_the_body_does_not_have_is_said_so() -> None:
    async def main() -> None:
        async with bench("left_foot_link") as b:
            assert "no link 'left_foot_link'" in b.problem

    run_virtual(main())


@pytest.mark.parametrize("force", [(-10.0, 0.0, 0.0), (0.0, -10.0, 0.0), (0.0, 0.0, -10.0), (3.0, 0.0, 6.0)])
def test_a_force_on_the_simulated_hand_is_found_to_within_friction(force: tuple[float, float, float]) -> None:
    robot = load_robot_config(ROBOT).model_copy(update={"scenario": None, "start": StartPose(x=5, y=10)})
    arms, model = Arms(robot, make_hall()), load_model(robot.model)
    arms.run(2.5, left_arm())
    arms.force = np.array(force)
    arms.run(1.5, left_arm())
    names = arms.physics.joints
    felt = felt_efforts(model, dict(zip(names, arms.physics.motor_efforts().tolist(), strict=True)), {})
    found = force_on(model, HAND, arms.positions(), felt)
    assert found is not None
    assert np.linalg.norm(np.subtract(found.f_B, force)) < 0.8
    np.testing.assert_allclose(found.p_B, MODEL.pose(HAND, arms.positions()).translation)
