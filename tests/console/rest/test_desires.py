"""Desires over REST: created, changed, removed, and refused field by field."""

from __future__ import annotations

from typing import Any

import httpx
import pytest

from app.attention.desires import Desire, Source
from app.program.system import System
from app.runtime.filter import CLOSED
from tests.console.answers import answered, is_problem
from tests.console.program import NEW


async def test_a_desire_from_creation_to_removal(client: httpx.AsyncClient, system: System) -> None:
    created = await client.post("/desires", json=NEW)
    assert created.status_code == 201
    desire = answered(created, Desire)
    assert created.headers["location"] == f"/api/v1/desires/{desire.id}"
    assert desire.expires == pytest.approx(desire.created + 30)
    assert desire.source.kind == "rest"
    await system.translator.settled()
    assert system.graph.filters.divisors()["CameraStream.images"] == 1
    got = await client.get(f"/desires/{desire.id}")
    assert got.json() == {**created.json(), "outcome": None, "behavior": "", "reason": "", "ended": None}

    changed = await client.patch(f"/desires/{desire.id}", json={"utility": 1, "intensity": 0.5, "ttl": None})
    assert changed.status_code == 200
    assert changed.json()["intensity"] == 0.5
    assert changed.json()["expires"] is None
    assert changed.json()["params"] == created.json()["params"]

    assert (await client.delete(f"/desires/{desire.id}")).status_code == 204
    is_problem(await client.delete(f"/desires/{desire.id}"), 404, "no-such-desire")
    await system.translator.settled()
    assert system.graph.filters.divisors()["CameraStream.images"] == CLOSED


async def test_an_operator_is_named_by_the_page(client: httpx.AsyncClient) -> None:
    created = await client.post("/desires", json=NEW, headers={"X-HBBA-Operator": "Zo%C3%A9"})
    assert created.json()["source"] | {"kind": "operator", "name": "Zoé"} == created.json()["source"]


async def test_the_same_key_creates_once(client: httpx.AsyncClient) -> None:
    key = {"Idempotency-Key": "k1"}
    first = await client.post("/desires", json=NEW, headers=key)
    # Equal in meaning is enough.
    again = await client.post("/desires", json={**NEW, "intensity": 8.0}, headers=key)
    assert again.status_code == 201
    assert again.json() == first.json()
    assert again.headers["location"] == first.headers["location"]
    assert again.headers["idempotency-replayed"] == "true"
    assert len((await client.get("/desires")).json()["desires"]) == 1
    other = await client.post("/desires", json={**NEW, "intensity": 7}, headers=key)
    is_problem(other, 422, "idempotency-key-reused")
    assert (await client.post("/desires", json=NEW, headers={"Idempotency-Key": "k2"})).json() != first.json()


async def test_a_refused_request_does_not_use_up_its_key(client: httpx.AsyncClient) -> None:
    key = {"Idempotency-Key": "k"}
    assert (await client.post("/desires", json={**NEW, "class": "Fly"}, headers=key)).status_code == 422
    assert (await client.post("/desires", json=NEW, headers=key)).status_code == 201


async def test_an_unknown_class_names_those_there_are(client: httpx.AsyncClient, system: System) -> None:
    response = await client.post("/desires", json={**NEW, "class": "Telepresense"})
    problem = is_problem(response, 422, "unknown-desire-class")
    assert problem["known"] == sorted(system.classes)
    assert "FindQRCodes" in problem["known"]
    assert problem["errors"][0]["field"] == "class"
    assert "Telepresence" in problem["detail"]


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({**NEW, "intensity": 9}, "intensity"),
        ({**NEW, "intensity": 0}, "intensity"),
        ({**NEW, "intensity": "8"}, "intensity"),
        ({**NEW, "intensity": True}, "intensity"),
        ({**NEW, "utility": -1}, "utility"),
        ({**NEW, "security": "yes"}, "security"),
        ({**NEW, "ttl": 0}, "ttl"),
        ({**NEW, "ttl": 1e12}, "ttl"),
        ({**NEW, "urgency": 3}, "urgency"),
        ({key: value for key, value in NEW.items() if key != "class"}, "class"),
        ({**NEW, "params": {"max_points": 10}}, "params.max_points"),
        ({**NEW, "params": {"maxpoints": 2000}}, "params.maxpoints"),
        ({**NEW, "params": []}, "params"),
        ([NEW], "body"),
    ],
)
async def test_a_wrong_field_is_named(client: httpx.AsyncClient, body: Any, field: str) -> None:
    response = await client.post("/desires", json=body)
    assert response.status_code == 422
    document = is_problem(response, 422, response.json()["type"].rpartition(":")[2])
    assert [error["field"] for error in document["errors"]] == [field]
    assert all(error["message"] for error in document["errors"])
    assert (await client.get("/desires")).json()["desires"] == []


async def test_null_is_no_change(client: httpx.AsyncClient) -> None:
    desire = (await client.post("/desires", json=NEW)).json()
    response = await client.patch(f"/desires/{desire['id']}", json={"utility": None})
    assert is_problem(response, 422, "invalid-request")["errors"][0]["field"] == "utility"


async def test_desires_over_the_console_have_a_bound_and_motivations_none(
    client: httpx.AsyncClient, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.console.rest.desires.MOST_DESIRES", 3)
    motivation = Source("motivation", "Curiosity")
    for _ in range(3):
        system.workspace.add("Telepresence", intensity=1, utility=1, source=motivation)
    made = [await client.post("/desires", json=NEW, headers={"Idempotency-Key": str(n)}) for n in range(3)]
    assert [answer.status_code for answer in made] == [201] * 3
    refused = is_problem(await client.post("/desires", json=NEW), 409, "too-many-desires")
    assert "at most 3 are allowed" in refused["detail"]
    is_problem(await client.put("/goal", json={"x": 1, "y": 1}), 409, "too-many-desires")
    again = await client.post("/desires", json=NEW, headers={"Idempotency-Key": "0"})
    assert again.headers["idempotency-replayed"] == "true"
    await client.delete(made[0].headers["location"].removeprefix("/api/v1"))
    assert (await client.put("/goal", json={"x": 1, "y": 1})).status_code == 200
    assert (await client.put("/goal", json={"x": 2, "y": 1})).status_code == 200
    system.workspace.add("Telepresence", intensity=1, utility=1, source=motivation)
