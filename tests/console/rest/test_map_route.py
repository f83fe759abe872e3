"""Routes over REST: leg by leg, by places and coordinates, by the planner of the robot that drives."""

from __future__ import annotations

import asyncio
import math

import httpx
import numpy as np
import pytest

from app.console.records.route import RouteReport
from app.console.rest.map_route import MOST_CORNERS, MOST_WAITING, corners
from app.maps.map_service import MapUnavailable
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.places import FakeMapServer, StraightPlanner


@pytest.fixture
async def planner(system: System) -> StraightPlanner:
    system.map.attach(FakeMapServer(system.maps))
    await system.map.resume("", same=False)
    planner = StraightPlanner()
    system.routes.attach(planner)
    return planner


async def test_a_route_is_planned_leg_by_leg_between_places_and_poses(
    client: httpx.AsyncClient, planner: StraightPlanner
) -> None:
    await client.post("/places", json={"name": "Dock", "pose": {"x": 3, "y": 4, "heading": 1.5}})
    points = [{"x": 0, "y": 0}, {"place": "dock"}, {"x": -5, "y": 4}, {"x": 3, "y": 5, "heading": 0.5}]
    answer = await client.post("/map/route", json={"points": points, "speed": 0.5})
    route = answered(answer, RouteReport)
    assert route.map == ""
    assert [leg.state for leg in route.legs] == ["way", "none", "way"]
    first, shut, last = route.legs
    assert (first.length_m, first.duration_s, first.path) == (5, 10, ((0, 0), (3, 4)))
    assert (shut.reason, shut.path) == ("obstacles on the map wall the goal off", ())
    assert route.length_m == pytest.approx(first.length_m + last.length_m)
    assert route.duration_s == pytest.approx(first.duration_s + last.duration_s, abs=0.11)
    # A place is left with its heading, a point without one in the direction of the next.
    (start, dock, speed), (left, point, _), (_, goal, _) = planner.asked
    assert (start.theta, speed) == (pytest.approx(math.atan2(4, 3)), 0.5)
    assert (dock.theta, left.theta, goal.theta) == (1.5, 1.5, 0.5)
    assert math.isnan(point.theta)


async def test_what_cannot_be_planned_is_refused_in_words(
    client: httpx.AsyncClient, planner: StraightPlanner, system: System
) -> None:
    start = {"x": 0, "y": 0}
    strange = is_problem(
        await client.post("/map/route", json={"points": [start, {"place": "cellar"}]}), 422, "no-such-place"
    )
    assert strange["errors"][0]["field"] == "points.1.place"
    for point in ({}, {"x": 1}, {"place": "dock", "x": 1, "y": 2}):
        wrong = is_problem(await client.post("/map/route", json={"points": [start, point]}), 422, "invalid-request")
        assert "either place is needed, or x and y" in wrong["detail"]
    is_problem(await client.post("/map/route", json={"points": [start]}), 422, "invalid-request")
    is_problem(await client.post("/map/route", json={"points": [start] * 103}), 422, "invalid-request")
    planner.lack = MapUnavailable("there is no map yet")
    is_problem(await client.post("/map/route", json={"points": [start, start]}), 409, "map-unavailable")
    system.routes.attach(planner)()
    without = is_problem(await client.post("/map/route", json={"points": [start, start]}), 409, "map-unavailable")
    assert "plans no ways" in without["detail"]
    assert planner.asked[1:] == []


async def test_one_route_is_planned_after_another_and_too_many_are_refused(
    client: httpx.AsyncClient, planner: StraightPlanner
) -> None:
    planner.may_answer.clear()
    body = {"points": [{"x": 0, "y": 0}, {"x": 1, "y": 0}]}
    asked = [asyncio.ensure_future(client.post("/map/route", json=body)) for _ in range(MOST_WAITING + 1)]
    done, _ = await asyncio.wait(asked, return_when=asyncio.FIRST_COMPLETED)
    (refused,) = done
    is_problem(refused.result(), 409, "busy")
    assert len(planner.asked) == 1
    planner.may_answer.set()
    assert sorted(answer.status_code for answer in await asyncio.gather(*asked)) == [200] * MOST_WAITING + [409]


def test_a_path_is_sent_by_its_corners() -> None:
    x = np.linspace(0.0, 1.0, 21)
    bend = np.concatenate((np.stack((x, 0 * x), axis=1), np.stack((0 * x + 1.0, x), axis=1)[1:]))
    assert corners(bend) == ((0, 0), (1, 0), (1, 1))
    assert corners(bend[:1]) == ((0, 0),)
    assert corners(np.empty((0, 2))) == ()
    zigzag = np.stack((np.arange(2000.0), np.arange(2000) % 2 * 1.0), axis=1)
    sent = corners(zigzag + 10_000)
    assert len(sent) <= MOST_CORNERS
    assert sent[0] == (10_000, 10_000)
    assert sent[-1] == (11_999, 10_001)
