"""REST: every route answers in the shape it declares, and every refusal is a problem document."""

from __future__ import annotations

import json
from typing import Any

import httpx
import pytest

from app.console.records import attention, program, robot
from app.console.records.lanes import LanesPast
from app.messages import DesireClassReport, Desires, IntentionReport, ModuleReport
from app.program.system import System
from tests.console.answers import described, is_problem
from tests.console.program import NEW


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


@pytest.mark.parametrize("body", ["", "{", '{"class": NaN}', "\xff"])
async def test_a_body_that_is_no_json_is_refused(client: httpx.AsyncClient, body: str) -> None:
    response = await client.post(
        "/desires", content=body.encode("latin-1"), headers={"Content-Type": "application/json"}
    )
    assert response.status_code in (400, 422)
    is_problem(response, response.status_code, response.json()["type"].rpartition(":")[2])


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


@pytest.mark.parametrize("body", [b"", b"[]", b"null", b"class=FindQRCodes"])
async def test_a_body_that_is_no_object_is_refused_with_the_right_form(client: httpx.AsyncClient, body: bytes) -> None:
    plain = await client.post("/desires", content=body, headers={"Content-Type": "text/plain"})
    problem = is_problem(plain, 422, "invalid-request")
    assert "Content-Type: application/json" in problem["detail"]
    assert problem["errors"][0]["field"] == "body"


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


async def test_what_a_path_of_its_own_takes_is_all_it_says(client: httpx.AsyncClient) -> None:
    for path, allowed in (
        ("/recordings/stop", "POST"),
        ("/recordings/save", "POST"),
        ("/recordings/tour", "DELETE, GET"),
    ):
        response = await client.options(path)
        is_problem(response, 405, "method-not-allowed")
        assert response.headers["allow"] == allowed
