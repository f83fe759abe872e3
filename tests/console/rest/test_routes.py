"""REST: every route answers in the shape it declares, and every refusal is a problem document."""

from __future__ import annotations

import asyncio
import json
import math
from functools import partial
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from app.attention.desires import Desire, Source
from app.console.live.hub import Hub
from app.console.records import attention, program, robot
from app.console.records.lanes import LanesPast
from app.messages import DesireClassReport, Desires, IntentionReport, LaneRow, Lanes, ModuleReport, PerceptEvent
from app.program.system import System
from app.runtime.filter import CLOSED
from tests.console.answers import answered, described
from tests.console.program import Body

NEW = {"class": "Telepresence", "intensity": 8, "utility": 4, "security": False, "params": {}, "ttl": 30}


def is_problem(response: httpx.Response, status: int, kind: str) -> dict[str, Any]:
    """Check that ``response`` is this problem and return the document."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    document: dict[str, Any] = response.json()
    assert document["type"] == f"urn:hbba:problem:{kind}"
    assert document["status"] == status
    assert document["title"]
    assert document["detail"]
    return document


@pytest.mark.parametrize(
    ("path", "record"),
    [
        ("/desires", Desires),
        ("/desire-classes", attention.DesireClassList),
        ("/desire-classes/Telepresence", DesireClassReport),
        ("/intention", IntentionReport),
        ("/strategies", attention.StrategyList),
        ("/resources", attention.ResourceList),
        ("/modules", program.ModuleList),
        ("/modules/Teleop", ModuleReport),
        ("/channels", program.ChannelList),
        ("/timeline", attention.EventList),
        ("/lanes", LanesPast),
        ("/robot", robot.RobotReport),
        ("/session", program.Session),
        ("/health", program.Health),
        ("/viewers", program.ViewerList),
        ("/scene", program.SceneAddress),
    ],
)
async def test_every_answer_has_the_shape_that_is_declared(
    client: httpx.AsyncClient, path: str, record: type[Any]
) -> None:
    described(await client.get(path), record)


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
    ("path", "body", "message"),
    [
        (
            "/desires",
            {**NEW, "intensty": 3},
            "unknown key; did you mean 'intensity'? allowed: class, intensity, params, ",
        ),
        ("/desires", {**NEW, "intensity": 9}, "should be less than or equal to 8, not 9"),
        ("/desires", {**NEW, "params": "none"}, "should be a JSON object, not 'none'"),
        ("/desires", {"intensity": 1, "utility": 1}, "is missing"),
        ("/map/pose", {"x": 1, "y": 2, "theta": 0, "z": 1}, "unknown key; allowed: theta, x, y"),
        ("/maps/hall/load", {"pose": {"x": 1, "y": 2, "heading": 0}}, "unknown key; allowed: theta, x, y"),
        ("/maps/hall/load", {"pose": "there"}, "should be a JSON object, not 'there'"),
    ],
)
async def test_what_is_allowed_is_said_in_words(
    client: httpx.AsyncClient, path: str, body: dict[str, Any], message: str
) -> None:
    response = await client.request("PUT" if path.endswith("pose") else "POST", path, json=body)
    messages = [error["message"] for error in is_problem(response, 422, "invalid-request")["errors"]]
    assert any(said.startswith(message) for said in messages), messages


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


@pytest.mark.parametrize("body", ["", "{", '{"class": NaN}', "\xff"])
async def test_a_body_that_is_no_json_is_refused(client: httpx.AsyncClient, body: str) -> None:
    response = await client.post(
        "/desires", content=body.encode("latin-1"), headers={"Content-Type": "application/json"}
    )
    assert response.status_code in (400, 422)
    is_problem(response, response.status_code, response.json()["type"].rpartition(":")[2])


async def test_null_is_no_change(client: httpx.AsyncClient) -> None:
    desire = (await client.post("/desires", json=NEW)).json()
    response = await client.patch(f"/desires/{desire['id']}", json={"utility": None})
    assert is_problem(response, 422, "invalid-request")["errors"][0]["field"] == "utility"


async def test_what_is_not_there_is_a_problem(client: httpx.AsyncClient) -> None:
    is_problem(await client.get("/nonsense"), 404, "not-found")
    is_problem(await client.get("/desires/d-0"), 404, "no-such-desire")
    is_problem(await client.get("/modules/Nothing"), 404, "no-such-module")
    is_problem(await client.get("/desire-classes/Fly"), 404, "no-such-desire-class")
    is_problem(await client.patch("/resources/gold", json={"capacity": 1}), 404, "no-such-resource")


async def test_a_wrong_method_says_which_are_right(client: httpx.AsyncClient) -> None:
    response = await client.put("/desires", json={})
    is_problem(response, 405, "method-not-allowed")
    assert {m.strip() for m in response.headers["allow"].split(",")} == {"GET", "POST"}


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


async def test_the_emergency_stop_is_latched_and_released(client: httpx.AsyncClient, body: Body) -> None:
    latched = (await client.post("/stop")).json()
    assert latched["e_stop"] == "latched"
    assert body.stops == ["pressed by REST client"]
    robot = (await client.get("/robot")).json()
    assert robot["guard"]["state"] == "e_stopped"
    assert robot["stamp"] > latched["stamp"]
    released = await client.delete("/stop", params={"seen": robot["stamp"]})
    assert released.json()["e_stop"] == "released"
    assert not body.e_stopped
    assert (await client.delete("/stop")).json()["e_stop"] == "released", "nothing is latched: may be repeated"


async def test_a_stop_that_was_not_seen_is_not_released(
    client: httpx.AsyncClient, body: Body, system: System, hub: Hub
) -> None:
    before = (await client.get("/robot")).json()["stamp"]
    first = (await client.post("/stop")).json()["stamp"]
    problem = is_problem(await client.delete("/stop"), 409, "stop-not-seen")
    assert "?seen=" in problem["detail"]
    for stamp in (before, first - 60, system.clock.now() + 60):
        is_problem(await client.delete("/stop", params={"seen": stamp}), 409, "stop-not-seen")
    # Released with the stamp of the first stop, but late: it was pressed again meanwhile.
    hub.driving.e_stop("Ann")
    is_problem(await client.delete("/stop", params={"seen": first}), 409, "stop-not-seen")
    assert body.e_stopped
    is_problem(await client.delete("/stop", params={"seen": "nan"}), 422, "invalid-request")
    seen = (await client.get("/robot")).json()["stamp"]
    assert (await client.delete("/stop", params={"seen": seen})).status_code == 200
    assert not body.e_stopped


async def test_a_stop_that_the_guard_does_not_confirm_is_not_called_latched(
    client: httpx.AsyncClient, body: Body
) -> None:
    body.confirms = False
    is_problem(await client.post("/stop"), 504, "unconfirmed")
    assert body.e_stopped


async def test_a_body_that_falls_silent_is_reported(client: httpx.AsyncClient, system: System, body: Body) -> None:
    state = "silent"
    while state == "silent":  # a busy computer may answer later than a status lasts
        body.emit_status(system.clock.now())
        state = (await client.get("/robot")).json()["guard"]["state"]
    assert state == "idle"
    body.emit_status(system.clock.now() - 2)
    guard = (await client.get("/robot")).json()["guard"]
    assert guard["state"] == "silent"
    assert "nothing for 2" in guard["reason"]
    health = (await client.get("/health")).json()
    assert health["status"] == "degraded"
    assert guard["reason"][:30] in health["problems"][-1]


@pytest.mark.parametrize("body", [b"", b"[]", b"null", b"class=FindQRCodes"])
async def test_a_body_that_is_no_object_is_refused_with_the_right_form(client: httpx.AsyncClient, body: bytes) -> None:
    plain = await client.post("/desires", content=body, headers={"Content-Type": "text/plain"})
    problem = is_problem(plain, 422, "invalid-request")
    assert "Content-Type: application/json" in problem["detail"]
    assert problem["errors"][0]["field"] == "body"


@pytest.mark.parametrize("capacity", [1e18, 1e300])
async def test_a_capacity_beyond_all_means_is_refused(client: httpx.AsyncClient, capacity: float) -> None:
    is_problem(await client.patch("/resources/cpu", json={"capacity": capacity}), 422, "invalid-request")


async def test_the_description_is_whole(client: httpx.AsyncClient) -> None:
    document = (await client.get("/openapi.json")).json()
    operations = [o for path in document["paths"].values() for o in path.values()]
    assert len(operations) >= 20
    for operation in operations:
        assert operation["tags"]
        assert operation["summary"]
    references = {value for key, value in walk(document) if key == "$ref"}
    names = {*document["components"]["schemas"], *document["components"]["responses"]}
    assert {reference.rpartition("/")[2] for reference in references} <= names
    assert "HTTPValidationError" not in names
    create = document["paths"]["/api/v1/desires"]["post"]
    refused = {"400", "401", "403", "408", "409", "413", "421", "422", "429", "431", "503"}
    assert set(create["responses"]) == {"201", *refused}
    assert "application/problem+json" in create["responses"]["422"]["content"]


async def test_docs_leads_to_the_page_on_rest_and_without_it_to_how_it_is_built(client: httpx.AsyncClient) -> None:
    docs = await client.get("/docs")
    assert docs.status_code == 307
    page = await client.get("/docs", follow_redirects=True)
    assert str(page.url).endswith("/rest.html")
    assert "<h1>The robot runs, its page is not built</h1>" in page.text  # as in this test


def walk(value: Any) -> Any:
    """Every key and value inside ``value``."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key, inner
            yield from walk(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from walk(inner)


async def test_the_health_names_a_module_that_fails(client: httpx.AsyncClient, system: System) -> None:
    assert (await client.get("/health")).json()["status"] == "ok"
    failed = asyncio.Event()
    system.supervisor.observe(lambda state: failed.set() if state.status == "failed" else None)
    system.graph.channel("teleop_command").publish("no message at all")
    await failed.wait()
    health = (await client.get("/health")).json()
    assert health["status"] == "degraded"
    assert health["problems"] == ["Teleop: failed"]
    assert "AttributeError" in (await client.get("/modules/Teleop")).json()["problem"]


async def test_what_is_said_twice_is_not_guessed_at(client: httpx.AsyncClient, system: System) -> None:
    headers = {"Content-Type": "application/json"}
    for name in ("intensity", "rése", 'quo"ted'):
        member = json.dumps(name)
        body = f'{{"class": "Telepresence", "utility": 4, "params": {{{member}: 1, "other": 2, {member}: 8}}}}'
        refused = await client.post("/desires", content=body.encode(), headers=headers)
        document = is_problem(refused, 400, "malformed-json")
        assert repr(name) in document["detail"]
        assert f"character {body.rindex(member)}" in document["detail"]
    assert system.workspace.desires() == ()


@pytest.mark.parametrize("value", ["9" * 5_000, "-" + "9" * 300, "[" * 900 + "]" * 900, "[" * 20_000 + "]" * 20_000])
async def test_a_body_beyond_all_bounds_is_refused(value: str, client: httpx.AsyncClient, system: System) -> None:
    headers = {"Content-Type": "application/json"}
    for key in ("utility", "params"):
        body = f'{{"class": "Telepresence", "{key}": {value}}}'
        document = is_problem(
            await client.post("/desires", content=body.encode(), headers=headers), 422, "invalid-request"
        )
        assert document["errors"][0]["field"] == "body"
        assert "digits" in document["detail"] or "nested too deeply" in document["detail"]
    assert system.workspace.desires() == ()


async def test_a_time_that_is_none_is_refused(client: httpx.AsyncClient) -> None:
    for name in ("since", "until"):
        for value in ("nan", "inf", "-inf"):
            document = is_problem(await client.get("/timeline", params={name: value}), 422, "invalid-request")
            assert document["errors"][0]["field"] == f"query.{name}"


@pytest.mark.parametrize(
    "body",
    [
        rb'{"class": "GoTo", "intensity": 1, "utility": 1, "params": {"\ud800": "a"}}',
        rb'{"class": "GoTo", "intensity": 1, "utility": 1, "params": {"a": ["\udfff"]}}',
        rb'{"class": "\uD800x", "intensity": 1, "utility": 1}',
        rb'{"\udc00\ud800": 1}',
        rb'"\ud800"',
    ],
)
@pytest.mark.parametrize("path", ["/desires", "/session", "/recordings", "/map/zones"])
async def test_half_a_character_is_no_json_here(client: httpx.AsyncClient, path: str, body: bytes) -> None:
    """It cannot be written in UTF-8: neither in a log, nor in the answer that would name it."""
    method = "PUT" if path == "/map/zones" else "POST"
    headers = {"Content-Type": "application/json"}
    response = await client.request(method, path, content=body, headers=headers)
    problem = is_problem(response, 400, "malformed-json")
    assert "half a character" in problem["detail"]


async def test_two_halves_are_a_character(client: httpx.AsyncClient) -> None:
    body = rb'{"class": "\ud83e\udd16", "intensity": 1, "utility": 1}'
    response = await client.post("/desires", content=body, headers={"Content-Type": "application/json"})
    assert "\U0001f916" in is_problem(response, 422, "unknown-desire-class")["detail"]


async def test_what_is_nested_too_deeply_is_not_taken(client: httpx.AsyncClient) -> None:
    for body in (b"[" * 60_000, b'{"params": ' * 5_000 + b"1" + b"}" * 5_000):
        response = await client.post("/desires", content=body, headers={"Content-Type": "application/json"})
        assert "nested too deeply" in is_problem(response, 422, "invalid-request")["detail"]


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


async def test_what_a_path_of_its_own_takes_is_all_it_says(client: httpx.AsyncClient) -> None:
    for path, allowed in (
        ("/recordings/stop", "POST"),
        ("/recordings/save", "POST"),
        ("/recordings/tour", "DELETE, GET"),
    ):
        response = await client.options(path)
        is_problem(response, 405, "method-not-allowed")
        assert response.headers["allow"] == allowed


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
