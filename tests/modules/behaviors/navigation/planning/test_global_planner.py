from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from app.base.geometry import Pose2
from app.messages import Zone
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapWindow
from app.modules.behaviors.navigation.planning.global_planner import GlobalPlanner, PlanRequest
from tests.modules.behaviors.driven_world import box, mapped
from tests.modules.behaviors.navigation.scenes import SQUARE

SIZE = (0.0, 0.0, 8.0, 5.0)
#: Two rooms and two doors between them: one near, one further off.
WALLS = [*box(0.1, 0.1, 7.9, 4.9), (4.0, 0.1, 4.0, 0.8), (4.0, 1.8, 4.0, 3.6), (4.0, 4.6, 4.0, 4.9)]
NEAR_DOOR, FAR_DOOR = 1.3, 4.1
GRID = mapped(WALLS, SIZE)
#: The square body with an arm stretched to the left: together 1.1 m wide, and the doors are 1 m.
ASIDE = Footprint.stretched(np.array([*SQUARE[:2], (0.0, 0.85), *SQUARE[2:]]), sideways=False)


def global_planner() -> GlobalPlanner:
    return GlobalPlanner(Footprint.polygon(np.array(SQUARE)))


def request(**more: Any) -> PlanRequest:
    asked = PlanRequest(GRID, (), Pose2(), Pose2(1.0, 1.3, 0.0), Pose2(6.5, 1.3, math.nan))
    return replace(asked, **more)


def seen(obstacles: np.ndarray, X_OB: Pose2, stamp: float = 1.0) -> CostmapWindow:
    """Surroundings of 4 m in which ``obstacles`` (N, 2) stand."""
    cells = np.zeros((160, 160), dtype=np.int8)
    origin = (X_OB.x - 2.0, X_OB.y - 2.0)
    at = np.floor((obstacles - np.array(origin)) / 0.025).astype(int)
    inside = ((at >= 0) & (at < 160)).all(axis=1)
    cells[at[inside, 1], at[inside, 0]] = 100
    return CostmapWindow(
        stamp, origin, 0.025, cells, np.zeros((160, 160), dtype=np.float32), obstacles[inside], origin, 4.0
    )


def crosses_at(poses: np.ndarray) -> float:
    """At which y the way goes through the wall."""
    return float(np.interp(4.0, poses[:, 0], poses[:, 1]))


def test_a_plan_is_kept_while_it_is_good() -> None:
    finder = global_planner()
    first = finder.find(request(why="another goal"))
    assert first.changed
    assert abs(crosses_at(first.plan.poses) - NEAR_DOOR) < 0.4
    again = finder.find(request(X_MB=Pose2(1.5, 1.3, 0.0), kept=first.plan))
    assert not again.changed
    assert again.plan is first.plan


def test_what_shuts_a_door_makes_it_take_the_other_and_it_stays_with_that_when_it_opens() -> None:
    finder = global_planner()
    first = finder.find(request(why="another goal"))
    X_MB = Pose2(2.6, 1.3, 0.0)
    shut = np.stack((np.full(101, 4.0), np.linspace(0.8, 1.8, 101)), axis=1)
    around = finder.find(request(X_MB=X_MB, kept=first.plan, around=seen(shut, X_MB)))
    assert around.changed
    assert "blocked" in around.why
    assert abs(crosses_at(around.plan.poses) - FAR_DOOR) < 0.4
    # Out of sight it still counts for a while; seen free, the much shorter way is worth turning round for.
    away = Pose2(1.0, 4.0, 0.0)
    unseen = finder.find(request(X_MB=away, kept=around.plan, around=seen(np.empty((0, 2)), away, 2.0)))
    assert abs(crosses_at(unseen.plan.poses) - FAR_DOOR) < 0.4
    opened = finder.find(request(X_MB=X_MB, kept=around.plan, around=seen(np.empty((0, 2)), X_MB, 3.0)))
    assert opened.changed
    assert opened.why == "a better way was found"
    assert abs(crosses_at(opened.plan.poses) - NEAR_DOOR) < 0.4


def test_opened_up_it_forgets_what_was_in_the_way() -> None:
    finder = global_planner()
    X_MB = Pose2(2.6, 1.3, 0.0)
    shut = np.stack((np.full(101, 4.0), np.linspace(0.8, 1.8, 101)), axis=1)
    finder.find(request(X_MB=X_MB, around=seen(shut, X_MB)))
    away = Pose2(1.0, 4.0, 0.0)
    opened = finder.find(request(X_MB=away, around=seen(np.empty((0, 2)), away, 2.0), opened_up=True, why="stuck"))
    assert opened.changed
    assert finder.find(request(X_MB=X_MB, why="another goal")).plan.code == "way"
    assert abs(crosses_at(finder.find(request(X_MB=X_MB, why="another goal")).plan.poses) - NEAR_DOOR) < 0.4


