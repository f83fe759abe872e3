"""The console on a recording, really served: its transport, what follows it, what goes on while it is paused."""

from __future__ import annotations

import asyncio
import math
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from app.console.app import create_app
from app.logs.mcap.reader import McapLog
from app.messages import LaserScan, Odometry
from app.program.system import System
from tests.console.live_client import Page, page
from tests.console.program import build, served, write_page
from tests.logs.replay.logs import BEGIN, MemoryLog, damage, lab_log, lab_manifest, lab_messages, write_log
from tests.logs.replay.playing import Played, played, prepare
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
END = BEGIN + 5.98


@pytest.fixture
def prepared() -> Any:
    """Six seconds of the lab."""
    return prepare(lab_log(6.0))


@pytest.fixture
async def rest(replay_url: str) -> AsyncIterator[httpx.AsyncClient]:
    """REST."""
    async with httpx.AsyncClient(base_url=f"{replay_url}/api/v1", timeout=PATIENCE_S) as client:
        yield client


async def patch(rest: httpx.AsyncClient, **change: Any) -> dict[str, Any]:
    answer = await rest.patch("/playback", json=change)
    assert answer.status_code == 200, answer.text
    state: dict[str, Any] = answer.json()
    return state


async def test_a_page_gets_the_state_of_the_playback(replay_url: str, rest: httpx.AsyncClient) -> None:
    async with page(replay_url) as ann:
        hello = await ann.until("hello")
        state = (await rest.get("/playback")).json()
        assert state == {
            "file": "memory.mcap", "begin": BEGIN, "end": END, "position": BEGIN,
            "speed": 1.0, "playing": False, "phase": "paused", "problem": None,
        }  # fmt: skip
        assert hello["playback"] == state
        assert hello["robot"]["replayed"]
        assert hello["stamp"] == BEGIN
        served = {cls["name"] for cls in hello["classes"] if cls["served"]}
        assert "FindQRCodes" in served
        assert "Record" not in served, "no Recorder runs in a replay"
        assert await ann.until("playback") == {"type": "playback", **state}


async def test_it_plays_and_pauses_and_the_page_goes_on(replay_url: str, rest: httpx.AsyncClient) -> None:
    async with page(replay_url) as ann:
        await patch(rest, playing=True)
        first = await ann.until("playback", lambda m: m["playing"])
        await ann.until("playback", lambda m: m["position"] > first["position"] + 0.2)
        state = await patch(rest, playing=False)
        assert state["phase"] == "paused"
        await ann.until("playback", lambda m: m["phase"] == "paused")
        statuses: list[dict[str, Any]] = []
        while len(statuses) < 20:
            frame = await ann.until("status")
            if frame["stamp"] == state["position"]:
                statuses.append(frame)
        # All of one moment, and the guard has not fallen silent.
        assert statuses[-1]["guard"]["state"] == "driving"
        assert {source["channel"]: source["state"] for source in statuses[-1]["sources"]}["odometry"] == "live"
        await ann.send("ping", t=7, rtt_ms=None)
        assert (await ann.until("pong"))["stamp"] == state["position"]
        assert (await ann.until("lanes"))["stamp"] == state["position"]
        assert (await rest.get("/playback")).json()["position"] == state["position"]


async def test_speed_and_end(replay_url: str, rest: httpx.AsyncClient) -> None:
    async with page(replay_url) as ann:
        await patch(rest, playing=True, speed=20)
        ended = await ann.until("playback", lambda m: m["phase"] == "ended")
        assert (ended["position"], ended["playing"], ended["speed"]) == (END, False, 20)
        assert (await patch(rest, speed=None))["speed"] is None
        state = await patch(rest, playing=True)
        assert state["playing"]
        assert (await ann.until("jump"))["stamp"] == BEGIN
        await ann.until("playback", lambda m: m["phase"] == "ended")


