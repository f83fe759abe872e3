from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.link import BaseLimits
from app.messages import Zone, read_only
from app.modules.behaviors.navigation.controller import BodyModel
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.planning.route_planner import LegRequest, RouteFinder
from tests.modules.behaviors.driven_world import box, mapped
from tests.modules.behaviors.navigation.scenes import SQUARE

SIZE = (0.0, 0.0, 8.0, 5.0)
#: Two rooms, a door between them, and a closet without one.
WALLS = [*box(0.1, 0.1, 7.9, 4.9), (4.0, 0.1, 4.0, 2.0), (4.0, 2.9, 4.0, 4.9), *box(5.9, 3.3, 7.9, 4.9)]
GRID = mapped(WALLS, SIZE)
BODY = BodyModel.of(SQUARE, BaseLimits(0.5, 1.0, 0.5, 1.0))


def finder() -> RouteFinder:
    return RouteFinder(Footprint.polygon(np.array(SQUARE)), BODY)


def asked(**more: Any) -> LegRequest:
    request = LegRequest(GRID, (), start=Pose2(1.0, 2.4, 0.0), goal=Pose2(6.5, 2.4, math.nan), speed=1.0)
    return replace(request, **more)


def zone(kind: str, speed: float = 1.0) -> Zone:
    return Zone("doorway", kind, read_only(np.array([[3.0, 1.0], [5.0, 1.0], [5.0, 4.0], [3.0, 4.0]])), speed)


def test_a_leg_has_its_length_its_path_and_about_the_time_that_it_takes() -> None:
    leg = finder().find(asked())
    assert leg.state == "way"
    assert leg.reason == ""
    assert leg.path[0] == pytest.approx((1.0, 2.4))
    assert leg.path[-1] == pytest.approx((6.5, 2.4))
    assert leg.length_m == pytest.approx(5.5, abs=0.2)
    # Half a metre a second, and a second lost by speeding up and slowing down.
    assert leg.duration_s == pytest.approx(leg.length_m / 0.5 + 1.0, abs=0.01)


def test_what_takes_time_is_counted_in() -> None:
    found = finder()
    straight = found.find(asked()).duration_s
    slow = found.find(asked(zones=(zone("slow", 0.25),)))
    # Two metres at a quarter of the speed.
    assert slow.duration_s == pytest.approx(straight + 2.0 / 0.125 - 2.0 / 0.5, abs=0.5)
    assert found.find(asked(speed=0.5)).duration_s == pytest.approx((straight - 1.0) * 2 + 0.5, abs=0.01)
    # Half a turn before it and a quarter after it, at one radian a second.
    turned = found.find(asked(start=Pose2(1.0, 2.4, math.pi), goal=Pose2(6.5, 2.4, math.pi / 2)))
    assert turned.duration_s == pytest.approx(straight + 1.5 * math.pi, abs=0.4)


def test_a_leg_that_cannot_be_driven_says_why() -> None:
    found = finder()
    closet = found.find(asked(goal=Pose2(6.9, 4.1, 0.0)))
    assert (closet.state, len(closet.path), closet.length_m) == ("none", 0, 0.0)
    assert "wall the goal off" in closet.reason
    shut = found.find(asked(zones=(zone("keep_out"),)))
    assert shut.state == "none"
    assert "“doorway”" in shut.reason
    wall = found.find(asked(goal=Pose2(4.0, 1.2, math.nan)))
    assert wall.state == "near"
    assert "lies on an obstacle of the map" in wall.reason
    assert "start" not in wall.reason


def test_remembered_obstacles_count() -> None:
    barrier = np.stack((np.full(60, 4.0), np.linspace(1.9, 3.0, 60)), axis=1)
    found = finder()
    assert found.find(asked(persistent_obstacles=barrier)).state == "none"
    assert found.find(asked()).state == "way"


def test_a_leg_is_planned_again_only_once_the_map_or_a_zone_has_changed() -> None:
    found = finder()
    none = np.empty((0, 2))
    first = found.find(asked(persistent_obstacles=none))
    other = asked(persistent_obstacles=none, start=Pose2(2.0, 1.0, 0.0))
    assert found.find(other) is not first
    assert found.find(asked(persistent_obstacles=none)) is first
    assert found.find(asked(persistent_obstacles=none, zones=(zone("slow"),))) is not first
