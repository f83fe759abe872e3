"""The live stream, over real sockets."""

from __future__ import annotations

import asyncio
import re
import struct
from typing import Any

import av
import httpx

from app.attention.desires import Source
from app.base.geometry import Pose2, Pose3
from app.console.live.feeds import MOST_VIDEOS
from app.console.live.hub import Hub
from app.console.live.outbox import MOST_ITEMS
from app.console.live.picture_budget import PictureBudget
from app.console.live.protocol import PICTURE_HEADER
from app.messages import EncodedImage, Exploitation, Landmark, Landmarks, Odometry, TeleopCommand, Twist
from app.program.system import System
from tests.console.live_client import page
from tests.console.program import Body, image
from tests.patience import PATIENCE_S


async def test_a_new_page_gets_hello_first_and_then_the_whole_state(url: str, system: System) -> None:
    async with page(url) as ann:
        hello = await ann.receive()
        assert isinstance(hello, dict)
        assert hello["type"] == "hello"
        assert hello["protocol"] == 1
        assert hello["robot"]["limits"]["linear_mps"] == 0.4
        assert [cls["name"] for cls in hello["classes"]] == list(system.classes)
        assert hello["classes"][0]["schema"]["type"] == "object"
        pictures = {"camera": True, "panorama": True, "map": True, "costmap": True}
        assert hello["channels"] == pictures | {"scan": True, "point_cloud": True}
        assert hello["drive"] is True
        assert hello["audio"] == {"listen": True, "speak": True}
        kinds = {"desires", "intention", "landmarks", "lanes", "lanes_history", "load", "perceived", "status"}
        came: list[str] = []
        while kinds - set(came):
            frame = await ann.receive()
            came += [frame["type"]] if isinstance(frame, dict) else []
        assert came.index("lanes_history") < came.index("lanes")
        assert came.count("lanes_history") == 1


async def test_a_reloaded_page_gets_the_past_of_the_lanes(url: str, system: System) -> None:
    """A desire comes and goes while the page is not there; each reload gets the past."""

    async def reloaded() -> list[dict[str, Any]]:
        async with page(url) as ann:
            history = await ann.until("lanes_history")
        spells: list[dict[str, Any]] = next(row["spells"] for row in history["rows"] if row["class"] == "FindQRCodes")
        return spells

    async with asyncio.timeout(PATIENCE_S):
        desire = system.workspace.add("FindQRCodes", intensity=8, utility=2, source=Source("rest", "Ann"))
        while (await reloaded())[-1]["intensity"] != 8:
            pass
        system.workspace.remove(desire.id)
        while (spells := await reloaded())[-1]["intensity"] is not None:
            pass
    assert [spell["intensity"] for spell in spells][-2:] == [8, None]
    assert spells[-1]["state"] == "undesired"
    assert spells[-2]["text"]


async def test_status_and_lanes_come_with_growing_numbers(url: str, system: System, body: Body) -> None:
    async with page(url) as ann:
        body.emit_status(system.clock.now())
        body.emit("odometry", Odometry(system.clock.now(), Pose2(1.0, 2.0, 0.5), 0.1, -0.2, 0.3))
        first = await ann.until("status", lambda s: s["odometry"] is not None)
        second = await ann.until("status")
        assert second["seq"] > first["seq"]
        assert second["stamp"] > first["stamp"]
        assert first["guard"]["state"] == "idle"
        moves = {"linear_mps": 0.1, "angular_radps": -0.2, "lateral_mps": 0.3}
        assert first["odometry"] == {"x": 1.0, "y": 2.0, "theta": 0.5} | moves
        assert first["driver"] is None
        sources: dict[str, Any] = {}
        while sources.get("odometry", {}).get("state") != "live":
            body.emit("odometry", Odometry(system.clock.now(), Pose2(1.0, 2.0, 0.5), 0.1, -0.2, 0.3))
            sources = {source["channel"]: source for source in (await ann.until("status"))["sources"]}
        assert sources["odometry"]["expected_hz"] == 100
        assert sources["scan"]["state"] == "closed"
        lanes = await ann.until("lanes")
        assert [row["class"] for row in lanes["rows"]] == list(system.classes)


