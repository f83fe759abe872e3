"""Place, way, zones and maps over real sockets."""

from __future__ import annotations

import asyncio
import struct
import threading
from typing import Any

import cv2
import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from app.attention.desires import Source
from app.console import grids
from app.console.live import grid_feed
from app.console.live.hub import Hub
from app.messages import Exploitation, NavigationStatus, OccupancyGrid, TeleopCommand, Twist
from app.modules.behaviors.navigation_reporter import ARRIVED_S
from app.program.system import System
from tests.console.live_client import Page, page
from tests.console.places import grid, localization, path, status, zone, zones
from tests.patience import PATIENCE_S

#: Between the age of a command of full speed and that of one that moves nothing.
A_LITTLE_LATE_MS = 330.0
HEADER = struct.Struct("<B3xIdHH4x")


async def pictured(ann: Page, kind: str) -> tuple[dict[str, Any], NDArray[np.uint8]]:
    """The next grid: its message and, as the very next frame, its picture."""
    info = await ann.until(kind)
    frame = await ann.receive()
    assert isinstance(frame, bytes)
    number, seq, stamp, width, height = HEADER.unpack_from(frame)
    assert number == {"map_info": 3, "costmap_info": 4}[kind]
    assert (seq, stamp, width, height) == (info["seq"], info["stamp"], info["width"], info["height"])
    pixels = cv2.imdecode(np.frombuffer(frame, np.uint8, offset=24), cv2.IMREAD_UNCHANGED)
    assert pixels is not None
    assert pixels.dtype == np.uint8
    assert pixels.shape == (height, width)
    return info, pixels.astype(np.uint8)


async def answered(ann: Page) -> list[dict[str, Any] | bytes]:
    """What comes until everything sent so far has been dealt with."""
    await ann.send("ping", t=1)
    frames: list[dict[str, Any] | bytes] = []
    while True:
        frame = await ann.receive()
        if isinstance(frame, dict) and frame["type"] == "pong":
            return frames
        frames.append(frame)


async def test_a_map_is_cut_to_what_is_known_and_described_before_its_picture(url: str, system: System) -> None:
    channel = system.graph.channel("map")
    channel.publish(grid(5.0, version=7))
    async with page(url) as ann:
        await ann.send("view", map=True)
        info, pixels = await pictured(ann, "map_info")
        assert {name: info[name] for name in ("stamp", "frame", "version", "resolution_m")} == {
            "stamp": 5.0,
            "frame": "map",
            "version": 7,
            "resolution_m": 0.05,
        }
        # Of cells [10:30, 5:35] of a grid at (-1, -2).
        assert info["origin"] == [-0.75, -1.5]
        assert pixels.shape == (20, 30)
        # The one of the least x and y is at the lower left.
        assert pixels[19, 0] == 100
        assert pixels[0, 0] == pixels[19, 1] == 0


async def test_only_a_page_that_asked_gets_a_map(url: str, system: System) -> None:
    channel, costmap = system.graph.channel("map"), system.graph.channel("local_costmap")
    async with page(url) as ann, page(url, "Bob") as bob:
        assert not channel.wanted
        await ann.send("view", map=True)
        await answered(ann)
        assert channel.wanted
        assert not costmap.wanted
        channel.publish(grid(1.0))
        await pictured(ann, "map_info")
        assert not [frame for frame in await answered(bob) if isinstance(frame, bytes)]
        # A later page gets the current one.
        await bob.send("view", map=True, costmap=True)
        assert (await pictured(bob, "map_info"))[0]["seq"] == 1
        costmap.publish(grid(2.0, frame="odom"))
        assert (await pictured(bob, "costmap_info"))[0]["frame"] == "odom"
        await ann.send("view", map=False)
        await bob.send("view", map=False)
        await answered(ann)
        await answered(bob)
        assert not channel.wanted


async def test_the_next_map_waits_for_the_page_and_is_the_newest(url: str, system: System) -> None:
    channel = system.graph.channel("map")
    async with page(url) as ann, page(url, "Bob") as bob:
        for viewer in (ann, bob):
            await viewer.send("view", map=True)
            await answered(viewer)
        channel.publish(grid(1.0, version=1, corner=10))
        await pictured(ann, "map_info")
        await pictured(bob, "map_info")
        for version in (2, 3):
            channel.publish(grid(float(version), version=version, corner=10 * version))
            # Bob, who draws at once, paces no other page.
            await bob.send("ack", kind=3, seq=version)
            assert (await pictured(bob, "map_info"))[0]["version"] == version
        assert not [frame for frame in await answered(ann) if isinstance(frame, bytes)]
        await ann.send("ack", kind=3, seq=1)
        info, pixels = await pictured(ann, "map_info")
        assert (info["version"], pixels[-1, 0]) == (3, 30)


