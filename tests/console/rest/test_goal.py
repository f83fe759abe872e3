"""The goal over REST: one of people's at a time, a desire like any other."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from typing import Any

import httpx
import msgspec
import pytest

from app.attention.desires import Desire, Source
from app.console.live.hub import Hub
from app.console.records.navigation import GivenUpModel, GoalPoseModel, NavigationModel
from app.maps.map_service import Files, MapUnavailable
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.places import FakeMapServer, path, status
from tests.console.program import Body
from tests.patience import PATIENCE_S

ANN = {"X-HBBA-Operator": "Ann"}


def goals(system: System) -> list[tuple[str, float]]:
    """Who wants to go where."""
    return [(d.source.name, d.params["x"]) for d in system.workspace.desires() if d.cls == "GoTo"]


async def goal_now(client: httpx.AsyncClient) -> tuple[Desire | None, NavigationModel]:
    """What is desired, and what became of it."""
    answer = (await client.get("/goal")).json()
    desire = None if answer["desire"] is None else msgspec.convert(answer["desire"], Desire)
    return desire, NavigationModel.model_validate(answer["navigation"], extra="forbid")


async def test_a_goal_is_a_desire_and_a_second_one_replaces_it(client: httpx.AsyncClient, system: System) -> None:
    answer = await client.put("/goal", json={"x": 2, "y": 1.5, "heading": 4.0, "speed": 0.5}, headers=ANN)
    assert answer.status_code == 200, answer.text
    desire = answered(answer, Desire)
    assert (desire.cls, desire.intensity, desire.utility) == ("GoTo", 8, 4)
    assert (desire.source.kind, desire.source.name) == ("operator", "Ann")
    assert desire.params["heading"] == pytest.approx(4.0 - math.tau)
    assert (desire.params["x"], desire.params["y"], desire.params["speed"]) == (2, 1.5, 0.5)
    await system.translator.settled()
    assert system.translator.current is not None
    assert "go" in system.translator.current.selection.strategies

    second = (await client.put("/goal", json={"x": 0, "y": 0, "heading": 0}, headers=ANN)).json()
    assert second["id"] == desire.id
    assert second["params"]["speed"] != 0.5
    assert goals(system) == [("Ann", 0)]


async def test_the_same_goal_again_changes_nothing(client: httpx.AsyncClient, system: System) -> None:
    first = (await client.put("/goal", json={"x": 2, "y": 1}, headers=ANN)).json()
    # Nor does it take back what the robot made of it to get there.
    first |= {"utility": 8.0}
    system.workspace.change(first["id"], utility=8)
    before = system.workspace.statistics()
    assert (await client.put("/goal", json={"x": 2, "y": 1}, headers=ANN)).json() == first
    assert system.workspace.statistics() == before


async def test_another_persons_goal_gives_way_and_the_robots_own_is_outdone(
    client: httpx.AsyncClient, system: System
) -> None:
    await client.put("/goal", json={"x": 1, "y": 0}, headers=ANN)
    await client.put("/goal", json={"x": 2, "y": 0}, headers={"X-HBBA-Operator": "Bob"})
    assert goals(system) == [("Bob", 2)]
    own = Source("motivation", "Patrol")
    system.workspace.add("GoTo", intensity=8, utility=1, source=own, params={"x": 9, "y": 9})
    # As intense, and newer: a change in place would not be heard.
    await client.put("/goal", json={"x": 3, "y": 0}, headers={"X-HBBA-Operator": "Bob"})
    assert goals(system) == [("Patrol", 9), ("Bob", 3)]
    assert system.workspace.strongest()["GoTo"].source.name == "Bob"
    for _ in range(2):
        assert (await client.delete("/goal")).status_code == 204
    assert goals(system) == [("Patrol", 9)]


async def reported(system: System, state: str) -> None:
    """Wait until it is reported that navigation is in ``state``."""
    channel = system.graph.channel("navigation_report")
    async with asyncio.timeout(PATIENCE_S):
        while channel.latest is None or channel.latest.state != state:  # noqa: ASYNC110
            await asyncio.sleep(0)


async def test_what_became_of_it_is_reported(client: httpx.AsyncClient, system: System) -> None:
    await reported(system, "idle")
    desired, going = await goal_now(client)
    assert desired is None
    assert going.state == "idle"
    desire = (await client.put("/goal", json={"x": 3, "y": 1})).json()
    system.graph.channel("path").publish(path(system.clock.now()))
    system.graph.channel("navigation").publish(status(system.clock.now()))
    await reported(system, "following")
    desired, going = await goal_now(client)
    assert desired is not None
    assert desired.id == going.desire == desire["id"]
    assert going.goal == GoalPoseModel(x=3.0, y=1.0, theta=None)
    assert going.path == [(0.0, 0.0), (0.2, 0.0)]


BAD_GOALS = [
    ('{"x": NaN, "y": 0}', "x"),
    ('{"x": 0, "y": Infinity}', "y"),
    ('{"x": 1000.5, "y": 0}', "x"),
    ('{"x": 0, "y": 0, "heading": -Infinity}', "heading"),
    ('{"x": 0, "y": 0, "speed": 0}', "speed"),
    ('{"x": 0, "y": 0, "speed": 2}', "speed"),
    ('{"x": "0", "y": 0}', "x"),
    ('{"y": 0}', "x"),
    ('{"x": 0, "y": 0, "start": true}', "start"),
]


async def test_a_goal_that_cannot_be_is_refused_by_name(client: httpx.AsyncClient, system: System) -> None:
    await client.put("/goal", json={"x": 1, "y": 1})
    for body, field in BAD_GOALS:
        refused = await client.put("/goal", content=body, headers={"Content-Type": "application/json"})
        document = is_problem(refused, 422, "invalid-request")
        assert document["errors"][0]["field"] == field
    assert goals(system) == [("rest", 1)]


async def test_a_stop_by_any_source_ends_the_goal(
    client: httpx.AsyncClient, system: System, body: Body, hub: Hub
) -> None:
    own = Source("motivation", "Patrol")

    async def by_rest() -> None:
        await client.post("/stop")

    async def by_a_page() -> None:
        hub.driving.e_stop("Ann")

    async def at_the_robot() -> None:
        body.e_stopped = True
        body.emit_status(system.clock.now())

    for stop in (by_rest, by_a_page, at_the_robot):
        system.workspace.add("GoTo", intensity=1, utility=1, source=own, params={"x": 9, "y": 9})
        await client.put("/goal", json={"x": 1, "y": 1})
        await stop()
        assert goals(system) == [], stop.__name__
        system.workspace.add("GoTo", intensity=1, utility=1, source=own, params={"x": 8, "y": 8})
        await client.delete("/stop", params={"seen": system.clock.now()})
        assert goals(system) == [], "what was wanted while it was stopped is not set out for at its release"
        body.emit_status(system.clock.now())


async def test_no_goal_is_taken_while_the_emergency_stop_is_latched(client: httpx.AsyncClient, system: System) -> None:
    await client.post("/stop")
    document = is_problem(await client.put("/goal", json={"x": 1, "y": 1}), 409, "e-stop-latched")
    assert document["detail"] == "The emergency stop is latched: release it first."
    assert goals(system) == []
    await client.delete("/stop", params={"seen": system.clock.now()})
    assert (await client.put("/goal", json={"x": 1, "y": 1})).status_code == 200, "as soon as it is released"


async def test_a_goal_on_one_map_is_none_on_another(client: httpx.AsyncClient, system: System) -> None:
    server = FakeMapServer(system.maps)
    system.map.attach(server)
    await client.put("/maps/lab")
    for change in ("/maps/lab/load", "/map/begin"):
        await client.put("/goal", json={"x": 1, "y": 1})
        assert (await client.post(change)).status_code == 200
        assert goals(system) == []
    await client.put("/goal", json={"x": 1, "y": 1})
    is_problem(await client.post("/maps/nowhere/load"), 404, "no-such-map")
    assert goals(system) == [("rest", 1)], "the map is the same"


async def test_goals_end_before_anything_that_is_kept_with_another_map_is_read(
    client: httpx.AsyncClient, system: System
) -> None:
    class Unreadable:
        """What is kept with each map, and cannot be read."""

        goals: Sequence[object] | None = None

        async def files(self) -> Files:
            return {}

        async def load(self, name: str) -> None:
            self.goals = goals(system)
            raise MapUnavailable("its things cannot be read")

        async def clear(self) -> None:
            pass

    system.map.attach(FakeMapServer(system.maps))
    await client.put("/maps/lab")
    layer = Unreadable()
    await system.map.add(layer)
    await client.put("/goal", json={"x": 1, "y": 1})
    is_problem(await client.post("/maps/lab/load"), 409, "map-unavailable")
    assert layer.goals == goals(system) == []


async def test_a_program_that_goes_nowhere_says_so(
    client: httpx.AsyncClient, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: Any = tuple(strategy for strategy in system.table.strategies if strategy.cls != "GoTo")
    monkeypatch.setattr(type(system.table), "strategies", kept, raising=False)
    document = is_problem(await client.put("/goal", json={"x": 1, "y": 1}), 409, "cannot-go")
    assert "GoTo" in document["detail"]


async def test_a_goal_that_was_given_up_is_reported_until_it_was_read(
    client: httpx.AsyncClient, system: System, hub: Hub
) -> None:
    goal = {"x": 3.0, "y": 1.0, "heading": None}
    about = {"desire": "d", "arrived": False, "why": "walls all around", "goal": goal}
    system.timeline.add("goal", "GoTo", "Gave up going there", about)
    _, going = await goal_now(client)
    assert isinstance(going.given_up, GivenUpModel)
    assert (going.given_up.goal.x, going.given_up.reason) == (3.0, "walls all around")
    assert (await client.delete("/goal")).status_code == 204
    assert (await client.get("/goal")).json()["navigation"]["given_up"] is None
    classes = (await client.get("/desire-classes")).json()["classes"]
    served = {cls["name"]: cls["served"] for cls in classes}
    assert served["GoTo"]
    assert not served["Record"], "no Recorder, and no strategy for it"