async def test_a_desire_moves_its_lane(url: str, system: System, body: Body) -> None:
    async with page(url) as ann, httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as rest:
        # A page that watches makes the robot desire Telepresence.
        row = await lane(ann, "Telepresence", "fulfilled")
        assert (row["intensity"], row["utility"], row["divisor"]) == (4, 1, 1)
        assert row["divisors"] == {"CameraStream.images": 1, "PointCloudBuilder.images": 3}
        await rest.patch("/resources/cpu", json={"capacity": 15})
        assert (await lane(ann, "Telepresence", "degraded", divisor=4))["rate"] is None
        for _ in range(31):
            body.emit("kinect", image(system.clock.now()))
            await asyncio.sleep(0)
        measured = await lane(ann, "Telepresence", "degraded", measured=True)
        assert 0 < measured["rate"] < 0.3
        teleoperation = await lane(ann, "Teleoperation", "undesired")
        assert teleoperation["intensity"] is None
        assert teleoperation["divisor"] is None
        assert teleoperation["rate"] == 0
        desire = {"class": "Teleoperation", "intensity": 8, "utility": 8}
        await rest.post("/desires", json=desire)
        desires = await ann.until("desires", lambda d: len(d["desires"]) == 2)
        assert {d["class"] for d in desires["desires"]} == {"Telepresence", "Teleoperation"}
        refused = await lane(ann, "Teleoperation", "unfulfilled")
        assert refused["text"]


async def lane(ann, cls, state, *, divisor=None, measured=False):  # type: ignore[no-untyped-def]
    """The next row of ``cls`` in ``state``."""

    def find(message):  # type: ignore[no-untyped-def]
        return next(row for row in message["rows"] if row["class"] == cls)

    def holds(message):  # type: ignore[no-untyped-def]
        row = find(message)
        return (
            row["state"] == state
            and (divisor is None or row["divisor"] == divisor)
            and (not measured or row["rate"] is not None)
        )

    return find(await ann.until("lanes", holds))


async def test_events_come_in_order_and_once(url: str, system: System) -> None:
    async with page(url) as ann:
        await ann.until("lanes")
        before = system.timeline.statistics().added
        for number in range(50):
            system.timeline.add("module", "Nothing", f"event {number}")
        got: list[int] = []
        while len(got) < 50:
            frame = await ann.until("events")
            got += [event["id"] for event in frame["events"] if event["subject"] == "Nothing"]
        assert got == list(range(before + 1, before + 51))


async def test_landmarks_and_exploitation_are_sent(url: str, system: System) -> None:
    async with page(url) as ann:
        await ann.until("landmarks", lambda m: m["landmarks"] == [])
        now = system.clock.now()
        door = Landmark("door A", (1, 2, 1.4), 0.03, 5, 1, last_seen=2, heading=3.0, heading_sigma=0.05, id=7)
        system.graph.channel("landmarks").publish(Landmarks(now, (door,), "map"))
        landmarks = await ann.until("landmarks", lambda m: bool(m["landmarks"]))
        assert landmarks["landmarks"][0] == {
            "text": "door A", "x": 1, "y": 2, "z": 1.4, "sigma_m": 0.03, "sightings": 5,
            "first_seen": 1, "last_seen": 2, "heading": 3.0, "heading_sigma": 0.05, "id": 7, "frame": "map",
        }  # fmt: skip
        system.graph.channel("exploitation").publish(Exploitation(system.clock.now(), "Teleop", Twist(now, 0.1, 0.0)))
        await ann.until("status", lambda s: s["exploited"] == "Teleop")
        await ann.until("status", lambda s: s["exploited"] is None)


async def test_a_ping_comes_back(url: str) -> None:
    async with page(url) as ann:
        await ann.send("ping", t=12.5, rtt_ms=None)
        pong = await ann.until("pong")
        assert pong["t"] == 12.5
        assert pong["stamp"] > 0


async def test_one_picture_is_under_way_at_a_time_and_it_is_the_newest(url: str, system: System, body: Body) -> None:
    async with page(url) as ann:
        await lane(ann, "Telepresence", "fulfilled")
        first = await shown(ann, system, body)
        kind, sequence, stamp, width, height = struct.unpack("<B3xIdHH4x", first[:24])
        assert (kind, width, height) == (1, 64, 48)
        assert first[24:26] == b"\xff\xd8"
        pictures = system.graph.channel("camera_jpeg")
        before = pictures.statistics().published
        while (published := pictures.statistics().published) < before + 3:
            body.emit("kinect", image(system.clock.now()))
            frame = await ann.receive()
            assert not isinstance(frame, bytes), "a picture came though the last was not acknowledged"
        await ann.send("ack", kind=1, seq=sequence)
        newer = struct.unpack("<B3xIdHH4x", (await ann.picture())[:24])
        assert newer[1] >= sequence + published - before
        assert newer[2] > stamp