def test_a_goal_where_something_stands_that_the_map_does_not_have_is_taken_until_it_goes() -> None:
    finder = global_planner()
    X_MB = Pose2(5.2, 1.3, 0.0)
    person = np.array([[6.5, 1.3], [6.5, 1.35], [6.55, 1.3]])
    taken = finder.find(request(X_MB=X_MB, around=seen(person, X_MB), why="another goal")).plan
    assert taken.code == "taken"
    assert taken.target is not None
    beside_m = np.hypot(*(person - np.array([taken.target.x, taken.target.y])).T).min()
    assert math.hypot(*SQUARE[0]) < beside_m < 0.7, "there it can turn, and watch the goal"
    aside = finder.find(request(X_MB=X_MB, kept=taken, around=seen(person + np.array([0.15, 0.0]), X_MB, 2.0)))
    assert (aside.plan.code, aside.why) == ("taken", "a place nearer to the goal can be reached now")
    free = finder.find(request(X_MB=X_MB, kept=taken, around=seen(np.empty((0, 2)), X_MB, 3.0)))
    assert (free.plan.code, free.why) == ("way", "the goal itself can be reached now")
    beside = seen(person + np.array([0.2, 0.0]), X_MB)
    near = finder.find(request(X_MB=X_MB, around=beside, tolerance_m=0.25, why="another goal")).plan
    assert near.code == "near", "so near will do"
    kept_with_map = finder.find(request(persistent_obstacles=person, why="another goal")).plan
    assert kept_with_map.code == "near", "what is kept with the map stays there"


def test_zones_are_kept_out_of_and_say_how_fast() -> None:
    finder = global_planner()
    door = np.array([[3.5, 0.5], [4.5, 0.5], [4.5, 2.0], [3.5, 2.0]])
    barred = finder.find(request(zones=(Zone("door", "keep_out", door, 1.0),), why="another goal"))
    assert abs(crosses_at(barred.plan.poses) - FAR_DOOR) < 0.4
    slow = finder.find(request(zones=(Zone("door", "slow", door, 0.3),), why="zones changed"))
    shares = slow.speed_share(np.array([[1.0, 1.0], [4.0, 1.0], [99.0, 99.0]]))
    assert shares.tolist() == [1.0, np.float32(0.3), 1.0]


def test_without_a_way_it_says_why_and_keeps_saying_it_once() -> None:
    finder = global_planner()
    walled = mapped([*WALLS, (4.0, 0.1, 4.0, 4.9)], SIZE, version=2)
    none = finder.find(request(grid=walled, why="another goal"))
    assert none.plan.poses.shape == (0, 3)
    assert none.plan.reason
    assert not finder.find(request(grid=walled, kept=none.plan, why=none.plan.reason)).changed


def test_what_is_remembered_far_away_is_planned_around_until_nothing_else_leads_there() -> None:
    finder = global_planner()
    shut = np.stack((np.full(20, 4.0), np.linspace(0.85, 1.75, 20)), axis=-1)  # a low box in the near door
    around = finder.find(request(persistent_obstacles=shut, why="another goal"))
    assert abs(crosses_at(around.plan.poses) - FAR_DOOR) < 0.4
    through = finder.find(request(persistent_obstacles=shut, why="after trying", opened_up=True))
    assert abs(crosses_at(through.plan.poses) - NEAR_DOOR) < 0.4
    walls = np.stack((np.full(20, 0.12), np.linspace(1.0, 2.0, 20)), axis=-1)
    assert finder.find(request(persistent_obstacles=walls, why="another goal")).plan.code == "way", (
        "on a wall it is the wall"
    )


def test_with_an_arm_stretched_to_the_side_it_takes_the_wider_door() -> None:
    walls = [*box(0.1, 0.1, 7.9, 4.9), (4.0, 0.1, 4.0, 0.8), (4.0, 1.8, 4.0, 3.3), (4.0, 4.8, 4.0, 4.9)]
    asked = request(grid=mapped(walls, SIZE), why="another goal")
    planner = global_planner()
    assert abs(crosses_at(planner.find(asked).plan.poses) - 1.3) < 0.4
    aside = planner.find(replace(asked, footprint=ASIDE))
    assert aside.plan.code == "way"
    assert abs(crosses_at(aside.plan.poses) - 4.05) < 0.3
    again = planner.find(replace(asked, kept=aside.plan))
    assert abs(crosses_at(again.plan.poses) - 1.3) < 0.4, "at rest it goes through the nearer one again"


def test_where_only_the_arm_is_in_the_way_the_reason_is_the_arm() -> None:
    planner = global_planner()
    asked = request(why="another goal", footprint=ASIDE)
    found = planner.find(asked).plan
    assert (found.code, len(found.poses)) == ("arms", 0)
    assert found.reason == "the arms are stretched out too far; with them at rest there is a way"
    walled = planner.find(replace(asked, grid=mapped([*WALLS, (4.0, 0.1, 4.0, 4.9)], SIZE))).plan
    assert walled.code == "walled_off"


def test_a_place_that_only_the_arm_cannot_go_to_is_said_to_be_so() -> None:
    found = global_planner().find(request(goal=Pose2(2.0, 0.5, math.nan), footprint=ASIDE)).plan
    assert found.code == "near"
    assert "nearer to an obstacle of the map than the stretched arms reach" in found.reason