async def after_jump(ann: Page, stamp: float) -> dict[str, list[dict[str, Any]]]:
    """What came from the jump to ``stamp`` on, by type, until there are lanes, landmarks and a status of it."""
    await ann.until("jump", lambda m: m["stamp"] == stamp)
    found: dict[str, list[dict[str, Any]]] = {}
    async with asyncio.timeout(PATIENCE_S):
        while not (
            {"lanes", "lanes_history", "desires", "intention"} <= found.keys()
            and any(m["landmarks"] for m in found.get("landmarks", []))
            and any(m["odometry"] for m in found.get("status", []))
        ):
            frame = await ann.receive()
            if isinstance(frame, dict):
                found.setdefault(frame["type"], []).append(frame)
    return found


async def test_lanes_landmarks_and_pose_follow_a_seek_forth_and_back(replay_url: str, rest: httpx.AsyncClient) -> None:
    async with page(replay_url) as ann:
        await patch(rest, playing=True, speed=20)
        await ann.until("playback", lambda m: m["position"] > BEGIN + 3)
        for position, classes in ((BEGIN + 2.5, {"script", "ada"}), (BEGIN + 0.4, set()), (BEGIN + 4.0, {"script"})):
            now, found = await asyncio.gather(patch(rest, playing=False, position=position), after_jump(ann, position))
            assert (now["position"], now["phase"]) == (position, "paused")
            # Nothing of another time came after the jump.
            for kind in ("lanes", "status"):
                assert {frame["stamp"] for frame in found[kind]} == {position}, kind
            assert all(stamp <= position for frame in found["lanes_history"] for stamp in frame["stamps"])
            assert all(event["stamp"] == position for frame in found.get("events", []) for event in frame["events"])
            pose = found["status"][-1]["odometry"]
            assert pose["x"] == pytest.approx(0.1 * (position - BEGIN), abs=0.01)
            (landmark,) = found["landmarks"][-1]["landmarks"]
            assert position - 0.2 < landmark["last_seen"] <= position
            sources = {desire["source"]["name"] for desire in found["desires"][-1]["desires"]}
            assert sources - {"ScenarioCoordinator", "console"} == classes
            rows = {row["class"]: row for row in found["lanes"][-1]["rows"]}
            assert rows["FindQRCodes"]["utility"] == (8.0 if "script" in classes else 1.0)


async def test_a_page_that_comes_while_it_is_paused_sees_the_scene(replay_url: str, rest: httpx.AsyncClient) -> None:
    await patch(rest, position=BEGIN + 1.5)
    async with page(replay_url) as ann:
        assert len(await ann.picture()) > 500
        status = await ann.until("status", lambda m: m["odometry"] is not None)
        assert status["stamp"] == BEGIN + 1.5
    async with page(replay_url, "Bob") as bob:
        assert len(await bob.picture()) > 500, "and so does the next"


async def test_steps(replay_url: str, rest: httpx.AsyncClient) -> None:
    async with page(replay_url) as ann:
        await patch(rest, position=BEGIN + 4.0)
        positions = [(await rest.post("/playback/step")).json()["position"] for _ in range(3)]
        assert positions == pytest.approx([BEGIN + 4.027, BEGIN + 4.127, BEGIN + 4.227], abs=1e-5)
        state = await ann.until("playback", lambda m: m["position"] == positions[-1])
        assert state["phase"] == "paused"
        assert (await ann.until("status", lambda m: m["stamp"] == positions[-1]))["odometry"]["x"] > 0.42


async def test_dragging_is_answered_once_it_is_there(replay_url: str, rest: httpx.AsyncClient) -> None:
    async with page(replay_url) as ann:
        answers = await asyncio.gather(*(patch(rest, position=BEGIN + i / 10) for i in range(1, 40)))
        assert {answer["position"] for answer in answers} == {BEGIN + 3.9}
        assert (await rest.get("/playback")).json()["position"] == BEGIN + 3.9
        await ann.until("jump", lambda m: m["stamp"] == BEGIN + 3.9)


