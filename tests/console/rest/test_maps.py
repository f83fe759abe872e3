"""Maps over REST: kept, taken into use, renamed and deleted; the robot placed, zones drawn; and every refusal."""

from __future__ import annotations

import asyncio
from typing import Any

import cv2
import httpx
import numpy as np
import pytest

from app.base.geometry import Pose2
from app.console.records.maps import KeptMap, MapList
from app.maps.library import MapLibrary
from app.maps.map_service import Files
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.places import FakeMapServer, localization, zone, zones

ZONE: dict[str, Any] = {"name": "a", "kind": "slow", "polygon": [[0, 0], [2, 0], [2, 1]], "speed": 0.5}


@pytest.fixture
def server(system: System) -> FakeMapServer:
    """The module that keeps the map."""
    server = FakeMapServer(system.maps)
    system.map.attach(server)
    return server


async def test_a_map_from_keeping_to_deletion(client: httpx.AsyncClient, system: System, server: FakeMapServer) -> None:
    system.graph.channel("localization").publish(localization(system.clock.now()))
    saved = await client.put("/maps/lab")
    assert saved.status_code == 200, saved.text
    facts = answered(saved, KeptMap)
    assert facts.in_use
    assert facts.known_m2 == pytest.approx(20 * 30 * 0.05**2)
    assert facts.problem is None
    listed = answered(await client.get("/maps"), MapList)
    assert listed.maps == (facts,)
    assert (listed.current.name, listed.current.state) == ("lab", "mapping")

    is_problem(await client.delete("/maps/lab"), 409, "map-in-use")
    assert (await client.post("/map/begin")).json()["name"] == ""
    renamed = await client.patch("/maps/lab", json={"name": "ground-floor"})
    assert (renamed.json()["name"], renamed.json()["in_use"]) == ("ground-floor", False)

    loaded = await client.post("/maps/ground-floor/load")
    assert loaded.json()["name"] == "ground-floor"
    await client.post("/maps/ground-floor/load", json={"pose": {"x": 1, "y": 2.5, "theta": -1}, "extend": True})
    assert server.asked[-2:] == [
        ("load", "ground-floor", None, False),
        ("load", "ground-floor", Pose2(1, 2.5, -1), True),
    ]
    # The one in use keeps its maker's knowledge of it, under its new name.
    assert (await client.patch("/maps/ground-floor", json={"name": "first"})).json()["in_use"]
    assert [m["name"] for m in (await client.get("/maps")).json()["maps"]] == ["first"]
    assert (await client.patch("/maps/first", json={"name": "first"})).status_code == 200
    await client.post("/map/begin")
    assert (await client.delete("/maps/first")).status_code == 204
    assert (await client.get("/maps")).json()["maps"] == []