async def test_a_page_that_decodes_vp9_gets_it_where_its_link_is_short(
    url: str, system: System, body: Body, hub: Hub
) -> None:
    async with page(url) as ann:
        hello = await ann.until("hello")
        assert hello["vp9"]
        await lane(ann, "Telepresence", "fulfilled")
        (viewer,) = hub.viewers
        viewer.budgets[1] = PictureBudget(rung=1, try_jpeg_after_s=1e9)
        await ann.send("view", camera=True, vp9=True)
        decoder = av.VideoCodecContext.create("vp9", "r")
        codings: list[int] = []
        while codings[-2:] != [2, 2]:
            frame = await shown(ann, system, body)
            _, coding, seq, stamp, width, height = PICTURE_HEADER.unpack_from(frame)
            if coding:
                (picture,) = decoder.decode(av.Packet(frame[24:]))
                assert (picture.width, picture.height) == (width, height) == (64, 48)
                assert 0 <= system.clock.now() - stamp < PATIENCE_S
            codings.append(coding)
            await ann.send("ack", kind=1, seq=seq)
        assert next(coding for coding in codings if coding) == 1
        # Its decoder has failed: from then on JPEGs come.
        await ann.send("view", camera=True, vp9=False)
        while PICTURE_HEADER.unpack_from(frame := await shown(ann, system, body))[1]:
            await ann.send("ack", kind=1, seq=PICTURE_HEADER.unpack_from(frame)[2])
        assert frame[24:26] == b"\xff\xd8"


async def test_no_more_pages_get_video_than_a_computer_bears(hub: Hub, body: Body, system: System) -> None:
    viewers = [hub.join(f"page {number}") for number in range(MOST_VIDEOS + 2)]
    for viewer in viewers:
        viewer.vp9, viewer.budgets[1] = True, PictureBudget(rung=2)
        hub.show(viewer, 1, True)
    hub._feeds._on_picture(1, EncodedImage(1.0, "camera", b"no JPEG", 640, 480, Pose3.identity()))
    assert len(hub._feeds._videos) == MOST_VIDEOS
    forms = [hub._feeds._form(viewer, 1) for viewer in viewers]
    assert [form.bits is None for form in forms] == [False] * MOST_VIDEOS + [True] * 2
    hub.leave(viewers[0])
    assert len(hub._feeds._videos) == MOST_VIDEOS - 1
    assert hub._feeds._form(viewers[-1], 1).bits is not None
    for viewer in viewers[1:]:
        hub.leave(viewer)
    assert not hub._feeds._videos


async def shown(ann, system, body) -> bytes:  # type: ignore[no-untyped-def]
    """The first picture that comes while the camera runs."""

    async def run_camera() -> None:
        while True:
            body.emit("kinect", image(system.clock.now()))
            await system.clock.sleep(0.02)

    camera = asyncio.create_task(run_camera())
    try:
        return await ann.picture()
    finally:
        camera.cancel()


async def test_pictures_are_made_only_while_a_page_shows_them(url: str, system: System) -> None:
    channel = system.graph.channel("camera_jpeg")
    assert not channel.wanted
    async with page(url) as ann:
        await ann.until("hello")
        assert channel.wanted
        await ann.send("view", camera=False)
        await ann.send("ping", t=1)
        await ann.until("pong")
        assert not channel.wanted


async def test_the_robot_desires_telepresence_while_watched(url: str, system: System) -> None:
    assert system.workspace.desires() == ()
    async with page(url) as ann:
        await ann.until("hello")
        (desire,) = system.workspace.desires()
        assert (desire.cls, desire.intensity, desire.utility) == ("Telepresence", 4, 1)
        assert desire.source == Source("operator", "console")
    gone = asyncio.Event()
    system.workspace.observe(lambda change: gone.set() if change.removed else None)
    async with page(url) as bob:
        await bob.until("hello")
        assert system.workspace.desires() == (desire,)
    async with asyncio.timeout(PATIENCE_S):
        await gone.wait()


# --- Driving --------------------------------------------------------------------------------------------------------


class Wheel:
    """The drive commands that the console publishes, with the time."""

    def __init__(self, system: System) -> None:
        self._subscription = system.graph.channel("teleop_command").subscribe("test", capacity=100)

    async def next(self) -> TeleopCommand:
        async with asyncio.timeout(PATIENCE_S):
            message: TeleopCommand = await self._subscription.receive()
        return message


