"""What attention does, over REST: budgets, what would be chosen, the timeline, the lanes."""

from __future__ import annotations

import math
from functools import partial

import httpx
import pytest
from fastapi import FastAPI

from app.messages import LaneRow, Lanes, PerceptEvent
from app.program.system import System
from tests.console.answers import is_problem
from tests.console.program import NEW


async def test_a_budget_is_changed_and_attention_follows(client: httpx.AsyncClient, system: System) -> None:
    await client.post("/desires", json={**NEW, "utility": 1})
    await system.translator.settled()
    assert (await client.get("/intention")).json()["strategies"][0]["name"] == "picture-fast"
    response = await client.patch("/resources/cpu", json={"capacity": 20})
    assert response.json()["capacity"] == 20
    assert response.json()["declared"] == 100
    await system.translator.settled()
    intention = (await client.get("/intention")).json()
    assert [strategy["name"] for strategy in intention["strategies"]] == ["picture-slow"]
    assert intention["filters"]["CameraStream.images"] == 4
    assert intention["filters"]["Teleop.twist"] is None
    is_problem(await client.patch("/resources/cpu", json={"capacity": -1}), 422, "invalid-request")


async def test_what_would_be_chosen_is_asked_without_touching_the_robot(
    client: httpx.AsyncClient, system: System
) -> None:
    await client.post("/desires", json={**NEW, "utility": 1})
    await system.translator.settled()
    before = system.translator.statistics(), system.workspace.desires(), system.translator.capacities
    ask = partial(client.post, "/intention/what-if")
    now = (await client.get("/intention")).json()
    same = (await ask(json={})).json()
    assert {key: same[key] for key in ("strategies", "filters", "reasons", "use", "omega", "desires", "asked")} == {
        key: now[key] for key in ("strategies", "filters", "reasons", "use", "omega", "desires", "asked")
    }
    less = (await ask(json={"capacities": {"cpu": 20}})).json()
    assert [strategy["name"] for strategy in less["strategies"]] == ["picture-slow"]
    assert less["filters"]["CameraStream.images"] == 4
    cheaper = {"capacities": {"cpu": 20}, "costs": {"picture-fast": {"cpu": 20}}}
    assert (await ask(json=cheaper)).json()["strategies"][0]["name"] == "picture-fast"
    assert (await ask(json={"desires": {NEW["class"]: None}})).json()["strategies"] == []
    for body, field in (
        ({"desires": {"Fly": None}}, "body.desires.Fly"),
        ({"costs": {"picture-fast": {"gold": 1}}}, "body.costs.picture-fast.gold"),
        ({"capacities": {"gold": 1}}, "body.capacities.gold"),
    ):
        response = await ask(json=body)
        is_problem(response, 422, "invalid-request")
        assert response.json()["errors"][0]["field"] == field
    is_problem(await ask(json={"capacities": {"cpu": -1}}), 422, "invalid-request")
    assert (system.translator.statistics(), system.workspace.desires(), system.translator.capacities) == before


async def test_percept_events_are_on_the_timeline_under_their_names(client: httpx.AsyncClient, system: System) -> None:
    now = system.clock.now()
    event = PerceptEvent(now, "face.appears", "face", "3", "kinect", now - 1, 0.9, (1.0, 2.0, 1.5), 0.5)
    system.graph.channel("percept_events").publish(event)
    (noted,) = (await client.get("/timeline", params={"kinds": "percept"})).json()["events"]
    assert (noted["subject"], noted["stamp"]) == ("face.appears", now)
    assert noted["text"] == "Face 3 appears at x 1.0 m, y 2.0 m in odom"
    assert noted["data"] == {
        "kind": "face", "subject": "3", "label": "face 3", "source": "kinect", "since": now - 1, "confidence": 0.9,
        "p_OP": [1.0, 2.0, 1.5], "heading": 0.5,
    }  # fmt: skip


