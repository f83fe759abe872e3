"""Which poses may be driven by."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.messages import Localization, Odometry
from app.modules.behaviors.navigation.tracking.localization_monitor import LocalizationMonitor

NOW = 10.0


def odometry(stamp: float) -> Odometry:
    return Odometry(stamp, Pose2(), 0.0, 0.0)


def localization(stamp: float) -> Localization:
    return Localization(stamp, Pose2(), Pose2(), np.zeros((3, 3)), "tracking", 1.0, "lab")


def watch(moved: float = NOW, placed: float = NOW) -> LocalizationMonitor:
    poses = LocalizationMonitor()
    poses.add_odometry(odometry(moved))
    poses.add_localization(localization(placed))
    return poses


def test_fresh_poses_may_be_driven_by() -> None:
    assert watch().problem(NOW) == watch(NOW - 0.2, NOW - 0.9).problem(NOW) == ""


@pytest.mark.parametrize("off_s", [5.0, math.inf, math.nan])
def test_poses_of_another_clock_may_not(off_s: float) -> None:
    assert watch(moved=NOW + off_s).problem(NOW) == "odometry's stamps are not of the robot's clock"
    assert watch(placed=NOW + off_s).problem(NOW) == "localization's stamps are not of the robot's clock"


def test_a_stamp_that_is_no_number_leaves_the_place_one() -> None:
    poses = watch(moved=math.nan)
    assert poses.X_MB(NOW) == Pose2()
    poses.add_odometry(odometry(NOW))
    assert poses.at(NOW) == Pose2()


def test_one_bad_stamp_does_not_make_the_next_ones_last_longer() -> None:
    poses = watch(placed=math.nan)
    poses.add_localization(localization(NOW - 1.2))
    assert poses.problem(NOW)


def test_old_poses_may_not_and_the_words_stay() -> None:
    said = {watch(placed=NOW - age_s).problem(NOW) for age_s in (1.1, 2.0, 60.0)}
    assert said == {"it waits to be localized: SLAM has just started, or this computer is too slow for it"}
    assert watch(moved=NOW - 0.4).problem(NOW).startswith("there is no odometry")


@pytest.mark.parametrize(
    ("state", "moved", "placed", "is_lost"),
    [
        ("lost", NOW, NOW, True),
        ("searching", NOW, NOW, True),
        ("tracking", NOW, NOW, False),
        ("lost", NOW - 1.0, NOW, False),
        ("lost", NOW, NOW - 9.0, False),
        ("lost", NOW, math.nan, False),
    ],
)
def test_a_body_is_astray_where_its_place_on_the_map_alone_is_not_known(
    state: str, moved: float, placed: float, is_lost: bool
) -> None:
    poses = watch(moved=moved)
    poses.add_localization(replace(localization(placed), state=state))
    assert poses.is_lost(NOW) is is_lost
