from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.messages import OccupancyGrid, Zone
from app.modules.behaviors.navigation.costmap.footprint import Footprint, clearances
from app.modules.behaviors.navigation.costmap.inflation import CostField, CostSettings, cost_field, with_obstacles
from app.modules.behaviors.navigation.planning.goal_planning import (
    GlobalPlan,
    PlanSettings,
    check_path,
    plan,
    why_replan,
)
from tests.modules.behaviors.navigation.maps import (
    OBLONG,
    ROUND,
    box,
    cost_along,
    free_place,
    grid_of,
    lethal_along,
    office,
    random_cells,
    zone,
)

#: Places of the office: upper left room, corridor, upper middle room, lower left room, the store.
UPPER_LEFT, CORRIDOR, MIDDLE, LOWER, STORE = (
    Pose2(0.6, 7.3, math.nan),
    Pose2(13.0, 4.2, 0.0),
    Pose2(8.2, 7.3, math.nan),
    Pose2(0.6, 0.6, math.nan),
    Pose2(13.0, 6.5, math.nan),
)


def field(zones: tuple[Zone, ...] = (), body: Footprint = ROUND, costs: CostSettings | None = None) -> CostField:
    return cost_field(office(), body, zones, costs)


def through(found: GlobalPlan, x: float, y: float, within_m: float = 0.6) -> bool:
    return bool((np.hypot(found.poses[:, 0] - x, found.poses[:, 1] - y) < within_m).any())


def check_way(field: CostField, found: GlobalPlan, start: Pose2, target: Pose2) -> None:
    assert tuple(found.poses[0, :2]) == pytest.approx((start.x, start.y))
    assert tuple(found.poses[-1, :2]) == pytest.approx((target.x, target.y))
    assert lethal_along(field, found.poses) == 0
    assert found.length_m >= math.dist((start.x, start.y), (target.x, target.y)) - 1e-6
    assert found.length_m == pytest.approx(np.hypot(*np.diff(found.poses[:, :2], axis=0).T).sum())


def test_from_room_to_room_through_the_doors() -> None:
    costs = field()
    found = plan(costs, CORRIDOR, UPPER_LEFT)
    assert (found.code, found.reason) == ("way", "")
    check_way(costs, found, CORRIDOR, UPPER_LEFT)
    assert through(found, 1.6, 5.4), "the room's door is there"
    assert found.length_m < 15.5
    assert math.isnan(found.target.theta if found.target else 0.0)


def test_the_goals_heading_is_the_last_poses() -> None:
    found = plan(field(), UPPER_LEFT, Pose2(13.0, 4.2, 2.5))
    assert found.poses[-1, 2] == 2.5
    assert found.target == Pose2(13.0, 4.2, 2.5)


def test_ways_keep_to_the_middle_of_the_corridor() -> None:
    found = plan(field(), Pose2(2.0, 4.3, 0.0), Pose2(12.0, 4.3, 0.0))
    middle = found.poses[(found.poses[:, 0] > 4.0) & (found.poses[:, 0] < 10.0)]
    assert (np.abs(middle[:, 1] - 4.35) < 0.3).all()


def test_a_goal_under_the_table_is_replaced_by_the_nearest_place_and_said() -> None:
    costs = field()
    goal = Pose2(9.6, 6.9, 1.0)
    found = plan(costs, CORRIDOR, goal)
    assert found.code == "near"
    assert found.target is not None
    check_way(costs, found, CORRIDOR, found.target)
    away = math.dist((found.target.x, found.target.y), (goal.x, goal.y))
    assert away <= 1.0
    assert found.reason == (
        f"the goal lies on an obstacle of the map: goes to the nearest place that can be reached, {away:.2f} m from it"
    )
    rows, columns = np.nonzero(np.isfinite(costs.cost))
    free = np.hypot((columns + 0.5) * 0.05 - goal.x, (rows + 0.5) * 0.05 - goal.y)
    assert away <= free.min() + 0.05, "nowhere is nearer"


def test_a_goal_beside_the_wall_is_nearer_than_the_body_is_wide() -> None:
    found = plan(field(), CORRIDOR, Pose2(9.9, 5.15, 0.0))
    assert found.code == "near"
    assert found.reason.startswith("the goal is nearer to an obstacle of the map than the body is wide: goes to")


