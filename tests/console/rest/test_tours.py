"""Tours over REST: edited by two people, checked, undone, exchanged as files, printed; and every refusal."""

from __future__ import annotations

import asyncio
import json
import os
from typing import Any

import httpx
import jsonschema
import yaml

from app.base import paths
from app.console.access.request_limits import LARGEST_BODY_BYTES
from app.console.records.tours import TourList, TourReport, TourVerdict
from app.messages import Place
from app.program.system import System
from app.tours.tour_file import MOST_BYTES
from tests.console.answers import answered, is_problem
from tests.maps.grids import room
from tests.tours.tours import ARM, tour_data

SHIPPED = (paths.config_dir() / "tours" / "lab-tour.yaml").read_bytes()
NEW = tour_data(id="new-tour")


def fields(response: httpx.Response) -> list[str]:
    return [error["field"] for error in response.json()["errors"]]


async def test_a_tour_from_its_making_to_its_deletion(client: httpx.AsyncClient, system: System) -> None:
    made = await client.post("/tours", json=NEW)
    assert (made.status_code, made.headers["Location"]) == (201, "/api/v1/tours/new-tour")
    report = answered(made, TourReport)
    assert report.tour["pace"]["wait_m"] == 4, "every member is there"
    assert [(problem.field, problem.severity) for problem in report.problems] == [
        ("map", "error"),
        ("stops.0.do.0.say", "warning"),
        ("stops.0.do.0.point", "warning"),
    ]
    listed = answered(await client.get("/tours"), TourList)
    assert [(each.id, each.shipped) for each in listed.tours] == [("lab-tour", True), ("new-tour", False)]
    assert listed.tours[1].etag == made.headers["ETag"]
    assert (listed.tours[1].stops, listed.tours[1].errors, listed.tours[1].warnings) == (1, 1, 2)

    changed = await client.patch("/tours/new-tour", json={"pace": {"wait_m": 5}, "home": "robotics-lab"})
    assert changed.json()["tour"]["pace"] == report.tour["pace"] | {"wait_m": 5}
    usual = await client.patch("/tours/new-tour", json={"pace": None, "home": None})
    assert usual.json()["tour"] == report.tour
    assert usual.headers["ETag"] == made.headers["ETag"], "a change that is taken back is none"

    assert (await client.delete("/tours/new-tour")).status_code == 204
    is_problem(await client.get("/tours/new-tour"), 404, "no-such-tour")
    assert await asyncio.to_thread(os.listdir, system.tours.library.folder) == []


async def test_the_second_of_two_editors_is_refused(client: httpx.AsyncClient) -> None:
    first = (await client.post("/tours", json=NEW)).headers["ETag"]
    match = {"If-Match": first}
    second = await client.put("/tours/new-tour", json=NEW | {"map": "office"}, headers=match)
    assert second.status_code == 200
    for late in (
        client.put("/tours/new-tour", json=NEW | {"map": "garage"}, headers=match),
        client.patch("/tours/new-tour", json={"map": "garage"}, headers=match),
        client.delete("/tours/new-tour", headers=match),
        client.post("/tours/new-tour/undo", headers=match),
        client.post("/tours/import", content=yaml.safe_dump(NEW), headers=match),
    ):
        is_problem(await late, 412, "changed-meanwhile")
    assert (await client.get("/tours/new-tour")).json()["tour"]["map"] == "office"
    await client.delete("/tours/new-tour", headers={"If-Match": second.headers["ETag"]})
    is_problem(await client.put("/tours/new-tour", json=NEW, headers=match), 412, "changed-meanwhile")


def long_tour(stops: int = 100, words: int = 60) -> dict[str, Any]:
    """A tour of so many stops with three texts each, of so many words in two languages."""
    text = {"en": " ".join(["explains"] * words), "fr": " ".join(["expliqué"] * words)}
    each = [
        {"id": f"stop-{number}", "place": "robotics-lab", "title": {"en": "The arm", "fr": "Le bras"}}
        | {"do": [{"say": text}] * 3}
        for number in range(stops)
    ]
    return NEW | {"languages": ["en", "fr"], "title": {"en": "All", "fr": "Tout"}, "stops": each}


async def test_a_tour_of_a_hundred_stops_in_two_languages_is_taken(client: httpx.AsyncClient) -> None:
    large = long_tour()
    assert len(json.dumps(large)) > 4 * LARGEST_BODY_BYTES
    made = await client.post("/tours", json=large)
    assert made.status_code == 201
    whole = made.json()["tour"]
    again = await client.put("/tours/new-tour", json=whole | {"home": "robotics-lab"})
    assert (again.status_code, len(again.json()["tour"]["stops"])) == (200, 100)
    changed = await client.patch("/tours/new-tour", json={"stops": whole["stops"][:99]})
    assert len(changed.json()["tour"]["stops"]) == 99
    assert (await client.post("/tours/validate", json=large)).status_code == 200


