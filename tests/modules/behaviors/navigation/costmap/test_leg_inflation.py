"""Room is left beside legs, which are narrower than their person, also when the laser does not see them any more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.messages import LaserScan
from app.modules.behaviors.navigation.costmap.leg_inflation import LegMemory
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings
from tests.modules.behaviors.driven_world import box, mapped
from tests.modules.behaviors.navigation.boxes import Box, World

GRID = mapped([*box(0.1, 0.1, 7.9, 7.9), (3.0, 2.0, 3.05, 2.0)], (0.0, 0.0, 8.0, 8.0))
X_MO = Pose2(1.0, 1.0, 0.0)
KEPT = CostmapSettings(forget_s=3.0, steady_s=1.0, keep_s=20.0)
LEG: Box = (1.5, 0.2, 1.6, 0.3, 0.0, 2.0)
#: From there the laser sees it, and from there it does not: it is beside it.
BEFORE, BESIDE = Pose2(0.3, 1.0, 0.0), Pose2(1.55, 0.8, 0.0)


def room_after(*seen: tuple[LaserScan, Pose2], now: float, room_m: float = 0.1) -> NDArray[np.float64]:
    """The room at ``now`` (s) after the scans, each from a pose."""
    memory = LegMemory(KEPT)
    for scan, X_OB in seen:
        memory.see(scan, X_OB, X_MO, GRID)
    return memory.room(now, room_m)


def looks(from_s: float, until_s: float, at: Pose2, *boxes: Box) -> list[tuple[LaserScan, Pose2]]:
    """Scans, ten a second."""
    return [(World(boxes).scan(stamp, at), at) for stamp in np.arange(from_s, until_s + 0.01, 0.1)]


def test_room_is_left_around_legs_but_not_around_a_post_of_the_map() -> None:
    scan = World(((2.0, 0.95, 2.1, 1.05, 0.0, 2.0), LEG)).scan(0.0, BEFORE)
    room = room_after((scan, BEFORE), now=0.0)
    away = np.hypot(*(room - np.array([1.5, 0.25])).T)
    assert 0.05 < away.max() < 0.16, "the one at (3.0, 2.0) on the map is a post; about its near side"
    assert away.min() < 0.06, "to the leg itself: a body that stands in the outer part keeps off the inner one"


def test_a_laser_mounted_upside_down_has_them_on_the_other_side() -> None:
    scan = World((LEG,)).scan(0.0, BEFORE)
    hung = replace(
        scan,
        ranges=scan.ranges[::-1],
        X_BL=scan.X_BL @ Pose3.from_translation_rpy((0.0, 0.0, 0.0), (np.pi, 0.0, 0.0)),
    )
    room, same = (room_after((s, BEFORE), now=0.0) for s in (scan, hung))
    assert np.abs(room.mean(axis=0) - same.mean(axis=0)).max() < 0.01
    gone = room_after((hung, BEFORE), *looks(0.1, 0.1, BEFORE), now=0.1)
    assert not len(gone)


@pytest.mark.parametrize(
    ("seen_s", "after_s", "kept"), [(0.5, 2.5, True), (0.5, 3.5, False), (1.5, 19.0, True), (1.5, 21.0, False)]
)
def test_legs_beside_the_laser_are_kept_as_the_costmap_keeps_their_cells(
    seen_s: float, after_s: float, *, kept: bool
) -> None:
    seen = looks(0.0, seen_s, BEFORE, LEG)
    past = looks(seen_s + 0.1, seen_s + after_s, BESIDE, LEG)
    room = room_after(*seen, *past, now=seen_s + after_s)
    assert (len(room) > 0) is kept
    assert not kept or np.abs(room.mean(axis=0) - np.array([1.5, 0.25])).max() < 0.06


def test_legs_that_rays_pass_are_gone_at_once_and_those_behind_something_are_not() -> None:
    seen = looks(0.0, 1.5, BEFORE, LEG)
    assert not len(room_after(*seen, *looks(1.6, 1.6, BEFORE), now=1.6))
    screen = (1.0, 0.2, 1.1, 1.0, 0.0, 2.0)
    assert len(room_after(*seen, *looks(1.6, 1.6, BEFORE, screen), now=1.6))


def test_a_leg_that_walks_leaves_no_room_where_it_was() -> None:
    memory = LegMemory(KEPT)
    for step in range(30):
        x = 1.5 + 0.05 * step
        memory.see(World(((x, 0.2, x + 0.1, 0.3, 0.0, 2.0),)).scan(0.1 * step, BEFORE), BEFORE, X_MO, GRID)
    room = memory.room(3.0, 0.1)
    assert np.abs(room - np.array([x, 0.25])).max() < 0.25


def test_noise_does_not_shake_the_room_of_one_who_stands() -> None:
    memory, middles = LegMemory(KEPT), []
    for step in range(40):
        memory.see(World((LEG,)).scan(0.1 * step, BEFORE, noise_m=0.02), BEFORE, X_MO, GRID)
        middles.append(memory.room(0.1 * step, 0.1).mean(axis=0))
    steps = np.abs(np.diff(np.array(middles)[5:], axis=0))
    assert steps.max() < 0.012, "a fifth of what one scan is off"