def test_a_goal_deep_in_an_obstacle_is_not_gone_near_to() -> None:
    cells = np.zeros((200, 200), dtype=np.int8)
    cells[50:150, 50:150] = 100
    found = plan(cost_field(grid_of(cells), ROUND), Pose2(1.0, 1.0, 0.0), Pose2(5.0, 5.0, 0.0))
    assert found.code == "obstacle"
    assert found.reason == "the goal lies on an obstacle of the map, and no place within 1 m of it can be reached"
    assert found.poses.shape == (0, 3)


def test_off_the_map() -> None:
    assert plan(field(), CORRIDOR, Pose2(40.0, 4.0, 0.0)).reason == (
        "the goal is off the map, which covers x 0.0 to 15.0 and y 0.0 to 8.0 m"
    )
    assert plan(field(), CORRIDOR, Pose2(40.0, 4.0, 0.0)).code == "outside"
    assert plan(field(), Pose2(-3.0, 4.0, 0.0), CORRIDOR).code == "start_outside"


def test_the_store_has_no_door() -> None:
    found = plan(field(), CORRIDOR, STORE)
    assert (found.code, found.reason) == ("walled_off", "obstacles on the map wall the goal off")


def test_zones_wall_off_too_and_are_named() -> None:
    door = zone("keep_out", box(0.5, 5.2, 2.6, 5.6), name="Wet floor")
    elsewhere = zone("keep_out", box(8.5, 2.0, 9.5, 2.4), name="Cables")
    found = plan(field((door, elsewhere)), CORRIDOR, UPPER_LEFT)
    assert found.code == "keep_out"
    assert found.reason == "zones that the robot keeps out of are in the way: “Wet floor”"
    assert plan(field((door, elsewhere)), CORRIDOR, STORE).code == "walled_off"


def test_a_goal_in_a_zone_is_replaced_by_a_place_beside_it() -> None:
    stairs = zone("keep_out", box(6.0, 3.6, 7.0, 4.4), name="Stairs")
    found = plan(field((stairs,)), CORRIDOR, Pose2(6.6, 4.1, 0.0))
    assert found.code == "near"
    assert found.reason.startswith("the goal lies in the zone “Stairs”, which the robot keeps out of: goes to")


def test_slow_zones_are_gone_around_if_that_is_quicker() -> None:
    free = cost_field(grid_of(np.zeros((120, 240), dtype=np.int8)), ROUND)
    begin, end = Pose2(1.0, 3.0, 0.0), Pose2(11.0, 3.0, 0.0)
    assert not through(plan(free, begin, end), 6.0, 5.0, 1.4)
    slow = cost_field(free_grid(), ROUND, (zone("slow", box(5.0, 0.0, 7.0, 4.5), 0.2),))
    assert through(plan(slow, begin, end), 6.0, 5.0, 1.0)
    hardly = cost_field(free_grid(), ROUND, (zone("slow", box(5.0, 0.0, 7.0, 4.5), 0.9),))
    assert plan(hardly, begin, end).length_m == pytest.approx(10.0, abs=0.05)


def free_grid() -> OccupancyGrid:
    return grid_of(np.zeros((120, 240), dtype=np.int8))


def test_something_in_the_only_way() -> None:
    costs = field()
    door = np.stack(np.meshgrid(np.arange(0.9, 2.4, 0.05), [5.4]), axis=-1).reshape(-1, 2)
    found = plan(with_obstacles(costs, door), CORRIDOR, UPPER_LEFT)
    assert found.code == "in_the_way"
    assert found.reason.startswith("something that is not on the map stands in the only way, near x ")
    assert plan(with_obstacles(costs, door), CORRIDOR, MIDDLE).code == "way"


def test_something_in_the_way_is_gone_around_where_that_can_be_done() -> None:
    costs = field()
    person = np.array([[6.5, 4.3], [6.5, 4.45], [6.6, 4.35]])
    found = plan(with_obstacles(costs, person), Pose2(3.0, 4.3, 0.0), Pose2(11.0, 4.3, 0.0))
    assert found.code == "way"
    assert np.hypot(found.poses[:, 0] - 6.5, found.poses[:, 1] - 4.35).min() > ROUND.inscribed_m