async def test_a_recording_is_never_driven_or_stopped(replay_url: str, rest: httpx.AsyncClient, play: Played) -> None:
    commands = play.replay.system.graph.channels["teleop_command"]
    before = commands.published
    async with page(replay_url) as ann:
        for kind, content in (
            ("drive", {"seq": 1, "held": True, "linear": 0.5, "angular": 0.0}),
            ("take_control", {}),
            ("e_stop", {}),
            ("clear_e_stop", {}),
        ):
            await ann.send(kind, **content)
        notice = await ann.until("notice")
        assert (notice["level"], notice["text"]) == (
            "warning",
            "This is a recording: there is no robot to drive or to stop.",
        )
        await ann.send("ping", t=1, rtt_ms=None)
        while (frame := await ann.receive()) and not (isinstance(frame, dict) and frame["type"] == "pong"):
            assert not isinstance(frame, dict) or frame["type"] != "notice", "said once"
        assert (await ann.until("status"))["driver"] is None
    for answer in (await rest.post("/stop"), await rest.delete("/stop")):
        assert answer.status_code == 409
        assert answer.json()["type"] == "urn:hbba:problem:a-recording"
    assert commands.published == before
    assert (await rest.get("/robot")).json()["robot"]["replayed"]
    assert (await rest.get("/health")).json()["status"] == "ok"


@pytest.mark.parametrize(
    "change", [{"speed": 0}, {"speed": 21}, {"speed": "fast"}, {"position": "here"}, {"pace": 1}, {"playing": "yes"}]
)
async def test_what_cannot_be_is_refused(rest: httpx.AsyncClient, change: dict[str, Any]) -> None:
    answer = await rest.patch("/playback", json=change)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"] == next(iter(change))
    assert (await rest.get("/playback")).json()["speed"] == 1.0


async def test_what_is_damaged_is_said(rest: httpx.AsyncClient, prepared: Any) -> None:
    prepared[0]._damaged_at = BEGIN + 2.0
    answer = await rest.patch("/playback", json={"position": BEGIN + 3.0})
    assert answer.status_code == 409
    assert answer.json()["type"] == "urn:hbba:problem:unreadable-recording"
    assert "hbba log repair" in answer.json()["detail"]


async def test_what_is_played_is_not_deleted_under_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path))

    def prepared() -> Any:
        for name in ("tour", "other"):
            write_log(tmp_path / f"{name}.mcap", lab_messages(1.0), lab_manifest())
        return prepare(McapLog(tmp_path / "tour.mcap")), McapLog(tmp_path / "tour.mcap")

    recording, past = await asyncio.to_thread(prepared)
    async with played(recording, past=past) as play:
        static = await asyncio.to_thread(write_page, tmp_path)
        app = create_app(play.replay.system, static_dir=static, early_view=False, playback=play.playback)
        async with (
            served(app) as replay_url,
            httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{replay_url}/api/v1") as rest,
        ):
            refused = await rest.delete("/recordings/tour")
            assert refused.status_code == 409
            assert refused.json()["type"] == "urn:hbba:problem:recording-replayed"
            assert "end the replay first" in refused.json()["detail"]
            assert (await rest.delete("/recordings/other")).status_code == 204
    for log in (recording[0], past):
        log.close()


async def test_a_recording_without_pictures_or_a_robots_name_says_so(tmp_path: Path) -> None:
    scans = MemoryLog([logged for logged in lab_messages(2.0) if isinstance(logged.message, Odometry | LaserScan)])
    recording = await asyncio.to_thread(prepare, scans)
    async with played(recording) as play:
        static = await asyncio.to_thread(write_page, tmp_path)
        app = create_app(play.replay.system, static_dir=static, early_view=False, playback=play.playback)
        async with served(app) as replay_url, page(replay_url) as ann:
            hello = await ann.until("hello")
    # What comes of scans and odometry alone is made here.
    pictures = {"camera": False, "panorama": False, "map": True, "costmap": True}
    assert hello["channels"] == pictures | {"scan": True, "point_cloud": False}
    assert hello["drive"] is False
    assert hello["audio"] == {"listen": False, "speak": False}
    assert hello["robot"]["name"] == "memory.mcap (memory)"