async def test_a_tour_that_is_too_large_is_refused_with_the_limit(client: httpx.AsyncClient) -> None:
    too_large = json.dumps(long_tour()).encode().ljust(MOST_BYTES + 1)
    for method, path in (("PUT", "new-tour"), ("PATCH", "new-tour"), ("POST", ""), ("POST", "validate")):
        headers = {"Content-Type": "application/json"}
        refused = await client.request(method, f"/tours/{path}".rstrip("/"), content=too_large, headers=headers)
        assert f"{MOST_BYTES} bytes" in is_problem(refused, 413, "body-too-large")["detail"]
    is_problem(await client.post("/tours/new-tour/undo", content=too_large), 413, "body-too-large")


async def test_a_tour_whose_file_would_not_be_read_again_is_not_kept(client: httpx.AsyncClient) -> None:
    made = await client.post("/tours", json=long_tour(words=130))
    assert made.status_code == 201
    kept = made.json()["tour"]
    greeting = {"do": long_tour(words=200)["stops"][0]["do"] * 16}
    refused = await client.patch("/tours/new-tour", json={"greeting": greeting, "farewell": greeting})
    assert "1 MB" in is_problem(refused, 413, "body-too-large")["detail"]
    assert (await client.get("/tours/new-tour")).json()["tour"] == kept


async def test_replacing_creates_what_is_not_there(client: httpx.AsyncClient) -> None:
    data = {name: value for name, value in NEW.items() if name != "id"}
    assert (await client.put("/tours/new-tour", json=data)).status_code == 201
    assert (await client.put("/tours/new-tour", json=data)).status_code == 200
    is_problem(await client.post("/tours", json=NEW), 409, "tour-exists")


async def test_every_change_is_undone_to_the_begin(client: httpx.AsyncClient) -> None:
    first = (await client.patch("/tours/lab-tour", json={"map": "a"})).json()
    assert (first["shipped"], first["can_undo"], first["can_redo"]) == (False, True, False)
    await client.patch("/tours/lab-tour", json={"map": "b"})
    await client.delete("/tours/lab-tour")
    again = answered(await client.get("/tours/lab-tour"), TourReport)
    assert again.shipped, "the program's is there again"
    assert (await client.post("/tours/lab-tour/undo")).json()["tour"]["map"] == "b"
    begin = await client.post("/tours/lab-tour/undo?to_begin=true")
    assert (begin.json()["shipped"], begin.json()["can_undo"], begin.json()["tour"]["map"]) == (True, False, "lab")
    is_problem(await client.post("/tours/lab-tour/undo"), 409, "no-other-version")
    assert (await client.post("/tours/lab-tour/redo")).json()["tour"]["map"] == "a"

    await client.post("/tours", json=NEW)
    gone = await client.post("/tours/new-tour/undo")
    assert (gone.status_code, gone.content) == (204, b"")
    assert (await client.post("/tours/new-tour/redo")).json()["tour"]["id"] == "new-tour"
    is_problem(await client.post("/tours/new-tour/redo"), 409, "no-other-version")
    is_problem(await client.post("/tours/other/undo"), 404, "no-such-tour")


async def test_the_programs_own_tour_is_not_deleted(client: httpx.AsyncClient) -> None:
    is_problem(await client.delete("/tours/lab-tour"), 409, "tour-shipped")


async def test_what_is_no_tour_is_refused_by_field(client: httpx.AsyncClient) -> None:
    await client.post("/tours", json=NEW)
    mistakes: list[tuple[dict[str, Any], str]] = [
        ({"stops": [ARM | {"plase": 1}]}, "stops.0.plase"),
        ({"stops": [ARM, ARM | {"poster": None}]}, "stops.1.id"),
        ({"pace": {"slow_m": 9}}, "pace.slow_m"),
        ({"title": {"en": 1}}, "title.en"),
    ]
    for data, field in mistakes:
        for response in (client.post("/tours", json=NEW | data), client.patch("/tours/new-tour", json=data)):
            refused = await response
            is_problem(refused, 422, "invalid-tour")
            assert fields(refused) == [field]
        verdict = answered(await client.post("/tours/validate", json=NEW | data), TourVerdict)
        assert not verdict.runs
        assert [problem.field for problem in verdict.problems] == [field]