@pytest.mark.parametrize(
    ("unknown", "code"), [("free", "way"), ("costly", "way"), ("blocked", "unknown")], ids=["free", "costly", "blocked"]
)
def test_through_unknown_space_by_policy(unknown: str, code: str) -> None:
    cells = np.zeros((80, 200), dtype=np.int8)
    cells[:, 90:110] = -1
    found = plan(
        cost_field(grid_of(cells), ROUND, settings=CostSettings(unknown=unknown)), Pose2(2, 2, 0), Pose2(8, 2, 0)
    )
    assert found.code == code
    if code == "unknown":
        assert found.reason == "only unknown space leads to the goal, and the robot may not go there"


def test_unknown_space_is_the_last_resort() -> None:
    cells = np.zeros((200, 200), dtype=np.int8)
    cells[:160, 90:96] = -1
    begin, end = Pose2(2.0, 2.0, 0.0), Pose2(8.0, 2.0, 0.0)
    around = plan(cost_field(grid_of(cells), ROUND, settings=CostSettings(unknown_cost=100.0)), begin, end)
    assert around.poses[:, 1].max() > 7.5
    straight = plan(cost_field(grid_of(cells), ROUND, settings=CostSettings(unknown="free")), begin, end)
    assert straight.length_m == pytest.approx(6.0, abs=0.02)


def test_a_start_against_the_wall_gets_free_first_and_never_through_the_wall() -> None:
    costs = field()
    # In the lower left room, at the wall to the corridor, which is nearer on the other side
    start = Pose2(2.0, 3.15, 0.0)
    found = plan(costs, start, LOWER)
    assert found.code == "way"
    assert found.reason == "first gets free: it is nearer to an obstacle of the map than the body is wide"
    assert found.poses[:, 1].max() < 3.2
    assert tuple(found.poses[0, :2]) == (2.0, 3.15)
    beyond = plan(costs, Pose2(2.0, 3.2, 0.0), Pose2(2.0, 4.3, 0.0))
    assert beyond.length_m > 3.0, "it leads through the door"


def test_a_start_that_cannot_get_free_says_so() -> None:
    cells = np.full((60, 60), 100, dtype=np.int8)
    cells[28:33, 28:33] = 0
    cells[:, :5] = 0
    found = plan(cost_field(grid_of(cells), ROUND), Pose2(1.52, 1.52, 0.0), Pose2(0.1, 1.0, 0.0))
    assert found.code == "start_stuck"
    assert found.reason == ("the robot cannot get free: it is nearer to an obstacle of the map than the body is wide")


def test_a_robot_in_a_new_zone_leaves_it() -> None:
    here = zone("keep_out", box(3.0, 3.5, 9.0, 5.2), name="Cleaning")
    found = plan(field((here,)), Pose2(6.0, 4.3, 0.0), CORRIDOR)
    assert found.code == "way"
    assert found.reason == "first gets free: it lies in the zone “Cleaning”, which the robot keeps out of"


def test_an_oblong_body_does_not_stand_across_a_narrow_place() -> None:
    cells = np.zeros((100, 200), dtype=np.int8)
    cells[:45, 80:120] = 100
    cells[55:, 80:120] = 100
    costs = cost_field(grid_of(cells), OBLONG, settings=CostSettings(reach_m=0.2))
    along = plan(costs, Pose2(1.0, 2.5, 0.0), Pose2(5.0, 2.5, 0.0))
    assert along.code == "way"
    across = plan(costs, Pose2(1.0, 2.5, 0.0), Pose2(5.0, 2.5, math.pi / 2))
    assert across.code in ("near", "obstacle")
    assert across.reason.startswith("the goal leaves no room to stand with the heading that was asked for")


def test_at_the_goal_already() -> None:
    found = plan(field(), CORRIDOR, CORRIDOR)
    assert found.code == "way"
    assert found.length_m == pytest.approx(0.0)
    assert len(found.poses) >= 1


