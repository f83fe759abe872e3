"""People who follow the robot: on its way, behind it, later than it, out of its line when it comes back."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.messages import PersonTruth
from app.robots.simulated.scenery.following import draw_habits
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.scenery.scenario_state import ScenarioState

#: How fast the robot drives (m/s), and how often it is looked at (s).
SPEED, LOOK_S = 0.4, 0.05
Way = Callable[[float], Pose2]


def scene(*scripts: list[dict[str, object]], seed: int = 1, at: tuple[float, float] = (-1.5, 0.0)) -> ScenarioState:
    people = [
        {"name": f"visitor {n}", "face": "pilot", "at": (at[0] - 1.2 * n, at[1]), "script": script, "repeat": False}
        for n, script in enumerate(scripts)
    ]
    return ScenarioState(ScenarioConfig.model_validate({"name": "visitors", "seed": seed, "people": people}))


def along(*corners: tuple[float, float], pause_s: float = 0.0) -> Way:
    """The way through ``corners``, with a pause at its end."""

    def pose(time_s: float) -> Pose2:
        left = min(max(time_s - pause_s, 0.0) * SPEED, 1e9)
        for a, b in itertools.pairwise(corners):
            length, heading = math.dist(a, b), math.atan2(b[1] - a[1], b[0] - a[0])
            if left <= length or b is corners[-1]:
                left = min(left, length)
                return Pose2(a[0] + left * math.cos(heading), a[1] + left * math.sin(heading), heading)
            left -= length
        raise AssertionError("a way has two corners at least")

    return pose


def played(state: ScenarioState, way: Way, seconds: float) -> Iterator[tuple[float, Pose2, tuple[PersonTruth, ...]]]:
    for look in range(1, round(seconds / LOOK_S) + 1):
        time_s = look * LOOK_S
        X_WB = way(time_s)
        state.advance(time_s, X_WB)
        yield time_s, X_WB, state.people


def apart(X_WB: Pose2, person: PersonTruth) -> float:
    return math.hypot(person.x - X_WB.x, person.y - X_WB.y)


@pytest.mark.parametrize("distance", [1.3, 2.0, 3.0])
def test_they_come_along_so_far_behind_and_stop_where_it_stops(distance: float) -> None:
    state = scene([{"follow": 100, "distance": distance, "lag": 0.5, "speed": 1.2}], at=(-1.0, 0.0))
    ways = list(played(state, along((0.0, 0.0), (8.0, 0.0)), 30.0))
    driving = [apart(X_WB, people[0]) for time_s, X_WB, people in ways if 10.0 < time_s < 19.0]
    assert distance - 0.1 < min(driving)
    assert max(driving) < distance + 0.8
    (_, X_WB, people), before = ways[-1], ways[-20][2][0]
    assert apart(X_WB, people[0]) == pytest.approx(distance, abs=0.2)
    assert (before.x, before.y) == (people[0].x, people[0].y)


def test_a_lag_is_how_much_later_they_set_off() -> None:
    def sets_off(lag: float) -> float:
        state = scene([{"follow": 100, "distance": 1.0, "lag": lag}], at=(-0.8, 0.0))
        return next(t for t, _, people in played(state, along((0.0, 0.0), (8.0, 0.0)), 40.0) if people[0].x > -0.79)

    assert sets_off(6.0) - sets_off(1.0) == pytest.approx(5.0, abs=0.15)


def test_they_go_round_corners_as_the_robot_did() -> None:
    corner = (4.0, 0.0)
    state = scene([{"follow": 100, "distance": 2.0, "lag": 1.0}])
    places = [(p[0].x, p[0].y) for _, _, p in played(state, along((0.0, 0.0), corner, (4.0, 6.0)), 40.0)]
    assert places[-1] == pytest.approx((4.0, 4.0), abs=0.4)
    assert min(math.dist(place, corner) for place in places) < 0.45
    assert all(y < 0.15 or x > 3.4 for x, y in places)


def test_nobody_follows_into_a_dead_end_that_the_robot_comes_back_from() -> None:
    state = scene([{"follow": 200, "distance": 1.5, "lag": 1.0}], at=(-1.2, 0.0))
    ways = list(played(state, along((0.0, 0.0), (4.0, 0.0), (-4.0, 0.0)), 50.0))
    assert min(apart(X_WB, people[0]) for _, X_WB, people in ways) > 0.75
    # It drives past, and they come after it, the other way.
    assert ways[-1][1].x == pytest.approx(-4.0)
    assert ways[-1][2][0].x < -1.9
    assert apart(ways[-1][1], ways[-1][2][0]) < 2.2


def test_a_visitor_may_wander_off_and_another_stays_in_line() -> None:
    leaves: list[dict[str, object]] = [{"follow": 8}, {"walk": (-1.0, 5.0)}]
    state = scene([{"follow": 100, "distance": 1.5}], leaves)
    ways = list(played(state, along((0.0, 0.0), (6.0, 0.0)), 25.0))
    assert min(math.dist((a.x, a.y), (b.x, b.y)) for _, _, (a, b) in ways) > 0.4
    _, X_WB, people = ways[-1]
    assert (people[1].x, people[1].y) == pytest.approx((-1.0, 5.0), abs=0.01)
    assert apart(X_WB, people[0]) < 2.0


def test_they_turn_to_the_robot_where_the_script_says_so() -> None:
    state = scene([{"follow": 100, "distance": 1.5, "look": "robot"}], at=(-1.2, 0.3))
    *_, (_, X_WB, people) = played(state, along((0.0, 0.0), (3.0, 0.0)), 20.0)
    towards = math.atan2(X_WB.y - people[0].y, X_WB.x - people[0].x)
    assert math.cos(people[0].heading - towards) > 0.99


def test_habits_are_their_own_and_the_seeds() -> None:
    def places(seed: int) -> list[tuple[float, float]]:
        state = scene([{"follow": 100}], [{"follow": 100}], seed=seed)
        *_, (_, _, people) = played(state, along((0.0, 0.0), (6.0, 0.0)), 12.0)
        return [(person.x, person.y) for person in people]

    assert places(1) == places(1)
    assert places(1) != places(2)
    habits = draw_habits(np.random.default_rng(1), 50)
    assert all(1.2 <= habit.distance_m <= 2.2 and 0.5 <= habit.lag_s <= 1.5 for habit in habits)
    assert len({habit.distance_m for habit in habits}) == 50


def test_who_is_asked_to_let_it_pass_goes_on_along_its_way_until_behind_it() -> None:
    state = scene([{"follow": 100, "distance": 1.6, "lag": 1}])
    back = along((0, 0), (3, 0), (2.2, 0.8))
    *_, (time_s, X_WB, (person,)) = played(state, back, 20)
    stood = (person.x, person.y)
    assert math.dist(stood, (1.4, 0)) < 0.2, "near enough to the robot, which is stuck beside them"
    state.let_pass()
    for _ in range(round(8 / LOOK_S)):
        time_s += LOOK_S
        state.advance(time_s, X_WB)
    (person,) = state.people
    assert math.dist((person.x, person.y), (2.5, 0)) < 0.3, "the way between is as long as they keep"


def test_who_is_asked_and_stands_in_its_line_steps_aside() -> None:
    state = scene([{"follow": 100, "distance": 1.3, "lag": 1}], at=(-1.0, 0.0))
    *_, (time_s, X_WB, _) = played(state, along((0, 0), (0.2, 0)), 5)
    facing = Pose2(X_WB.x, X_WB.y, math.pi)
    for look in range(round(20 / LOOK_S)):
        time_s += LOOK_S
        state.advance(time_s, facing)
        if look == round(5 / LOOK_S):
            (person,) = state.people
            assert abs(person.y) < 0.1
            state.let_pass()
    (person,) = state.people
    assert abs(person.y) > 0.85


def test_who_pauses_goes_on_along_the_way_and_not_through_the_corner() -> None:
    script: list[dict[str, object]] = [{"follow": 6, "distance": 1.3}, {"wait": 20}, {"follow": 100, "distance": 1.3}]
    state = scene(script, at=(-1.3, 0.0))
    seen = [(person.x, person.y) for *_, (person,) in played(state, along((0, 0), (4, 0), (4, 4)), 60)]
    assert math.dist(seen[-1], (4, 2.7)) < 0.3, "they have caught up"
    assert min(math.dist(place, (4, 0)) for place in seen) < 0.6, "round the corner"