async def test_saving_twice_is_as_saving_once(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    first, second = await client.put("/maps/lab"), await client.put("/maps/lab")
    assert first.json() | {"saved": 0} == second.json() | {"saved": 0}


class BusyMapServer(FakeMapServer):
    """One thing at a time, in the order asked; loading takes until ``loaded``."""

    def __init__(self, library: MapLibrary) -> None:
        super().__init__(library)
        self.loads, self.loaded = asyncio.Event(), asyncio.Event()
        self._one = asyncio.Lock()

    async def save(self, name: str, others: Files | None = None) -> None:
        async with self._one:
            await super().save(name, others)

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        async with self._one:
            self.loads.set()
            await self.loaded.wait()
            await super().load(name, X_MB, extend)


@pytest.mark.parametrize("what", ["rename", "delete"])
async def test_what_comes_while_another_map_is_being_loaded_is_of_the_map_in_use_then(
    what: str, client: httpx.AsyncClient, system: System
) -> None:
    server = BusyMapServer(system.maps)
    system.map.attach(server)
    for name in ("other", "lab"):
        await client.put(f"/maps/{name}")
    load = asyncio.create_task(client.post("/maps/other/load"))
    await server.loads.wait()
    change = asyncio.create_task(
        client.patch("/maps/lab", json={"name": "office"}) if what == "rename" else client.delete("/maps/other")
    )
    # As long as looking for names on the disk takes, it is let go on.
    for _ in range(3):
        await client.get("/maps/other/picture")
    server.loaded.set()
    await load
    if what == "rename":
        assert (await change).json()["name"] == "office"
        assert (await client.get("/map")).json()["name"] == "other"
        assert ("save", "office") not in server.asked, "the other map would be kept under that name"
    else:
        is_problem(await change, 409, "map-in-use")


async def test_a_map_is_shown_as_people_draw_maps(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    await client.put("/maps/lab")
    picture = await client.get("/maps/lab/picture")
    assert picture.headers["content-type"] == "image/png"
    pixels = cv2.imdecode(np.frombuffer(picture.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert pixels is not None
    assert pixels.shape == (40, 40)
    assert (pixels[39 - 10, 5], pixels[39 - 11, 6], pixels[0, 0]) == (0, 254, 205)


async def test_the_robot_is_placed_and_sought(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    assert (await client.put("/map/pose", json={"x": 1, "y": -2, "theta": 0.5})).status_code == 200
    assert (await client.post("/map/search")).status_code == 200
    assert (await client.get("/map")).json()["available"]
    assert server.asked == [("place", Pose2(1, -2, 0.5)), ("search",)]


async def test_zones_are_drawn_as_a_whole(client: httpx.AsyncClient, system: System, server: FakeMapServer) -> None:
    assert (await client.get("/map/zones")).json() == {"zones": []}
    answer = await client.put("/map/zones", json={"zones": [ZONE, ZONE | {"name": "b", "kind": "keep_out"}]})
    assert answer.status_code == 200, answer.text
    assert answer.json()["zones"][0] == ZONE
    assert server.asked == [("mark", "a", "b")]
    system.graph.channel("zones").publish(zones(system.clock.now(), zone("ramp", "slow", 0.25)))
    listed = (await client.get("/map/zones")).json()
    assert listed["zones"] == [
        {"name": "ramp", "kind": "slow", "polygon": [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]], "speed": 0.25}
    ]
    # What was read can be written back.
    assert (await client.put("/map/zones", json=listed)).json() == listed
    assert (await client.put("/map/zones", json={"zones": []})).json() == {"zones": []}


BAD_ZONES: list[tuple[dict[str, Any], str]] = [
    ({"kind": "fast"}, "zones.1.kind"),
    ({"name": ""}, "zones.1.name"),
    ({"name": "a"}, "zones.1.name"),
    ({"speed": 0}, "zones.1.speed"),
    ({"speed": 1.5}, "zones.1.speed"),
    ({"speed": "1"}, "zones.1.speed"),
    ({"polygon": [[0, 0], [1, 1]]}, "zones.1.polygon"),
    ({"polygon": [[0, 0], [1, 1], [2, 2, 2]]}, "zones.1.polygon.2"),
    ({"polygon": [[0, 0], [1, 1], [2, 1e6]]}, "zones.1.polygon.2.1"),
    ({"polygon": [[0, 0], [1, 0], [2, 0]]}, "zones.1.polygon"),
    ({"polygon": [[0, 0], [1, 1], [1, 0], [0, 1]]}, "zones.1.polygon"),
    ({"colour": "red"}, "zones.1.colour"),
]


async def test_a_zone_that_cannot_be_is_refused_by_name(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    for change, field in BAD_ZONES:
        refused = await client.put("/map/zones", json={"zones": [ZONE, ZONE | {"name": "b"} | change]})
        document = is_problem(refused, 422, "invalid-request")
        assert "Value error" not in refused.text, "a library's words"
        assert document["errors"][0]["field"] == field
        assert document["errors"][0]["message"]
    assert server.asked == []


async def test_a_map_that_is_not_there_is_refused_with_those_that_are(
    client: httpx.AsyncClient, server: FakeMapServer
) -> None:
    await client.put("/maps/lab")
    for method, path, body in (
        ("POST", "/maps/attic/load", None),
        ("PATCH", "/maps/attic", {"name": "roof"}),
        ("DELETE", "/maps/attic", None),
        ("GET", "/maps/attic/picture", None),
    ):
        document = is_problem(await client.request(method, path, json=body), 404, "no-such-map")
        assert "lab" in document["detail"]


async def test_a_name_that_is_taken_or_cannot_be_is_refused(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    await client.put("/maps/one")
    await client.put("/maps/two")
    for name in ("one", "two"):
        other = {"one": "two", "two": "one"}[name]
        document = is_problem(await client.patch(f"/maps/{name}", json={"name": other}), 409, "map-exists")
        assert other in document["detail"]
    document = is_problem(await client.patch("/maps/one", json={"name": "../one"}), 422, "invalid-name")
    assert document["errors"][0]["field"] == "name"
    document = is_problem(await client.put("/maps/.hidden"), 422, "invalid-name")
    assert document["errors"][0]["field"] == "path.name"


async def test_who_keeps_no_maps_says_so(client: httpx.AsyncClient) -> None:
    listed = (await client.get("/maps")).json()
    assert listed["current"] == {"available": False, "name": "", "state": None, "stamp": None}
    for method, path, body in (
        ("PUT", "/maps/lab", None),
        ("POST", "/map/begin", None),
        ("POST", "/map/search", None),
        ("PUT", "/map/pose", {"x": 0, "y": 0, "theta": 0}),
        ("PUT", "/map/zones", {"zones": []}),
    ):
        document = is_problem(await client.request(method, path, json=body), 409, "map-unavailable")
        assert "makes no maps" in document["detail"]


async def test_the_map_servers_refusal_keeps_its_words(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    await client.put("/maps/lab")
    server.refusal = "there is nothing on the map yet: drive a little"
    for method, path in (("PUT", "/maps/lab"), ("POST", "/maps/lab/load"), ("POST", "/map/search")):
        document = is_problem(await client.request(method, path), 409, "map-unavailable")
        assert document["detail"] == f"{server.refusal}."


async def test_a_pose_that_cannot_be_is_refused(client: httpx.AsyncClient, server: FakeMapServer) -> None:
    for pose in ({"x": 0, "y": 0}, {"x": "0", "y": 0, "theta": 0}, {"x": 2e3, "y": 0, "theta": 0}):
        is_problem(await client.put("/map/pose", json=pose), 422, "invalid-request")
    assert server.asked == []


async def test_a_damaged_map_says_what_its_problem_is(
    client: httpx.AsyncClient, system: System, server: FakeMapServer
) -> None:
    await client.put("/maps/lab")
    await asyncio.to_thread((system.maps.path("lab") / "map.yaml").write_text, "image: [")
    listed = (await client.get("/maps")).json()["maps"]
    assert listed[0]["problem"]
    document = is_problem(await client.get("/maps/lab/picture"), 409, "unreadable-map")
    assert "map.yaml" in document["detail"]