@settings(max_examples=60)
@given(st.integers(0, 100_000), st.booleans())
def test_any_two_free_places(seed: int, oblong: bool) -> None:
    body = OBLONG if oblong else ROUND
    costs = cost_field(grid_of(random_cells(seed, 120, 140)), body)
    rng = np.random.default_rng(seed)
    start, goal = (free_place(costs, lambda n: int(rng.integers(n))) for _ in range(2))
    if start is None or goal is None:
        return
    found = plan(costs, start, goal)
    assert found.code in ("way", "walled_off")
    if found.code == "way":
        check_way(costs, found, start, goal)
        assert cost_along(costs, found.poses) >= found.length_m - 1e-3
        frame = costs.frame
        near = clearances(costs.clearance, (frame.x, frame.y), frame.resolution_m, body, found.poses)
        assert (near > -0.1).all()


@settings(max_examples=40)
@given(st.integers(0, 100_000), st.floats(0, 7), st.floats(0, 6))
def test_any_goal_at_all_gets_an_answer(seed: int, x: float, y: float) -> None:
    rng = np.random.default_rng(seed)
    zones = (zone("keep_out", box(2.0, 1.0, 2.5, 4.0)),) if seed % 3 == 0 else ()
    known = cost_field(grid_of(random_cells(seed, 120, 140)), ROUND, zones)
    costs = with_obstacles(known, rng.uniform(0, 6, (seed % 4, 2)))
    found = plan(costs, Pose2(rng.uniform(0.1, 5.9), rng.uniform(0.1, 5.9), 0.0), Pose2(x, y, math.nan))
    assert (len(found.poses) > 0) == (found.code in ("way", "near"))
    if found.code != "way":
        assert found.reason
    if found.code == "near":
        assert found.target is not None
        assert math.dist((found.target.x, found.target.y), (x, y)) <= 1.0


def test_what_is_left_of_a_path() -> None:
    costs = field()
    found = plan(costs, Pose2(2.0, 4.3, 0.0), Pose2(12.0, 4.3, 0.0))
    check = check_path(costs, found.poses, Pose2(5.0, 4.7, 0.0))
    assert check.blocked_m is None
    assert check.remaining_m == pytest.approx(7.0, abs=0.15)
    assert check.off_m == pytest.approx(0.4, abs=0.15)
    assert why_replan(check) == ""
    assert why_replan(check_path(costs, found.poses, Pose2(5.0, 5.1, 0.0))) == "the robot is 0.7 m off its way"


def test_a_path_is_replanned_for_what_came_into_it_ahead_not_behind() -> None:
    costs = field()
    found = plan(costs, Pose2(2.0, 4.3, 0.0), Pose2(12.0, 4.3, 0.0))
    place = found.poses[len(found.poses) // 2, :2]
    live = with_obstacles(costs, place[None])
    check = check_path(live, found.poses, Pose2(3.0, 4.3, 0.0))
    assert check.blocked_m == pytest.approx(place[0] - 3.0 - ROUND.inscribed_m, abs=0.15)
    assert why_replan(check) == f"the way is blocked {check.blocked_m:.1f} m ahead"
    assert check_path(live, found.poses, Pose2(place[0] + 1.0, 4.3, 0.0)).blocked_m is None
    shut = field((zone("keep_out", box(8.0, 3.4, 9.0, 5.3)),))
    assert check_path(shut, found.poses, Pose2(3.0, 4.3, 0.0)).blocked_m is not None


def test_a_path_that_comes_by_twice_is_looked_at_where_the_robot_is_on_it() -> None:
    x = np.concatenate((np.linspace(2, 12, 101), np.linspace(12, 2, 101)))
    y = np.repeat([4.2, 4.4], 101)
    poses = np.stack((x, y, np.zeros_like(x)), axis=-1)
    here = Pose2(4.0, 4.35, 0.0)
    assert check_path(field(), poses, here).remaining_m < 3.0
    assert check_path(field(), poses, here, from_index=10, within_m=2.0).remaining_m > 15.0


def test_settings_say_how_far_is_near() -> None:
    goal = Pose2(9.6, 6.9, 0.0)
    assert plan(field(), CORRIDOR, goal, PlanSettings(near_m=0.2)).code == "obstacle"
