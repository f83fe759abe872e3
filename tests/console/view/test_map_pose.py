"""Where the scene lays the map."""

from __future__ import annotations

import math

import pytest

from app.base.geometry import Pose2
from app.console.view.map_pose import PATIENCE_S, MapPose
from tests.console.places import localization

BEFORE = Pose2(1.0, 0.0, 0.0)
AFTER = Pose2(1.4, 0.3, 0.2)


def closed(state: str = "mapping", name: str = "lab") -> MapPose:
    """At 10 s the robot's place jumps."""
    pose = MapPose()
    pose.take(localization(9.9, BEFORE))
    pose.take(localization(10.0, AFTER, state=state, name=name))
    return pose


def test_there_is_none_before_the_robot_has_a_place() -> None:
    assert MapPose().at(0.0) is None


def test_drift_is_followed_at_once() -> None:
    pose = MapPose()
    for step in range(50):
        X_MO = Pose2(0.02 * step, 0.0, 0.001 * step)
        pose.take(localization(0.1 * step, X_MO))
        assert pose.at(-1.0) == X_MO.inverse()


def test_a_map_of_before_a_loop_was_closed_stays_where_it_fits() -> None:
    pose = closed()
    assert pose.at(9.0) == BEFORE.inverse()
    # The same place again, corrected a little more: the map still waits.
    pose.take(localization(10.1, AFTER @ Pose2(0.2, 0.0, 0.0)))
    assert pose.at(9.0) == BEFORE.inverse()
    assert pose.at(10.2) == (AFTER @ Pose2(0.2, 0.0, 0.0)).inverse()
    # The map has followed: there is nothing to wait for.
    assert pose.at(9.0) == (AFTER @ Pose2(0.2, 0.0, 0.0)).inverse()


def test_a_map_that_does_not_follow_is_waited_for_no_longer() -> None:
    pose = closed()
    pose.take(localization(10.0 + PATIENCE_S + 0.1, AFTER))
    assert pose.at(9.0) == AFTER.inverse()


@pytest.mark.parametrize(("state", "name"), [("tracking", "lab"), ("mapping", "other")])
def test_a_robot_found_elsewhere_is_there_at_once(state: str, name: str) -> None:
    assert closed(state, name).at(9.0) == AFTER.inverse()


def test_a_turn_across_the_seam_is_none() -> None:
    pose = MapPose()
    for stamp, theta in ((1.0, math.pi - 0.001), (2.0, -math.pi + 0.001)):
        pose.take(localization(stamp, Pose2(0.0, 0.0, theta)))
    at = pose.at(0.0)
    assert at is not None
    assert at.theta == pytest.approx(math.pi - 0.001)
