"""The collision monitor's judgement, alone: what it slows, what it stops, and what it never holds back."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from app.base.geometry import Pose2, Pose3
from app.link import BaseLimits
from app.messages import LaserScan
from app.modules.actuation.collision_monitor import STANDING_MPS, CollisionMonitor, MonitorRules, Verdict
from app.modules.actuation.swept_footprint import Polygon, contact_times
from app.robots.actuator_config import circle
from tests.modules.actuation.surroundings import passage, scan, wall

LIMITS = BaseLimits(0.4, 1.0, 0.4, 4.0)
HOLONOMIC = BaseLimits(0.4, 1.0, 0.4, 4.0, lateral_mps=0.4)
RULES = MonitorRules()
ROUND = circle(0.28)
BOX = ((0.254, -0.215), (0.254, 0.215), (-0.254, 0.215), (-0.254, -0.215))
STILL = Pose2()


def judged(
    seen: LaserScan, velocity: complex, angular: float = 0.0, *, corners: tuple[tuple[float, float], ...] = ROUND,
    moved: Pose2 = STILL, rules: MonitorRules = RULES, standing: bool = False,
) -> Verdict:  # fmt: skip
    monitor = CollisionMonitor(corners, LIMITS, rules)
    return monitor.judge(monitor.see(seen), moved, velocity, angular, standing=standing)


def test_in_the_open_everything_is_allowed() -> None:
    for linear, angular in ((0.4, 0.0), (0.4, 1.0), (0.0, -1.0), (0.2, -0.7)):
        assert judged(scan(0.0), linear, angular) == Verdict(linear, angular)


def test_the_nearer_a_wall_the_slower_and_before_it_not_at_all() -> None:
    speeds = [judged(wall(0.0, 0.28 + gap), 0.4).linear for gap in np.arange(1.0, 0.0, -0.02)]
    assert speeds[0] == 0.4
    assert all(later <= earlier for earlier, later in pairwise(speeds))
    assert speeds[-1] == 0.0
    stopped = judged(wall(0.0, 0.34), 0.4)
    assert stopped == Verdict(0.0, 0.0, "stopped: something 0.1 m ahead")
    assert judged(wall(0.0, 0.63), 0.4).reason == "slowed: something 0.3 m ahead"


@given(st.floats(0.34, 1.2), st.floats(0.02, 0.4))
def test_what_is_allowed_can_be_stopped_before_the_margin_and_leaves_time(ahead_m: float, speed: float) -> None:
    allowed = judged(wall(0.0, ahead_m), speed).linear
    clear = ahead_m - 0.28 / math.cos(math.pi / 16) - RULES.margin_m
    assert allowed * RULES.reaction_s + allowed**2 / (2 * LIMITS.linear_mps2) <= max(clear, 0.0) + 0.01
    assert allowed * RULES.contact_s <= max(clear, 0.0) + 0.01


def test_the_arc_is_kept_while_it_is_slowed() -> None:
    allowed = judged(wall(0.0, 0.6), 0.4, 0.3)
    assert 0 < allowed.linear < 0.4
    assert allowed.angular / allowed.linear == pytest.approx(0.3 / 0.4)


@pytest.mark.parametrize("width_m", [1.0, 0.9, 0.7])
def test_a_doorway_is_driven_through_at_full_speed(width_m: float) -> None:
    assert judged(passage(0.0, width_m), 0.4) == Verdict(0.4, 0.0)


def test_a_passage_narrower_than_its_margins_is_crawled_through() -> None:
    allowed = judged(passage(0.0, 0.62), 0.4)
    assert allowed.linear == pytest.approx(RULES.crawl_mps)
    assert judged(passage(0.0, 0.50), 0.4).linear == 0.0, "one that it does not fit in is not"


def test_where_the_arc_is_stopped_it_still_turns_on_the_spot() -> None:
    allowed = judged(wall(0.0, 0.34), 0.4, 1.0)
    assert (allowed.linear, allowed.angular) == (0.0, 1.0)
    assert allowed.reason == "stopped: something 0.1 m ahead; it turns"


def test_corners_that_turn_into_something_are_stopped_and_round_bodies_are_not() -> None:
    beside = scan(0.0, [(0.1, 0.29)], half_rad=math.pi)
    assert judged(beside, 0.0, 1.0, corners=circle(0.23)) == Verdict(0.0, 1.0)
    stopped = judged(beside, 0.0, 1.0, corners=BOX)
    assert stopped.angular < 0.6
    assert "to the left" in stopped.reason
    assert judged(scan(0.0, [(0.24, 0.23)]), 0.0, 1.0, corners=BOX).angular == 0.0


@given(st.floats(-math.pi / 2, math.pi / 2), st.floats(0.0, 0.07), st.sampled_from([ROUND, BOX]))
def test_away_from_what_is_too_near_is_never_held_back(
    bearing: float, gap_m: float, corners: tuple[tuple[float, float], ...]
) -> None:
    """Something within the margin, or touching: straight away from it is free, as far as the laser sees."""
    outline = Polygon.of(corners, gap_m)
    direction = complex(math.cos(bearing), math.sin(bearing))
    reach = min(
        offset / along
        for offset, along in zip(outline.offsets, (outline.normals.conj() * direction).real, strict=True)
        if along > 1e-6
    )
    point = direction * reach
    assume(abs(point - 0.2) > 0.11)
    seen = scan(0.0, [(point.real, point.imag)], width_m=0.04, half_rad=math.pi, rays=1440)
    if abs(bearing) < 1.2:
        assert judged(seen, -0.3, corners=corners).linear == -0.3
    elif abs(bearing) > 1.9:
        assert judged(seen, 0.3, corners=corners).linear == 0.3


def test_backwards_where_the_laser_does_not_see_it_crawls() -> None:
    blind = judged(scan(0.0), -0.4, 0.2)
    assert blind.linear == pytest.approx(-RULES.crawl_mps)
    assert blind.angular == pytest.approx(0.05)
    assert blind.reason == "slowed: the laser does not see behind"
    assert judged(scan(0.0, half_rad=math.pi), -0.4) == Verdict(-0.4, 0.0), "one that sees all around is not blind"
    turned = Pose3.from_translation_rpy((-0.2, 0.0, 0.4), (0.0, 0.0, math.pi))
    assert judged(scan(0.0, X_BL=turned), -0.4) == Verdict(-0.4, 0.0)
    assert judged(scan(0.0, X_BL=turned), 0.4).reason == "slowed: the laser does not see ahead"


@pytest.mark.parametrize(("velocity", "where"), [(0.3j, "to the left"), (-0.3j, "to the right"), (0.2 + 0.3j, "ahead")])
def test_sideways_where_the_laser_does_not_see_the_whole_body_pass_it_crawls(velocity: complex, where: str) -> None:
    blind = judged(scan(0.0), velocity)
    assert abs(blind.velocity) == pytest.approx(RULES.crawl_mps)
    assert cmath.phase(blind.velocity) == pytest.approx(cmath.phase(velocity))
    assert blind.reason == f"slowed: the laser does not see {where}"
    assert judged(scan(0.0, half_rad=math.radians(135)), velocity) == Verdict(velocity, 0.0)
    assert judged(scan(0.0), 0.4 + 0.2j) == Verdict(0.4 + 0.2j, 0.0), "it sees enough of both sides"


def test_a_thing_beside_the_body_stops_it_sideways_and_not_ahead() -> None:
    beside = scan(0.0, [(0.0, 0.32)], half_rad=math.pi)
    assert judged(beside, 0.4j, corners=BOX).velocity.imag <= RULES.crawl_mps
    assert judged(beside, 0.4j, corners=BOX).reason.endswith("to the left")
    assert judged(beside, 0.4, corners=BOX) == Verdict(0.4, 0.0)
    assert judged(beside, -0.4j, corners=BOX) == Verdict(-0.4j, 0.0)


def test_what_was_seen_is_judged_from_where_the_base_is_now() -> None:
    seen = wall(0.0, 1.0)
    assert judged(seen, 0.4) == Verdict(0.4, 0.0)
    assert judged(seen, 0.4, moved=Pose2(0.5)).linear == pytest.approx(judged(wall(0.0, 0.5), 0.4).linear, abs=1e-3)
    aside = scan(0.0, [(0.0 + 0.6, 0.0)])
    assert judged(aside, 0.4, moved=Pose2(theta=math.pi / 2)) == Verdict(0.4, 0.0), "it stands beside it now"


def test_a_single_ray_is_noise_and_two_are_a_thing() -> None:
    seen = scan(0.0)
    ranges = seen.ranges.copy()
    ranges[360] = 0.2
    one = LaserScan(0.0, "laser", ranges, ranges, seen.angle_min, seen.angle_increment, 0.1, 30.0, 0.0, seen.X_BL)
    assert judged(one, 0.4) == Verdict(0.4, 0.0)
    ranges[361] = 0.2
    assert judged(one, 0.4).linear < 0.1


def test_noise_makes_no_command_jerk_before_a_wall() -> None:
    just = next(gap for gap in np.arange(0.05, 0.3, 0.002) if judged(wall(0.0, 0.28 + gap), 0.4).linear > 0)
    assert judged(wall(0.0, 0.28 + just), 0.4).linear >= STANDING_MPS
    assert judged(wall(0.0, 0.28 + just), 0.4, standing=True).linear == 0.0
    assert judged(wall(0.0, 0.28 + just + 0.1), 0.4, standing=True).linear > 0.0


def test_without_a_scan_it_stops_and_says_so_once() -> None:
    monitor = CollisionMonitor(ROUND, LIMITS, RULES)
    assert monitor.blind(None) == Verdict(0.0, 0.0, "stopped: the laser has given no scan yet")
    for age_s in (0.52, 7.0):
        assert monitor.blind(age_s) == Verdict(0.0, 0.0, "stopped: the laser gives no new scans")


def test_the_override_crawls_on_the_commanded_arc() -> None:
    monitor = CollisionMonitor(ROUND, LIMITS, RULES)
    assert monitor.crawl(0.05, 0.1).linear == 0.05
    crawl = monitor.crawl(0.4, -0.2)
    assert (crawl.linear, crawl.angular) == pytest.approx((0.1, -0.05))
    assert monitor.crawl(0.0, 1.0).angular == pytest.approx(0.3)


@given(
    st.lists(st.tuples(st.floats(0.31, 1.2), st.floats(-1.0, 1.0)), max_size=6),
    st.sampled_from([-0.3, 0.1, 0.4, 0.3 + 0.2j, -0.4j, -0.1 + 0.3j]),
    st.sampled_from([-1.0, -0.2, 0.0, 0.5]),
    st.sampled_from([ROUND, BOX]),
)
def test_nothing_allowed_meets_anything_while_it_reacts_and_brakes(
    things: list[tuple[float, float]], velocity: complex, angular: float, corners: tuple[tuple[float, float], ...]
) -> None:
    seen = scan(0.0, things)
    monitor = CollisionMonitor(corners, HOLONOMIC, RULES)
    allowed = monitor.judge(monitor.see(seen), STILL, velocity, angular)
    assert abs(allowed.velocity) <= abs(velocity)
    assert abs(allowed.angular) <= abs(angular)
    if allowed.velocity == 0.0 and allowed.angular == 0.0:
        return
    braking_s = max(abs(allowed.velocity) / LIMITS.linear_mps2, abs(allowed.angular) / LIMITS.angular_radps2)
    points = monitor.see(seen).points
    tight = Polygon.of(corners)
    outside = tight.beyond(points)[0] > 1e-6
    times = np.sort(
        contact_times(points[outside], tight, allowed.velocity, allowed.angular, RULES.reaction_s + braking_s / 2)
    )
    assert np.count_nonzero(times < RULES.reaction_s + braking_s / 2 - 1e-6) < RULES.evidence
