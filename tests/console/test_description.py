"""The OpenAPI description is what tools make clients of: names, limits, refusals and who may, as they are."""

from __future__ import annotations

import gc
import re
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import pytest
from fastapi import FastAPI

from app.console.app import create_app
from app.console.description import describe
from app.console.problems import MEDIA_TYPE
from app.console.rest.attention import KINDS_PATTERN
from app.program.system import System
from tests.console.program import build, write_page

#: What client generators call their functions. A name that is changed here breaks the programs of others.
NAMES = """\
add_tour_media ask_what_if begin_map cancel_goal cancel_rehearsal change_desire change_place change_playback
change_resource change_tour check_visitor create_desire create_place create_tour create_webhook delete_episode
delete_map delete_memory delete_place delete_recording delete_tour delete_tour_media delete_tour_report delete_webhook
dismiss_tour download_recording end_replay enter_as_visitor export_tour export_tour_archive export_tour_reports
find_camera_point find_scene_point get_desire get_desire_class get_emotions get_fleet get_goal get_health
get_intention get_lanes get_link get_map get_map_picture get_memory get_module get_percepts get_place get_playback
get_rehearsal get_robot get_scene get_session get_timeline get_tour get_tour_media get_tour_posters get_tour_report
get_tour_run get_tour_schema get_visitor_link get_visitor_media get_webhook get_zones import_tour latch_e_stop
list_channels list_desire_classes list_desires list_maps list_modules list_places list_recordings list_resources
list_rules list_strategies list_tour_media list_tour_reports list_tours list_viewers list_webhooks load_map log_in
log_out place_robot plan_route press_as_visitor press_tour put_link redo_tour release_e_stop remove_desire rename_map
replace_place replace_tour replay_recording save_map save_ring search_robot set_goal set_zones start_recording
start_rehearsal start_tour step_playback stop_recording try_webhook undo_tour validate_tour
"""


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The description of REST, where it is compared with what a program does."""
    folder = tmp_path_factory.mktemp("program")
    return create_app(build(folder)[0], static_dir=write_page(folder), early_view=False).openapi()


def operations(document: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Path, method and description of each."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield path, method, operation


def parameter(document: dict[str, Any], name: str, operation: str) -> dict[str, Any]:
    """The schema of the parameter ``name``."""
    (found,) = (o for _, _, o in operations(document) if o["operationId"] == operation)
    (schema,) = (p["schema"] for p in found["parameters"] if p["name"].lower() == name)
    return dict(schema)


def allows(schema: dict[str, Any], value: Any) -> bool:
    """Whether ``value`` is of ``schema``."""
    return bool(jsonschema.Draft202012Validator(schema).is_valid(value))


def test_operations_have_names_that_stay(app: FastAPI) -> None:
    assert sorted(operation["operationId"] for _, _, operation in operations(app.openapi())) == NAMES.split()


def test_who_may_is_said_of_every_operation(app: FastAPI, system: System, page: Path) -> None:
    open_to_all = {(path, method) for path, method, o in operations(app.openapi()) if o.get("security") == []}
    session = {("/api/v1/session", method) for method in ("get", "post", "delete")}
    visitor = {("/api/v1/visitor/session", method) for method in ("get", "post")}
    assert open_to_all == {("/api/v1/health", "get"), *visitor, *session}
    assert app.openapi()["security"] == [{"token": []}, {"session": []}, {}]
    locked = create_app(system, static_dir=page, early_view=False, token="a long token").openapi()
    assert locked["security"] == [{"token": []}, {"session": []}]
    assert locked["components"]["securitySchemes"]["token"]["scheme"] == "bearer"
    assert locked["components"]["securitySchemes"]["session"]["name"] == "hbba_session"


def test_every_refusal_is_described_as_a_problem_document(app: FastAPI) -> None:
    document = app.openapi()
    for path, method, operation in operations(document):
        responses = operation["responses"]
        for status, response in responses.items():
            shared = document["components"]["responses"].get(response.get("$ref", "").rpartition("/")[2])
            if status >= "400":
                assert list((shared or response)["content"]) == [MEDIA_TYPE], (path, method, status)
        assert "421" in responses
        assert ("413" in responses) == ("408" in responses) == (method != "get")
        assert ("403" in responses) == (method != "get" or operation.get("x-role") in ("operator", "supervisor"))
        assert ("405" in responses) == ("{" in path)
        assert "401" in responses or path == "/api/v1/health" or (path, method) == ("/api/v1/session", "delete")


def test_operations_on_behalf_of_an_operator_say_so(app: FastAPI) -> None:
    named = {
        operation["operationId"]
        for _, _, operation in operations(app.openapi())
        if any(each["name"] == "X-HBBA-Operator" for each in operation.get("parameters", ()))
    }
    assert named == {"create_desire", "change_resource", "latch_e_stop", "set_goal", "start_recording"}


def test_the_server_is_the_one_that_was_asked(app: FastAPI) -> None:
    assert [server["url"] for server in app.openapi()["servers"]] == ["/"]


@pytest.mark.parametrize("name", ["a", "a.b-c_1", "x" * 100, "", ".a", "x" * 101, "a b", "é", "a/b", "-"])
@pytest.mark.parametrize(
    ("kind", "operation"),
    [("maps", "delete_map"), ("recordings", "delete_recording")],
)
async def test_names_are_described_as_they_are_taken(
    client: httpx.AsyncClient, document: dict[str, Any], kind: str, operation: str, name: str
) -> None:
    answer = await client.delete(f"/{kind}/{name.replace('/', '%2F')}")
    assert allows(parameter(document, "name", operation), name) == (
        answer.status_code == 404 and answer.json()["type"].startswith("urn:hbba:problem:no-such")
    )


@pytest.mark.parametrize("length", [0, 1, 255, 256])
async def test_a_key_is_described_as_it_is_taken(
    client: httpx.AsyncClient, document: dict[str, Any], length: int
) -> None:
    desire = {"class": "Telepresence", "intensity": 1, "utility": 1}
    answer = await client.post("/desires", json=desire, headers={"Idempotency-Key": "k" * length})
    assert answer.status_code in (201, 422)
    schema = parameter(document, "idempotency-key", "create_desire")
    assert allows(schema, "k" * length) == (answer.status_code == 201)


@pytest.mark.parametrize("kinds", ["", "desire", " desire , goal,,", ",", "desires", "desire goal", "desire,x"])
async def test_kinds_are_described_as_they_are_taken(client: httpx.AsyncClient, kinds: str) -> None:
    answer = await client.get("/timeline", params={"kinds": kinds})
    assert answer.status_code in (200, 422)
    assert (re.search(KINDS_PATTERN, kinds) is not None) == (answer.status_code == 200)


@pytest.mark.parametrize("member", ["intensity", "utility", "security", "params", "ttl"])
async def test_null_is_described_as_it_is_taken(
    client: httpx.AsyncClient, document: dict[str, Any], member: str
) -> None:
    made = await client.post("/desires", json={"class": "Telepresence", "intensity": 1, "utility": 1})
    answer = await client.patch(f"/desires/{made.json()['id']}", json={member: None})
    assert answer.status_code in (200, 422)
    schema = document["components"]["schemas"]["DesireChange"]
    assert allows(schema, {member: None}) == (answer.status_code == 200)


async def test_more_zones_than_are_described_fit_into_a_body_and_are_refused(client: httpx.AsyncClient) -> None:
    zone = {"name": "", "kind": "slow", "polygon": [[0, 0], [2, 0], [2, 1]]}
    answer = await client.put("/map/zones", json={"zones": [zone | {"name": str(number)} for number in range(501)]})
    assert answer.status_code == 422
    assert "at most 500" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("path", "allowed"),
    [
        ("/recordings/stop", "POST"),
        ("/recordings/save", "POST"),
        ("/recordings/tour", "DELETE, GET"),
        ("/desires", "GET, POST"),
        ("/maps/", "GET"),
    ],
)
async def test_allow_names_the_methods_that_are_described(client: httpx.AsyncClient, path: str, allowed: str) -> None:
    answer = await client.request("OPTIONS", path, follow_redirects=True)
    assert answer.status_code == 405
    assert answer.headers["allow"] == allowed


def test_an_application_that_is_described_is_not_kept_for_ever() -> None:
    app = FastAPI(openapi_url=None)
    describe(app, "/api")
    paths = [getattr(route, "path", "") for route in app.routes]
    kept = weakref.ref(app)
    del app
    gc.collect()
    assert "/api/openapi.json" in paths
    assert kept() is None, "FastAPI's caches hold endpoints, and these hold the application"