async def test_a_held_key_drives_and_its_release_stops(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with page(url, "Ann") as ann:
        await ann.drive(1.0, -0.5)
        drive = await wheel.next()
        assert (drive.operator, drive.held, drive.linear, drive.angular) == ("Ann", True, 1.0, -0.5)
        status = await ann.until("status", lambda s: s["driver"] is not None)
        assert status["driver"] == {"operator": "Ann", "mine": True, "holds": True}
        await ann.drive(0.0, held=False)
        stop = await wheel.next()
        assert (stop.held, stop.linear, stop.angular) == (False, 0.0, 0.0)
        assert stop.sequence == drive.sequence + 1
        # She keeps the wheel for a while, but drives no more, as `status` says within two beats.
        after = await ann.until("status", lambda s: not s["driver"]["holds"])
        assert after["driver"] == {"operator": "Ann", "mine": True, "holds": False}
        assert after["stamp"] - stop.stamp < 0.5


async def test_a_connection_that_ends_stops_within_100_ms(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with page(url) as ann:
        await ann.drive(1.0)
        assert (await wheel.next()).held
        began = system.clock.now()
        # As a closed tab or a killed browser does it: no farewell.
        ann.connection.transport.abort()
        stop = await wheel.next()
        assert not stop.held
        assert system.clock.now() - began < 0.1


async def test_commands_that_cease_stop_within_250_ms(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with page(url) as ann:
        await ann.drive(1.0)
        began = (await wheel.next()).stamp
        stop = await wheel.next()
        assert not stop.held
        assert stop.stamp - began < 0.25


async def test_another_page_is_refused_until_it_takes_control(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with page(url, "Ann") as ann, page(url, "Bob") as bob:
        await ann.drive(1.0)
        await wheel.next()
        await bob.drive(-1.0)
        notice = await bob.until("notice")
        assert notice["level"] == "warning"
        assert "Ann" in notice["text"]
        await bob.until("status", lambda s: s["driver"] == {"operator": "Ann", "mine": False, "holds": True})
        await bob.drive(0, held=False)
        await bob.send("take_control")
        assert not (await wheel.next()).held
        assert "Bob" in (await ann.until("notice"))["text"]
        await bob.drive(-1.0)
        drive = await wheel.next()
        assert (drive.operator, drive.linear) == ("Bob", -1.0)
        await ann.until("status", lambda s: s["driver"] == {"operator": "Bob", "mine": False, "holds": True})


async def test_the_emergency_stop_refuses_driving_and_says_so_once(url: str, system: System, body: Body) -> None:
    wheel = Wheel(system)
    async with page(url) as ann:
        await ann.drive(1.0)
        assert (await wheel.next()).held
        await ann.send("e_stop")
        assert not (await wheel.next()).held
        assert body.stops == ["pressed by Ann"]
        body.emit_status(system.clock.now())
        await ann.until("notice")
        await ann.until("status", lambda s: s["guard"]["e_stopped"])
        await ann.drive(1.0)
        await ann.until("status")
        await ann.send("clear_e_stop")
        await ann.send("ping", t=1)
        await ann.until("pong")
        assert not body.e_stopped
        body.emit_status(system.clock.now())
        await ann.drive(0, held=False)
        await ann.drive(0.5)
        assert (await wheel.next()).linear == 0.5


async def test_a_command_without_its_time_drives_nothing_and_a_notice_says_why(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with page(url) as ann:
        await ann.greeted()
        for missing in ("t", "heard", "heard_t"):
            await ann.send("drive", seq=1, held=True, linear=1.0, angular=0, **{missing: None})
            notice = await ann.until("notice")
            assert notice["text"].startswith("A command without t, heard and heard_t")
            await ann.send("drive", seq=2, held=False, linear=0, angular=0)
        await ann.drive(0.5)
        assert (await wheel.next()).linear == 0.5


async def test_pages_and_programs_learn_how_late_their_commands_are(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with (
        page(url) as ann,
        page(url, "Bob") as bob,
        httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as rest,
    ):
        await ann.greeted()
        late = 3000.0
        status = {"waits": ""}
        while not status["waits"]:
            await ann.send("drive", t=ann.clock() - late, seq=1, held=True, linear=1.0, angular=0)
            status = await ann.until("status")
        assert re.fullmatch(r"Commands arrive up to 3\.\d s late: driving waits\.", status["waits"])
        assert (await bob.until("status"))["waits"] == ""
        pages = {one["operator"]: one for one in (await rest.get("/viewers")).json()["pages"]}
        assert pages["Ann"]["late_ms"] >= late
        assert pages["Ann"]["waits"]
        assert (pages["Bob"]["late_ms"], pages["Bob"]["waits"]) == (None, "")
        # What came late neither drove nor took the wheel.
        await bob.drive(0.25)
        assert (await wheel.next()).linear == 0.25


async def test_a_page_turns_the_head_by_its_hold_and_by_a_click_on_a_picture(
    url: str, system: System, body: Body
) -> None:
    heads: asyncio.Queue[tuple[bool, float, float]] = asyncio.Queue()
    channel = system.graph.channel("teleop_command")
    channel.observe(lambda command: heads.put_nowait((command.held, command.pan, command.tilt)))
    async with page(url) as ann:
        await ann.greeted()
        await ann.send("drive", seq=1, held=False, linear=0, angular=0, head_held=True, pan=1.0, tilt=-0.5)
        assert await heads.get() == (False, 1.0, -0.5)
        await ann.send("drive", seq=2, held=False, linear=0, angular=0)
        assert await heads.get() == (False, 0.0, 0.0)
        now = system.clock.now()
        for stamp in (now, now + 0.01):
            body.emit("odometry", Odometry(stamp, Pose2(), 0.0, 0.0))
        body.emit("kinect", image(now))
        await ann.send("look", stamp=now + 1, u=0.5, v=0.5)
        assert (await ann.until("notice"))["text"].startswith("That picture is too old")
        await ann.send("look", stamp=now, u=0.5, v=0.5)
        await ann.until("desires", lambda m: any(d["class"] == "LookAt" for d in m["desires"]))


async def test_what_is_no_command_is_refused_and_stops(url: str, system: System) -> None:
    wheel = Wheel(system)
    async with page(url) as ann:
        await ann.drive(1.0)
        await wheel.next()
        await ann.send("drive", seq=2, held=True, linear=None, angular=0)
        assert not (await wheel.next()).held
        assert (await ann.until("notice"))["level"] == "error"
        await ann.send("fly")
        await ann.until("notice")


# --- Slow viewers ---------------------------------------------------------------------------------------------------


async def test_a_viewer_that_does_not_read_delays_no_other(url: str, system: System, hub: Hub) -> None:
    """Its sockets full, frames are replaced, not queued, and others are served meanwhile."""
    async with page(url, "slow", max_queue=1) as slow, page(url, "fast") as fast:
        await slow.until("hello")
        await slow.stop_reading()
        viewer = next(viewer for viewer in hub.viewers if viewer.operator == "slow")
        long = "x" * 50_000
        number = 0
        while viewer.outbox.statistics().replaced < 40:
            system.timeline.add("module", "Nothing", f"{number} {long}")
            await fast.until("events", lambda f: any(e["text"].startswith(f"{number} ") for e in f["events"]))  # noqa: B023
            number += 1
        for _ in range(MOST_ITEMS + 1):
            system.timeline.add("module", "Nothing", "one too many")
        await fast.until("status")
        second = await fast.until("status")
        assert viewer.outbox.statistics().items <= MOST_ITEMS
        assert viewer.outbox.statistics().waiting <= 8
        slow.begin_reading()
        await slow.until("notice", lambda n: "missed" in n["text"])
        await slow.until("status", lambda s: s["stamp"] >= second["stamp"])
        # So that it ends in good order.
        await fast.until("status")


async def test_desires_say_whether_a_behavior_serves_them_just_now(url: str, system: System) -> None:
    async with page(url) as ann:
        desire = system.workspace.add("Teleoperation", intensity=8, utility=1, source=Source("rest", "Ann"))
        system.workspace.add("Listen", intensity=8, utility=1, source=Source("rest", "Ann"))
        await system.translator.settled()
        await ann.until("desires", lambda m: len(m["desires"]) >= 2 and m["exploited"] == [])
        now = system.clock.now()
        system.graph.channel("exploitation").publish(Exploitation(now, "Teleop", Twist(now, 0.1, 0.0)))
        await ann.until("desires", lambda m: m["exploited"] == [desire.id])
        await ann.until("desires", lambda m: m["exploited"] == [])
        events = system.timeline.query(kinds=["exploitation"])
        assert [(event.text, event.data["classes"]) for event in events] == [
            ("Teleop drives", ["Teleoperation"]),
            ("Teleop drives no more", ["Teleoperation"]),
        ]
