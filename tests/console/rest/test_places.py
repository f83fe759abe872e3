"""Places over REST: made, renamed, moved and deleted by several people at once; and goals by their names."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest

from app.base.geometry import Pose2
from app.console.records.places import PlaceList, PlaceReport
from app.messages import Landmark, Landmarks, Odometry, Place
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.places import FakeMapServer, grid, localization, zone, zones

DOCK: dict[str, Any] = {"name": "Dock", "pose": {"x": 0.2, "y": -1, "heading": 1.5}}


@pytest.fixture
async def server(system: System) -> FakeMapServer:
    """The module that keeps the map: one without a name is in use."""
    server = FakeMapServer(system.maps)
    system.map.attach(server)
    await system.map.resume("", same=False)
    return server


def see(system: System, *posters: tuple[str, tuple[float, float], float | None], frame: str = "map") -> None:
    """Publish landmarks: text, place and heading of each."""
    now = system.clock.now()
    found = tuple(
        Landmark(text, (*at, 1.4), 0.03, 5, now, now, heading=heading, heading_sigma=0.1, id=number + 1)
        for number, (text, at, heading) in enumerate(posters)
    )
    system.graph.channel("landmarks").publish(Landmarks(now, found, frame))


async def until(system: System, holds: Callable[[tuple[Place, ...]], bool]) -> None:
    """Until the published places are as wanted."""
    channel = system.graph.channel("places")
    messages = channel.subscribe("test")
    if channel.latest is None or not holds(channel.latest.places):
        async for message in messages:
            if holds(message.places):
                break
    messages.close()


async def listed(client: httpx.AsyncClient) -> tuple[PlaceReport, ...]:
    return answered(await client.get("/places"), PlaceList).places


async def test_a_place_from_its_making_to_its_end(
    client: httpx.AsyncClient, system: System, server: FakeMapServer
) -> None:
    assert await listed(client) == ()
    made = await client.post("/places", json=DOCK)
    assert made.status_code == 201, made.text
    dock = answered(made, PlaceReport)
    assert (dock.id, dock.name, dock.source, dock.problem) == ("dock", "Dock", "hand", "")
    assert (dock.x, dock.y, dock.heading) == (0.2, -1, 1.5)
    assert made.headers["Location"] == "/api/v1/places/dock"
    assert made.headers["ETag"] == dock.etag
    assert await listed(client) == (dock,)

    renamed = await client.patch("/places/dock", json={"name": "Charger"}, headers={"If-Match": dock.etag})
    charger = answered(renamed, PlaceReport)
    assert (charger.id, charger.name, charger.x) == ("dock", "Charger", 0.2)
    moved = answered(await client.patch("/places/dock", json={"pose": DOCK["pose"] | {"heading": 4}}), PlaceReport)
    assert moved.heading == pytest.approx(4 - math.tau, abs=1e-4)
    assert answered(await client.get("/places/dock"), PlaceReport) == moved

    created = await client.put("/places/window", json=DOCK | {"name": "Window"})
    assert created.status_code == 201
    replaced = await client.put("/places/window", json={"pose": {"x": 0, "y": -1, "heading": 0}})
    assert (replaced.status_code, replaced.json()["name"], replaced.json()["heading"]) == (200, "Window", 0)
    # They go with the map.
    await client.put("/maps/lab")
    assert [place.id for place in await asyncio.to_thread(system.maps.places, "lab")] == ["dock", "window"]
    assert (await client.delete("/places/dock")).status_code == 204
    assert [place.id for place in await asyncio.to_thread(system.maps.places, "lab")] == ["window"]
    is_problem(await client.get("/places/dock"), 404, "no-such-place")


async def test_of_two_editors_the_second_overwrites_nothing(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    first = await client.post("/places", json=DOCK)
    tag = {"If-Match": first.headers["ETag"]}
    ann = await client.patch("/places/dock", json={"name": "Ann's"}, headers=tag)
    for request in (
        client.patch("/places/dock", json={"name": "Bob's"}, headers=tag),
        client.put("/places/dock", json=DOCK, headers=tag),
        client.delete("/places/dock", headers=tag),
    ):
        refused = await request
        is_problem(refused, 412, "changed-meanwhile")
        assert refused.headers["ETag"] == ann.headers["ETag"]
    assert [place.name for place in await listed(client)] == ["Ann's"]
    assert (await client.delete("/places/dock", headers={"If-Match": ann.headers["ETag"]})).status_code == 204
    is_problem(await client.put("/places/dock", json=DOCK, headers=tag), 412, "changed-meanwhile")
    assert await listed(client) == ()
    is_problem(await client.put("/places/dock", json=DOCK, headers={"If-Match": "dock"}), 412, "changed-meanwhile")


async def test_here_is_where_the_robot_is_now(client: httpx.AsyncClient, system: System, server: FakeMapServer) -> None:
    is_problem(await client.post("/places", json={"here": True}), 409, "pose-unknown")
    now = system.clock.now()
    system.graph.channel("localization").publish(localization(now, state="lost"))
    lost = is_problem(await client.post("/places", json={"here": True}), 409, "pose-unknown")
    assert "it is lost" in lost["detail"]
    # X_MB = X_MO @ X_OB, with odometry of after the scan.
    system.graph.channel("localization").publish(localization(now, Pose2(1.0, 0.5, math.pi / 2)))
    odometry = Odometry(now + 0.1, Pose2(2.0, 1.01, 0.25), 0.0, 0.0)
    system.graph.channel("odometry").publish(odometry)
    here = answered(await client.post("/places", json={"here": True}), PlaceReport)
    assert (here.id, here.name, here.source) == ("place", "Place", "here")
    assert (here.x, here.y, here.heading) == pytest.approx((-0.01, 2.5, math.pi / 2 + 0.25), abs=1e-4)
    second = answered(await client.post("/places", json={"here": True}), PlaceReport)
    assert (second.id, second.name) == ("place-2", "Place 2")
    # SLAM rests: odometry alone is trusted for a metre.
    system.graph.channel("localization").publish(localization(now - 60, Pose2(0.0, 0.0, 0.0)))
    driven = is_problem(await client.post("/places", json={"here": True}), 409, "pose-unknown")
    assert "has driven 1.0 m since SLAM" in driven["detail"]
    system.graph.channel("odometry").publish(Odometry(now + 0.2, Pose2(2.0, 0.9, 0.0), 0.0, 0.0))
    assert answered(await client.post("/places", json={"here": True}), PlaceReport).y == pytest.approx(0.9)


async def test_in_front_of_a_poster_until_it_is_moved_by_hand(
    client: httpx.AsyncClient, system: System, server: FakeMapServer
) -> None:
    gone = Place("gone", "Gone", 0.0, 0.0, 0.0, "poster", "gone", 9)
    await system.places.server.edit(lambda _: (gone,))
    see(system, ("tour:lab", (1.0, 2.0), 0.0), ("tour:lab", (5.0, 2.0), math.pi), ("door", (1, 1), None))
    await until(system, lambda places: "its poster is not known" in places[0].problem)
    await client.delete("/places/gone")
    made = await client.post("/places", json={"poster": {"text": "tour:lab", "near": [4.9, 2.2]}})
    place = answered(made, PlaceReport)
    assert (place.id, place.name, place.source) == ("tour-lab", "tour:lab", "poster")
    assert (place.poster, place.landmark) == ("tour:lab", 2)
    assert (place.x, place.y, place.heading) == pytest.approx((3.8, 2.0, 0.0), abs=1e-4)
    # The map is corrected: the place moves, and is the version that it was.
    see(system, ("tour:lab", (1.0, 2.0), 0.0), ("tour:lab", (5.5, 2.0), math.pi), ("door", (1, 1), None))
    await until(system, lambda places: places[0].x != place.x)
    moved = (await listed(client))[0]
    assert (moved.x, moved.etag) == (pytest.approx(4.3), place.etag)
    named = await client.patch("/places/tour-lab", json={"name": "Lab"}, headers={"If-Match": place.etag})
    assert answered(named, PlaceReport).source == "poster"
    by_hand = answered(await client.patch("/places/tour-lab", json={"pose": DOCK["pose"]}), PlaceReport)
    assert (by_hand.source, by_hand.poster, by_hand.landmark) == ("hand", "", 0)

    unknown = is_problem(await client.post("/places", json={"poster": {"text": "tour:lob"}}), 409, "no-such-poster")
    assert "did you mean 'tour:lab'? there are: 'tour:lab', 'door'" in unknown["detail"]
    facing = await client.post("/places", json={"poster": {"text": "door"}})
    assert "which way 'door' faces" in is_problem(facing, 409, "poster-heading-unknown")["detail"]


#: Bodies, and the fields that are wrong.
WRONG: tuple[tuple[dict[str, Any], list[str]], ...] = (
    ({"name": "a"}, ["pose"]),
    ({"name": "a", "here": True, "pose": DOCK["pose"]}, ["pose", "here"]),
    ({"name": "", "pose": DOCK["pose"]}, ["name"]),
    ({"name": "x" * 61, "pose": DOCK["pose"]}, ["name"]),
    ({"name": "a\tb", "pose": DOCK["pose"]}, ["name"]),
    ({"id": "Dock", "pose": DOCK["pose"]}, ["id"]),
    ({"pose": {"x": 2000, "y": 0, "heading": 0}}, ["pose.x"]),
    ({"pose": {"x": 0, "y": 0, "theta": 0}}, ["pose.heading", "pose.theta"]),
    ({"poster": {"text": "a", "near": [1]}}, ["poster.near"]),
    ({"pose": DOCK["pose"], "nmae": "a"}, ["nmae"]),
)


async def test_what_is_wrong_is_said_by_field(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    for body, fields in WRONG:
        refused = is_problem(await client.post("/places", json=body), 422, "invalid-request")
        assert sorted(error["field"] for error in refused["errors"]) == sorted(fields), body
    assert await listed(client) == ()


async def test_ids_and_names_are_each_of_one_place(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    await client.post("/places", json=DOCK)
    same_name = is_problem(await client.post("/places", json=DOCK), 409, "place-exists")
    assert same_name["errors"][0]["field"] == "name"
    same_id = is_problem(await client.post("/places", json=DOCK | {"name": "b", "id": "dock"}), 409, "place-exists")
    assert same_id["errors"][0]["field"] == "id"
    await client.post("/places", json=DOCK | {"name": "b"})
    is_problem(await client.patch("/places/b", json={"name": "Dock"}), 409, "place-exists")
    is_problem(await client.patch("/places/b", json={"name": None}), 422, "invalid-request")
    is_problem(await client.patch("/places/c", json={"name": "c"}), 404, "no-such-place")
    assert (await client.patch("/places/dock", json={"name": "Dock"})).status_code == 200


async def test_without_a_map_in_use_none_can_be_made(client: httpx.AsyncClient) -> None:
    assert await listed(client) == ()
    refused = is_problem(await client.post("/places", json=DOCK), 409, "map-unavailable")
    assert "no map in use" in refused["detail"]


async def test_a_goal_by_name(client: httpx.AsyncClient, system: System, server: FakeMapServer) -> None:
    await client.post("/places", json=DOCK)
    goal = (await client.put("/goal", json={"place": "dock", "speed": 0.5})).json()
    wanted = {"x": 0.2, "y": -1, "heading": 1.5, "place": "dock", "name": "Dock", "speed": 0.5}
    assert {name: goal["params"][name] for name in wanted} == wanted
    (event,) = system.timeline.query(kinds=["desire"], limit=1)
    assert event.text.startswith("REST client desires GoTo 'Dock'")
    desire = await client.post(
        "/desires",
        json={"class": "GoTo", "intensity": 4, "utility": 1, "params": {"place": "dock", "tolerance_m": 0.1}},
    )
    assert (desire.json()["params"]["x"], desire.json()["params"]["tolerance_m"]) == (0.2, 0.1)
    # Its parameters can be given back as they are, wherever the place is by now.
    await client.patch("/places/dock", json={"pose": {"x": 0.4, "y": -1, "heading": 0}})
    same = await client.patch(f"/desires/{desire.json()['id']}", json={"params": desire.json()["params"]})
    assert same.json()["params"]["x"] == 0.2
    again = await client.patch(f"/desires/{desire.json()['id']}", json={"params": {"place": "dock"}})
    assert again.json()["params"]["x"] == 0.4


async def test_a_goal_that_is_no_place_is_refused(
    client: httpx.AsyncClient, system: System, server: FakeMapServer
) -> None:
    await client.post("/places", json=DOCK)
    for request, field in (
        (client.put("/goal", json={"place": "doc"}), "place"),
        (
            client.post("/desires", json={"class": "GoTo", "intensity": 4, "utility": 1, "params": {"place": "doc"}}),
            "params.place",
        ),
    ):
        refused = is_problem(await request, 422, "no-such-place")
        assert refused["errors"][0]["field"] == field
        assert "'doc'; did you mean 'dock'? there are: dock" in refused["detail"]
    both = is_problem(await client.put("/goal", json={"place": "dock", "x": 1}), 422, "invalid-request")
    assert [error["field"] for error in both["errors"]] == ["x"]
    half = is_problem(await client.put("/goal", json={"x": 1}), 422, "invalid-request")
    assert [error["field"] for error in half["errors"]] == ["y"]
    assert not [desire for desire in system.workspace.desires() if desire.cls == "GoTo"]


async def test_a_place_where_the_robot_cannot_stand_is_no_goal(
    client: httpx.AsyncClient, system: System, server: FakeMapServer
) -> None:
    await client.post("/places", json={"name": "Stairs", "pose": {"x": 1.5, "y": 0.3, "heading": 0}})
    await client.post("/places", json=DOCK)
    now = system.clock.now()
    system.graph.channel("zones").publish(zones(now, zone("lift", "slow"), zone("stairs")))
    refused = is_problem(await client.put("/goal", json={"place": "stairs"}), 409, "place-obstructed")
    assert refused["detail"] == "The robot cannot stand at Stairs: it is in the keep-out zone stairs."
    assert (await client.put("/goal", json={"place": "dock"})).status_code == 200
    cells = np.full_like(grid(now).cells, 100)
    system.graph.channel("map").publish(type(grid(now))(now, "map", cells, 0.05, (-1.0, -2.0), 2))
    is_problem(await client.put("/goal", json={"place": "dock"}), 409, "place-obstructed")
    # A problem is on the list, too.
    await until(system, lambda places: places[0].problem != "")
    assert [place.problem for place in await listed(client)] == ["it is in the keep-out zone stairs", ""]


async def test_there_are_only_so_many(client: httpx.AsyncClient, system: System, server: FakeMapServer) -> None:
    many = [Place(f"p{number}", f"P {number}", 0.0, 0.0, 0.0) for number in range(500)]
    await system.places.server.edit(lambda _: many)
    is_problem(await client.post("/places", json=DOCK), 409, "too-many-places")
    is_problem(await client.put("/places/dock", json=DOCK), 409, "too-many-places")
    assert (await client.put("/places/p1", json=DOCK)).status_code == 200