async def test_a_map_that_looks_the_same_is_not_sent_again(url: str, system: System) -> None:
    channel = system.graph.channel("map")
    async with page(url) as ann:
        await ann.send("view", map=True)
        channel.publish(grid(1.0))
        await pictured(ann, "map_info")
        await ann.send("ack", kind=3, seq=1)
        channel.publish(grid(2.0))
        await answered(ann)
        channel.publish(grid(3.0, version=2, corner=50))
        assert (await pictured(ann, "map_info"))[0]["stamp"] == 3.0


async def test_the_loop_goes_on_while_a_large_map_is_encoded(
    url: str, system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Encoding, held up here, holds up nothing else; of the maps that come meanwhile the newest is encoded next."""
    started, go_on = asyncio.Event(), threading.Event()
    loop, encoded = asyncio.get_running_loop(), []

    def slowly(whole: OccupancyGrid) -> OccupancyGrid:
        assert threading.current_thread() is not threading.main_thread()
        encoded.append(whole.version)
        loop.call_soon_threadsafe(started.set)
        assert go_on.wait(PATIENCE_S)
        return grids.known_part(whole)

    monkeypatch.setattr(grid_feed, "known_part", slowly)
    channel = system.graph.channel("map")
    async with page(url) as ann:
        await ann.send("view", map=True)
        await answered(ann)
        channel.publish(grid(1.0, size=1000, version=1))
        await started.wait()
        for version in range(2, 6):
            channel.publish(grid(float(version), size=1000, version=version, corner=version))
            await answered(ann)
        go_on.set()
        assert (await pictured(ann, "map_info"))[0]["version"] == 1
        await ann.send("ack", kind=3, seq=1)
        assert (await pictured(ann, "map_info"))[0]["version"] == 5
    assert encoded == [1, 5]


async def test_place_zones_and_way_are_sent_as_they_change(url: str, system: System) -> None:
    graph, now = system.graph, system.clock.now
    async with page(url) as ann:
        assert (await ann.until("zones"))["zones"] == []
        assert (await ann.until("navigation"))["state"] == "idle"
        graph.channel("localization").publish(localization(12.5))
        got = await ann.until("localization")
        assert got == {
            "type": "localization",
            "stamp": 12.5,
            "state": "mapping",
            "map": "lab",
            "x": 3.0,
            "y": 0.5,
            "theta": 0.0,
            "sigma": [0.03, 0.04, 0.01],
            "X_MO": {"x": 1.0, "y": 0.5, "theta": 0.0},
            "overlap": 0.875,
        }
        graph.channel("zones").publish(zones(now(), zone(), zone("door", "slow", 0.3)))
        marked = await ann.until("zones", lambda m: m["zones"])
        assert [(z["name"], z["kind"], z["speed"]) for z in marked["zones"]] == [
            ("stairs", "keep_out", 1.0),
            ("door", "slow", 0.3),
        ]
        graph.channel("path").publish(path(now(), 3))
        graph.channel("navigation").publish(status(now()))
        way = await ann.until("navigation", lambda m: m["state"] == "following")
        assert way["goal"] == {"x": 3.0, "y": 1.0, "theta": None}
        assert (way["behavior"], way["remaining_m"], way["recoveries"], way["desire"]) == (
            "PlanAndFollowPath",
            2.34,
            1,
            None,
        )
        assert way["path"] == [[0.0, 0.0], [0.2, 0.0]]
        # A path in odom is sent on the map.
        graph.channel("path").publish(path(now(), 2, frame="odom"))
        assert (await ann.until("navigation", lambda m: m["path"] != way["path"]))["path"] == [[1.0, 0.5], [1.1, 0.5]]
        graph.channel("navigation").publish(status(now(), "arrived"))
        assert (await ann.until("navigation", lambda m: m["state"] == "arrived"))["path"] == []
    async with page(url, "Bob") as bob:
        kinds: set[str] = set()
        while not {"localization", "navigation", "zones"} <= kinds:
            frame = await bob.receive()
            kinds |= {frame["type"]} if isinstance(frame, dict) else set()


async def test_a_page_that_is_a_little_late_is_sent_what_share_of_the_speed_it_is_given(url: str) -> None:
    async with page(url) as ann, asyncio.timeout(PATIENCE_S):
        await ann.greeted()
        assert (await ann.until("status"))["share"] == 1.0
        said = await ann.until("status")
        while not 0.7 < said["share"] < 0.95:  # on a busy computer it is later now and then, and given less
            await ann.send("ping", t=ann.clock() - A_LITTLE_LATE_MS)
            said = await ann.until("status")
    assert said["slowed"].endswith(f": {100 * said['share']:.0f} % of the speed.")


async def test_why_the_monitor_slowed_the_driver_is_sent(url: str, system: System) -> None:
    async with page(url) as ann:
        assert (await ann.until("status"))["limited"] == ""
        now = system.clock.now()
        system.graph.channel("exploitation").publish(
            Exploitation(now, "Teleop", Twist(now, 0.1, 0.0), "0.4 m to the obstacle ahead")
        )
        await ann.until("status", lambda s: s["limited"] == "0.4 m to the obstacle ahead")
        # What was said a while ago says nothing about now.
        await ann.until("status", lambda s: s["limited"] == "")


async def test_the_override_is_held_with_the_drive(url: str, system: System) -> None:
    commands: list[TeleopCommand] = []
    system.graph.channel("teleop_command").observe(commands.append)
    async with page(url) as ann:
        await ann.greeted()
        for seq, override in enumerate((False, True)):
            await ann.send("drive", seq=seq, held=True, linear=0.5, angular=0.0, override=override)
        await ann.send("drive", seq=2, held=False, linear=0.0, angular=0.0)
        await answered(ann)
    assert [(command.held, command.override) for command in commands[:3]] == [
        (True, False),
        (True, True),
        (False, False),
    ]


async def test_an_arrival_is_sent_though_it_is_over_at_once(url: str, system: System) -> None:
    """An arrival ends the desire, and navigation is idle within milliseconds."""
    channel, now = system.graph.channel("navigation"), system.clock.now
    async with page(url) as ann:
        arrived = status(now(), "arrived")
        channel.publish(arrived)
        channel.publish(NavigationStatus(now(), "PlanAndFollowPath", "idle", "no goal"))
        assert (await ann.until("navigation", lambda m: m["state"] == "arrived"))["stamp"] == arrived.stamp
        # Another goal takes its place; and what is long over is not sent.
        channel.publish(status(now(), "planning"))
        await ann.until("navigation", lambda m: m["state"] == "planning")
        channel.publish(status(now() - ARRIVED_S, "arrived"))
        channel.publish(NavigationStatus(now(), "PlanAndFollowPath", "idle", "no goal"))
        assert (await ann.until("navigation", lambda m: m["state"] != "planning"))["state"] == "idle"


def gave_up(system: System, x: float = 3.0) -> None:
    """As the progress supervisor notes it, when the desire is gone already."""
    goal = {"x": x, "y": 1.0, "heading": None}
    about = {"desire": "d", "arrived": False, "why": "the zone “stairs” is in the way", "goal": goal}
    system.timeline.add("goal", "GoTo", "Gave up going there", about)


async def test_a_goal_that_was_given_up_is_sent_until_the_next_one(url: str, system: System) -> None:
    async with page(url) as ann:
        assert (await ann.until("navigation"))["given_up"] is None
        gave_up(system)
        got = (await ann.until("navigation", lambda m: m["given_up"]))["given_up"]
        assert got["goal"] == {"x": 3.0, "y": 1.0, "theta": None}
        assert got["reason"] == "the zone “stairs” is in the way"
        async with page(url, "Bob") as bob:
            assert (await bob.until("navigation"))["given_up"] == got, "a later page gets it too"
        system.workspace.add("GoTo", intensity=8, utility=4, params={"x": 1, "y": 1}, source=Source("rest", "ann"))
        assert (await ann.until("navigation", lambda m: m["desire"]))["given_up"] is None


async def test_a_goal_given_up_is_not_sent_once_it_was_read(url: str, system: System, hub: Hub) -> None:
    async with page(url) as ann, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as rest:
        gave_up(system)
        await ann.until("navigation", lambda m: m["given_up"])
        assert (await rest.delete("/goal")).status_code == 204
        await ann.until("navigation", lambda m: m["given_up"] is None)


def test_an_empty_grid_is_one_unknown_cell() -> None:
    nothing = OccupancyGrid(1.0, "map", np.full((9, 9), -1, np.int8), 0.05, (3.0, 4.0), 0)
    part = grids.known_part(nothing)
    assert part.cells.tolist() == [[-1]]
    assert part.origin == (3.0, 4.0)