async def test_a_damaged_part_is_reported_and_everything_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "hurt.mcap"

    def prepared() -> tuple[Any, McapLog, float]:
        write_log(path, lab_messages(6.0), lab_manifest())
        begin, _ = damage(path, BEGIN + 3.0)
        return prepare(McapLog(path)), McapLog(path), begin

    recording, past, begin = await asyncio.to_thread(prepared)
    async with played(recording, past=past) as play:
        static = await asyncio.to_thread(write_page, tmp_path)
        app = create_app(play.replay.system, static_dir=static, early_view=False, playback=play.playback)
        async with (
            served(app) as replay_url,
            page(replay_url) as ann,
            httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{replay_url}/api/v1") as rest,
        ):
            await patch(rest, speed=10.0, playing=True)
            state = await ann.until("playback", lambda m: m["problem"] is not None)
            assert re.fullmatch(r"\d\.\d s from 0:0\d\.\d cannot be read", state["problem"])
            assert (state["phase"], state["playing"]) == ("paused", False)
            assert (await rest.get("/playback")).json()["problem"] == state["problem"]
            for position in (begin + 0.01, BEGIN + 1.0, begin + 0.01, BEGIN + 5.0):
                await patch(rest, position=position)
            assert (await patch(rest, playing=True))["problem"] is None
            await ann.until("playback", lambda m: m["phase"] == "ended")
    for log in (recording[0], past):
        log.close()


async def test_every_example_of_the_document_works(replay_url: str) -> None:
    text = await asyncio.to_thread((DOCS / "rest.md").read_text, "utf-8")
    script = "\n".join(re.findall(r"```bash\n(.*?)```", text, re.DOTALL))
    assert script.count("/playback") >= 5
    process = await asyncio.create_subprocess_exec(
        "sh",
        "-euc",
        f"HBBA={replay_url}/api/v1\n{script}",
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    out, err = await process.communicate()
    assert process.returncode == 0, err.decode()
    assert b'"phase":"paused"' in out


async def test_every_field_is_described(replay_url: str, rest: httpx.AsyncClient) -> None:
    text = await asyncio.to_thread((DOCS / "live-stream.md").read_text, "utf-8")
    section = text.split("## On a recording\n")[1].split("\n## ")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", section, flags=re.MULTILINE))
    async with page(replay_url) as ann:
        asked = asyncio.create_task(patch(rest, position=BEGIN + 1))
        frames = await asyncio.gather(ann.until("playback"), ann.until("jump"))
        await asked
    for frame in frames:
        assert set(frame) - {"type"} <= set(re.findall(r"\w+", rows[frame["type"]]))
    assert rows.keys() == {"playback", "jump"}


@pytest.fixture
def robot(tmp_path: Path) -> System:
    """A program with a running robot."""
    return build(tmp_path)[0]


async def test_a_robot_has_no_transport(robot: System, tmp_path: Path) -> None:
    static = await asyncio.to_thread(write_page, tmp_path / "page")
    async with (
        robot,
        served(create_app(robot, static_dir=static, early_view=False)) as url,
        page(url) as ann,
    ):
        hello = await ann.until("hello")
        assert hello["playback"] is None
        assert not hello["robot"]["replayed"]
        async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
            for answer in (
                await client.get("/playback"),
                await client.patch("/playback", json={"playing": True}),
                await client.post("/playback/step"),
            ):
                assert answer.status_code == 404
                assert answer.json()["type"] == "urn:hbba:problem:not-a-replay"


async def test_a_viewer_changes_no_intention(play: Played, replay_url: str) -> None:
    """One more desire would make other intentions than the robot had: the pictures come past attention."""
    system = play.replay.system
    before = system.translator.current
    closed = system.graph.filters.divisors()
    assert closed["CameraStream.images"] == math.inf
    async with page(replay_url) as ann:
        await ann.until("lanes")
        assert system.graph.filters.divisors()["CameraStream.images"] == 1
        assert system.graph.filters.divisors()["PointCloudBuilder.images"] == 1
        assert not [d for d in system.workspace.desires() if d.cls == "Telepresence"]
        assert system.translator.current is before
        await play.playback.seek(BEGIN + 1.5)  # where it was desired
        assert {d.cls for d in system.workspace.desires()} >= {"Telepresence"}
    await until_closed(system)
    current = system.translator.current
    assert current is not None
    assert system.graph.filters.divisors()["CameraStream.images"] == current.divisors["CameraStream.images"]


async def until_closed(system: System) -> None:
    """Until no viewer opens filters past attention any more."""
    async with asyncio.timeout(PATIENCE_S):
        while system.graph.filters.pinned():  # noqa: ASYNC110  # nothing in the program reports a connection's end
            await asyncio.sleep(0)
