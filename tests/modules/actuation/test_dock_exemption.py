"""The collision monitor and a dock: the docking behavior alone may near it, at a crawl, and nothing else is exempt."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.link import BaseLimits
from app.messages import DockSighting, LaserScan, Odometry, Twist
from app.modules.actuation.collision_context import CollisionContext
from app.modules.actuation.collision_monitor import CollisionMonitor, MonitorRules
from app.modules.actuation.dock_exemption import without_dock
from app.robots.actuator_config import circle

LIMITS = BaseLimits(0.40, 1.00, 0.40, 4.00)
OPENING = 2 * math.pi / 3
#: Where the robot stands in odom, and how far ahead of it the plates meet: they all but touch it.
X_OB, NEAR_M = Pose2(2.0, 1.0, 0.5), 0.335


def dock_at(distance: float, stamp: float = 10.0, plate_m: float = 0.25, aside: float = 0.0) -> DockSighting:
    return DockSighting(stamp, X_OB @ Pose2(distance, aside, math.pi), plate_m, OPENING)


def scan_of_the_dock(distance: float, *, foot: bool = False) -> LaserScan:
    """What the laser, 0.2 m ahead of base_link, sees of the dock; with ``foot``, of something in its mouth too."""
    ahead = distance - 0.2
    angles = np.linspace(-math.pi / 2, math.pi / 2, 720)
    ranges = np.full(720, np.inf, np.float32)
    half = OPENING / 2
    for index, angle in enumerate(angles):
        for sign in (1, -1):
            # A plate from (ahead, 0) in the laser's frame, at ±120° from its x axis.
            direction = complex(-math.cos(half), sign * math.sin(half))
            ray = complex(math.cos(angle), math.sin(angle))
            across = (ray.conjugate() * direction).imag
            if abs(across) < 1e-9:
                continue
            along = -(ray.conjugate() * ahead).imag / across
            distance = ((ahead + along * direction) * ray.conjugate()).real
            if 0 <= along <= 0.25 and 0.1 < distance < ranges[index]:
                ranges[index] = distance
        if foot and abs(angle) < 0.1:
            ranges[index] = 0.105
    return LaserScan(
        10.0, "laser", ranges, np.zeros(720, np.float32), angle_min=float(angles[0]),
        angle_increment=float(angles[1] - angles[0]), range_min=0.1, range_max=30.0, duration_s=0.0,
        X_BL=Pose3.from_translation_rpy((0.2, 0.0, 0.4), (0.0, 0.0, 0.0)),
    )  # fmt: skip


def context(dock: DockSighting | None, distance: float = NEAR_M, *, foot: bool = False) -> CollisionContext:
    made = CollisionContext(CollisionMonitor(circle(0.28), LIMITS, MonitorRules()), LIMITS, 0.25)
    made.moved(Odometry(10.0, X_OB, 0.0, 0.0))
    made.scanned(scan_of_the_dock(distance, foot=foot))
    if dock is not None:
        made.sighted(dock)
    return made


def given(made: CollisionContext, linear: float, *, docking: bool) -> float:
    """The speed let through of ``linear`` m/s straight ahead, once it has accelerated."""
    return made.limit(Twist(9.9, linear, 0.0), Twist(10.0, linear, 0.0), 0.1, by_hand=False, docking=docking)[
        0
    ].linear_mps


def test_the_dock_stops_every_behavior_but_docking() -> None:
    assert given(context(dock_at(NEAR_M)), 0.05, docking=False) == 0.0
    assert given(context(dock_at(NEAR_M)), 0.05, docking=True) == pytest.approx(0.05)


def test_docking_may_no_more_than_crawl_into_it() -> None:
    assert given(context(dock_at(NEAR_M)), 0.4, docking=True) == pytest.approx(MonitorRules().crawl_mps)


def test_a_foot_in_the_docks_mouth_stops_docking_too() -> None:
    assert given(context(dock_at(0.45), 0.45), 0.05, docking=True) == pytest.approx(0.05)
    assert given(context(dock_at(0.45), 0.45, foot=True), 0.05, docking=True) == 0.0


@pytest.mark.parametrize(
    "dock",
    [
        None,
        pytest.param(dock_at(NEAR_M, stamp=9.0), id="seen a second ago"),
        pytest.param(dock_at(NEAR_M, plate_m=5.0), id="as long as a wall"),
        pytest.param(dock_at(NEAR_M, stamp=math.nan), id="without a time"),
        pytest.param(dock_at(NEAR_M, aside=0.6), id="elsewhere"),
    ],
)
def test_without_a_dock_that_is_there_docking_is_stopped_as_others_are(dock: DockSighting | None) -> None:
    assert given(context(dock), 0.05, docking=True) == 0.0


def test_points_of_the_plates_alone_are_left_out() -> None:
    half = OPENING / 2
    on_plate = 0.45 - 0.2 * complex(math.cos(half), math.sin(half))
    points = np.array([on_plate, 0.45 + 0j, 0.30 + 0j, 1.0 + 1.0j])
    assert without_dock(points, dock_at(0.45), X_OB).tolist() == [0.30 + 0j, 1.0 + 1.0j]