async def test_an_id_does_not_change(client: httpx.AsyncClient) -> None:
    for change in (client.patch("/tours/lab-tour", json={"id": "x"}), client.put("/tours/lab-tour", json=NEW)):
        refused = await change
        is_problem(refused, 422, "invalid-tour")
        assert fields(refused) == ["id"]
    is_problem(await client.get("/tours/.hidden"), 422, "invalid-name")
    refused = await client.post("/tours", json=[])
    assert refused.status_code == 422


async def test_a_tour_for_which_all_is_there_runs(client: httpx.AsyncClient, system: System) -> None:
    await asyncio.to_thread(system.maps.keep, "lab", room())
    places = [Place("robotics-lab", "Robotics lab", 1.0, 2.0, 0.0)]
    await asyncio.to_thread(system.maps.keep_places, "lab", places)
    data = NEW | {"stops": [ARM | {"do": []}]}
    assert answered(await client.post("/tours/validate", json=data), TourVerdict) == TourVerdict(True, ())
    await asyncio.to_thread(system.maps.keep_places, "lab", [])
    verdict = answered(await client.post("/tours/validate", json=data), TourVerdict)
    assert [(problem.field, problem.severity) for problem in verdict.problems] == [("stops.0.place", "error")]


async def test_the_schema_is_that_of_what_is_answered(client: httpx.AsyncClient) -> None:
    schema = (await client.get("/tour-schema")).json()
    jsonschema.Draft202012Validator(schema).validate((await client.get("/tours/lab-tour")).json()["tour"])


async def test_files_are_exchanged(client: httpx.AsyncClient) -> None:
    exported = await client.get("/tours/lab-tour/file")
    assert exported.headers["content-type"].startswith("application/yaml")
    assert exported.headers["content-disposition"] == 'attachment; filename="lab-tour.yaml"'
    assert yaml.safe_load(exported.content) == yaml.safe_load(SHIPPED)

    is_problem(await client.post("/tours/import", content=exported.content), 409, "tour-exists")
    copy = exported.text.replace('"lab-tour"', '"copy"')
    imported = await client.post("/tours/import", content=copy)
    assert (imported.status_code, imported.headers["Location"]) == (201, "/api/v1/tours/copy")
    again = await client.post("/tours/import", content=copy, headers={"If-Match": imported.headers["ETag"]})
    assert (again.status_code, again.json()["tour"]) == (200, imported.json()["tour"])


async def test_a_file_that_is_no_tour_is_refused_by_line_and_field(client: httpx.AsyncClient) -> None:
    mistakes: list[tuple[bytes, str, int | None, str]] = [
        (b"\xff", "body", None, "not a text in UTF-8"),
        (b"{", "body", 1, "is not valid YAML"),
        (b"format: 1\nid: x\ntitle: 1\n", "title", 3, "the file:3: title: should be a mapping"),
        (b"a: &a [*a]", "a[0]", 1, "contains itself"),
    ]
    for content, field, line, words in mistakes:
        refused = await client.post("/tours/import", content=content)
        is_problem(refused, 422, "invalid-tour")
        assert (fields(refused), refused.json().get("line")) == ([field], line)
        assert words in refused.json()["detail"]


async def test_a_damaged_file_is_listed_and_may_be_replaced(client: httpx.AsyncClient, system: System) -> None:
    folder = system.tours.library.folder

    def damage() -> None:
        folder.mkdir()
        (folder / "lab-tour.yaml").mkdir()
        (folder / "new-tour.yaml").write_text("format: 2\n", encoding="utf-8")
        (folder / "huge.yaml").write_bytes(b"#" * (MOST_BYTES + 1))

    await asyncio.to_thread(damage)
    listed = answered(await client.get("/tours"), TourList)
    assert [each.id for each in listed.tours if each.problem] == ["huge", "new-tour"]
    refused = await client.get("/tours/new-tour")
    is_problem(refused, 409, "unreadable-tour")
    assert "new-tour.yaml:1: " in refused.json()["detail"]
    assert (await client.put("/tours/new-tour", json=NEW)).status_code == 200
    is_problem(await client.patch("/tours/lab-tour", json={"map": "x"}), 409, "disk-refuses")


async def test_posters_are_printed(client: httpx.AsyncClient) -> None:
    pdf = await client.get("/tours/lab-tour/posters.pdf?paper=letter&language=fr")
    assert pdf.headers["content-type"] == "application/pdf"
    assert pdf.content.startswith(b"%PDF-")
    one = await client.get("/tours/lab-tour/posters.pdf?stop=office")
    assert len(one.content) < len(pdf.content)
    for wrong, status, kind in (
        ("stop=kitchen", 409, "no-posters"),
        ("paper=a3", 422, "invalid-request"),
        ("language=English", 422, "invalid-request"),
    ):
        is_problem(await client.get(f"/tours/lab-tour/posters.pdf?{wrong}"), status, kind)
