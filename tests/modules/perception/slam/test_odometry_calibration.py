"""What odometry is off by is learnt from where scans are found."""

import math

import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.odometry_calibration import OdometryRatios


@pytest.mark.parametrize(("length", "turn"), [(1.05, 1.0), (0.96, 0.9), (1.0, 1.06)])
@pytest.mark.parametrize("said", [1.0, 0.3])
def test_ratios_come_to_what_the_robot_does(length: float, turn: float, said: float) -> None:
    """Also where a scan gives back but a part of what odometry was off: the rest is learnt from the next ones."""
    ratios = OdometryRatios()
    unknown_m = unknown_rad = 0.0
    for _ in range(4000):
        step = ratios.corrected(Pose2(0.1, 0.0, 0.04))
        unknown_m += 0.1 * length - step.x
        unknown_rad += 0.04 * turn - step.theta
        # As seen from the body after its step.
        c, s = math.cos(step.theta), math.sin(step.theta)
        ratios.learn(step, Pose2(c * said * unknown_m, -s * said * unknown_m, said * unknown_rad))
        unknown_m -= said * unknown_m
        unknown_rad -= said * unknown_rad
    assert ratios.length == pytest.approx(length, abs=0.003)
    assert ratios.turn == pytest.approx(turn, abs=0.003)


def test_nothing_is_learnt_where_scans_report_nothing_nor_from_a_slip() -> None:
    ratios = OdometryRatios()
    step = Pose2(0.1, 0.0, 0.1)
    for _ in range(100):
        ratios.learn(step, Pose2())
        ratios.learn(step, Pose2(-0.5, 0.0, 0.4))
    assert (ratios.length, ratios.turn) == (1.0, 1.0)


def test_odometry_is_believed_within_bounds() -> None:
    ratios = OdometryRatios()
    for _ in range(5000):
        ratios.learn(Pose2(0.1, 0.0, 0.1), Pose2(-0.02, 0.0, 0.02))
    assert 0.8 < ratios.length < 0.9
    assert 1.1 < ratios.turn < 1.2