async def test_the_timeline_is_queried_by_time_kind_and_number(client: httpx.AsyncClient, system: System) -> None:
    await client.post("/desires", json=NEW)
    await system.translator.settled()
    events = (await client.get("/timeline")).json()["events"]
    assert {event["kind"] for event in events} >= {"desire", "intention", "filter"}
    desires = (await client.get("/timeline", params={"kinds": "desire"})).json()["events"]
    assert {event["kind"] for event in desires} == {"desire"}
    later = await client.get("/timeline", params={"after_id": events[-1]["id"]})
    assert later.json() == {"events": []}
    assert len((await client.get("/timeline", params={"limit": 1})).json()["events"]) == 1
    none = await client.get("/timeline", params={"until": events[0]["stamp"] - 1})
    assert none.json() == {"events": []}
    problem = is_problem(await client.get("/timeline", params={"kinds": "wish"}), 422, "invalid-request")
    assert problem["errors"][0]["field"] == "query.kinds"
    is_problem(await client.get("/timeline", params={"limit": 100000}), 422, "invalid-request")
    problem = is_problem(await client.get("/timeline", params={"limt": 1}), 422, "invalid-request")
    assert problem["detail"].startswith(
        "query.limt: unknown parameter; did you mean 'limit'? allowed: after_id, kinds,"
    )
    assert (await client.get("/desires", params={"again": 1})).status_code == 200


async def test_a_long_timeline_comes_packed_to_whom_takes_that(client: httpx.AsyncClient, system: System) -> None:
    for _ in range(10):
        await client.post("/desires", json=NEW)
    await system.translator.settled()
    plain = await client.get("/timeline", headers={"Accept-Encoding": "identity"})
    assert "Content-Encoding" not in plain.headers
    small = await client.get("/timeline", headers={"Accept-Encoding": "gzip, br"})
    assert small.headers["Content-Encoding"] == "gzip"
    assert small.headers["Vary"] == plain.headers["Vary"] == "Accept-Encoding"
    assert int(small.headers["Content-Length"]) < len(plain.content) / 4
    assert small.json()["events"][: len(plain.json()["events"])] == plain.json()["events"]
    short = await client.get("/timeline", params={"limit": 1}, headers={"Accept-Encoding": "gzip"})
    assert "Content-Encoding" not in short.headers


@pytest.mark.parametrize("capacity", [1e18, 1e300])
async def test_a_capacity_beyond_all_means_is_refused(client: httpx.AsyncClient, capacity: float) -> None:
    is_problem(await client.patch("/resources/cpu", json={"capacity": capacity}), 422, "invalid-request")


async def test_a_time_that_is_none_is_refused(client: httpx.AsyncClient) -> None:
    for name in ("since", "until"):
        for value in ("nan", "inf", "-inf"):
            document = is_problem(await client.get("/timeline", params={name: value}), 422, "invalid-request")
            assert document["errors"][0]["field"] == f"query.{name}"


async def test_the_past_of_the_lanes_is_given_in_buckets(client: httpx.AsyncClient, app: FastAPI) -> None:
    rows = tuple(
        LaneRow(cls, 8.0, 4.0, 0.25, math.inf, {}, "unfulfilled", "it costs too much")
        for cls in ("Telepresence", "Explore")
    )
    for number in range(100):
        app.state.hub.lanes.add(Lanes(0.5 * number + 1e6, rows))
    past = (await client.get("/lanes", params={"from": 1e6, "to": 1e6 + 100, "points": 10})).json()
    assert past["bucket_s"] == 10
    assert past["stamps"] == [1e6 + 10 * n for n in range(5)]
    assert past["ends"] == [1e6 + 10 * n + 9.5 for n in range(5)]
    (row,) = [row for row in past["rows"] if row["class"] == "Telepresence"]
    assert row["low"] == row["high"] == row["rate"] == [0.25] * 5
    assert [(change["stamp"], change["divisor"]) for change in row["changes"]] == [(1e6, None)]
    is_problem(await client.get("/lanes", params={"points": 5000}), 422, "invalid-request")
    problem = is_problem(await client.get("/lanes", params={"from": 2, "to": 1}), 422, "invalid-request")
    assert problem["errors"] == [{"field": "query.from", "message": "2.0 is after to, 1.0"}]
