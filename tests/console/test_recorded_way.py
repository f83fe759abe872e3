"""Place, way and map on a recording: as they were published then, at the place in time that is played."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import httpx
import pytest

from app.base.geometry import Pose2
from app.logs.log import Logged
from app.messages import Message
from tests.console.answers import is_problem
from tests.console.live.test_way import pictured
from tests.console.live_client import page
from tests.console.places import grid, localization, path, status, zone, zones
from tests.console.test_recorded_percepts import manifest
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_messages
from tests.logs.replay.playing import Played, prepare
from tests.patience import PATIENCE_S

SECOND = Pose2(5.0, 0.0, 0.0)


@pytest.fixture
def prepared(tmp_path: Path) -> Any:
    """Six seconds: a map at 0.2 s, another at 4 s; the robot goes somewhere from 1 s on; its place jumps at 4 s."""
    recorded: list[tuple[str, Message]] = [
        ("map", grid(BEGIN + 0.2, version=1)),
        ("map", grid(BEGIN + 4.0, version=2, corner=50)),
        ("zones", zones(BEGIN + 0.2, zone())),
        ("path", path(BEGIN + 1.0)),
        ("navigation", status(BEGIN + 1.0)),
    ]
    recorded += [
        ("localization", localization(BEGIN + 0.1 * number, Pose2() if number < 40 else SECOND)) for number in range(59)
    ]
    messages = [*lab_messages(6.0), *(Logged(message.stamp, channel, message) for channel, message in recorded)]
    return prepare(MemoryLog(sorted(messages, key=lambda logged: logged.at), manifest(tmp_path)))


async def test_what_was_known_then_is_sent_then(replay_url: str, play: Played) -> None:
    async with page(replay_url) as ann:
        hello = await ann.until("hello")
        assert hello["channels"]["map"]
        assert not hello["channels"]["costmap"]
        await ann.send("view", map=True)
        await play.playback.seek(BEGIN + 2.0)
        await ann.until("jump")
        # In whichever order they come.
        there: dict[str, Any] = {}
        while not (
            there.get("localization", {}).get("stamp", 0.0) > BEGIN + 1.8
            and there.get("navigation", {}).get("path")
            and there.get("zones", {}).get("zones")
        ):
            frame = await ann.receive()
            there |= {frame["type"]: frame} if isinstance(frame, dict) else {}
        assert (there["localization"]["x"], there["localization"]["X_MO"]["x"]) == (2.0, 0.0)
        assert there["navigation"]["state"] == "following"
        assert there["navigation"]["path"] == [[0.0, 0.0], [0.2, 0.0]]
        assert [z["name"] for z in there["zones"]["zones"]] == ["stairs"]
    async with page(replay_url) as ann:
        await ann.send("view", map=True)
        assert (await pictured(ann, "map_info"))[0]["version"] == 1
        await ann.send("ack", kind=3, seq=1)
        await play.playback.seek(BEGIN + 5.0)
        await ann.until("jump")
        # In whichever order they come.
        recorded: dict[str, Any] = {}
        while not {"map_info", "localization"} <= recorded.keys():
            frame = await ann.receive()
            recorded |= {frame["type"]: frame} if isinstance(frame, dict) else {}
        assert recorded["map_info"]["version"] == 2
        assert recorded["localization"]["x"] == 7.0
        # Before anything was known, nothing is.
        await ann.send("ack", kind=3, seq=2)
        await play.playback.seek(BEGIN + 0.05)
        await ann.until("jump")
        assert (await ann.until("zones"))["zones"] == []
        assert (await ann.until("navigation"))["state"] == "idle"


async def test_a_page_that_asks_for_the_map_while_time_goes_on_gets_it(replay_url: str, play: Played) -> None:
    """It was published once, seconds ago, before any page asked."""
    play.playback.play()
    await play.clock.sleep_until(BEGIN + 1.0)
    async with page(replay_url) as ann:
        await ann.send("view", map=True)
        info, _ = await pictured(ann, "map_info")
        assert info["version"] == 1
        assert play.clock.now() < BEGIN + 4.0


async def test_a_recording_is_sent_nowhere(replay_url: str, play: Played) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{replay_url}/api/v1") as rest:
        is_problem(await rest.put("/goal", json={"x": 1, "y": 1}), 409, "a-recording")
        assert (await rest.get("/goal")).status_code == 200
