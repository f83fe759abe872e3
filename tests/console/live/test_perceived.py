"""People on the live stream: seen, heard, and spoken to."""

from __future__ import annotations

import asyncio
import struct

import httpx
import pytest

from app.base.geometry import Pose2
from app.console.live.feeds import SOUND_CHANNEL
from app.console.live.hub import Hub
from app.console.live.outbox import MOST_SOUND
from app.messages import LoudNoise, Odometry
from app.program.system import System
from tests.console.live_client import page, voice
from tests.console.percepts import faces, panorama, sound_source, sound_sources
from tests.console.program import Body, sound
from tests.patience import PATIENCE_S


async def test_faces_sounds_and_noises_are_sent_as_they_change(url: str, system: System, body: Body) -> None:
    async with page(url) as ann:
        first = await ann.until("perceived")
        assert (first["faces"], first["sounds"], first["noises"]) == ([], [], [])
        now = system.clock.now()
        body.emit("odometry", Odometry(now - 0.05, Pose2(1.0, 0.0, 0.0), 0.0, 0.0))
        body.emit("odometry", Odometry(now + 0.05, Pose2(1.0, 0.0, 0.0), 0.0, 0.0))
        await ann.until("status", lambda m: m["odometry"] is not None)
        system.graph.channel("faces").publish(faces(now, (2.0, 0.5, 1.6)))
        system.graph.channel("sound_sources").publish(sound_sources(now, sound_source(7, 0.3)))
        system.graph.channel("loud_noises").publish(LoudNoise(now, 40.0, -9.0))
        sent = await ann.until("perceived", lambda m: m["faces"] and m["sounds"] and m["noises"])
        (face,), (heard,), (noise,) = sent["faces"], sent["sounds"], sent["noises"]
        assert (face["track"], face["x"], face["y"], face["z"]) == (1, 3.0, 0.5, 1.6)
        assert (heard["track"], heard["azimuth"], heard["active"]) == (7, 0.3, True)
        assert noise == {"stamp": now, "ratio": 40.0, "level_db": -9.0}
        silent = await ann.until("perceived", lambda m: m["sounds"] and not m["sounds"][0]["active"])
        assert silent["sounds"][0]["last_active"] == now
        await ann.until("perceived", lambda m: not m["faces"])
        last = await ann.until("perceived", lambda m: not (m["sounds"] or m["noises"]))
        assert last["faces"] == []


async def test_what_does_not_change_is_not_sent_again_and_never_more_than_ten_times_a_second(
    url: str, system: System
) -> None:
    async with page(url) as ann:
        await ann.until("perceived")
        beats, sent = 0, 0
        while beats < 20:
            system.graph.channel("faces").publish(faces(system.clock.now()))
            frame = await ann.receive()
            if isinstance(frame, dict):
                beats += frame["type"] == "status"
                sent += frame["type"] == "perceived"
        assert 5 <= sent <= 11
        await ann.until("perceived", lambda m: not m["faces"])
        while beats < 30:
            frame = await ann.receive()
            assert not isinstance(frame, dict) or frame["type"] != "perceived"
            beats += isinstance(frame, dict) and frame["type"] == "status"


async def test_perceptions_are_wanted_while_a_page_watches(url: str, system: System) -> None:
    channels = [system.graph.channel(name) for name in ("faces", "sound_sources", "loud_noises")]
    assert not any(channel.wanted for channel in channels)
    async with page(url) as ann:
        await ann.until("perceived")
        assert all(channel.wanted for channel in channels)


async def test_the_panorama_comes_to_the_page_that_shows_it_at_its_own_pace(url: str, system: System) -> None:
    channel = system.graph.channel("panorama_jpeg")
    async with page(url) as ann:
        await ann.until("status")
        assert not channel.wanted
        await ann.send("view", panorama=True)
        await until(lambda: channel.wanted)
        channel.publish(panorama(5.0))
        frame = await ann.picture()
        assert struct.unpack_from("<B3xIdHH4x", frame) == (2, 1, 5.0, 640, 320)
        assert frame[24:] == panorama(5.0).jpeg
        for stamp in (6.0, 7.0):
            channel.publish(panorama(stamp))
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        await ann.send("ack", kind=1, seq=1)
        await ann.send("ping", t=1)
        await ann.until("pong")
        await ann.send("ack", kind=2, seq=1)
        assert struct.unpack_from("<B3xIdHH4x", await ann.picture()) == (2, 3, 7.0, 640, 320)
        await ann.send("view", panorama=False)
        await until(lambda: not channel.wanted)


async def until(holds) -> None:  # type: ignore[no-untyped-def]
    """Nothing in the program reports the effect of a page's message: poll for it."""
    async with asyncio.timeout(PATIENCE_S):
        while not holds():  # noqa: ASYNC110
            await asyncio.sleep(0)


async def test_one_click_lets_a_page_hear_the_robot(url: str, system: System, body: Body) -> None:
    channel = system.graph.channel(SOUND_CHANNEL)
    async with page(url) as ann, page(url, "Ben") as ben:
        await ann.until("status")
        assert not channel.wanted
        assert not [desire for desire in system.workspace.desires() if desire.cls == "Listen"]
        assert not system.graph.channel("microphones").wanted
        await ann.send("listen", on=True)
        await until(lambda: channel.wanted and system.graph.channel("microphones").wanted)
        (desire,) = [desire for desire in system.workspace.desires() if desire.cls == "Listen"]
        assert (desire.intensity, desire.utility, desire.source.name) == (4, 1, "console")
        for number in range(8):
            body.emit("microphones", sound(50.0 + number * 512 / 48_000, number * 512))
            await asyncio.sleep(0)
        heard = [await ann.sound() for _ in range(4)]
        assert [seq for seq, *_ in heard] == [1, 2, 3, 4]
        assert [stamp for _, stamp, *_ in heard] == [50.0 + 2 * n * 512 / 48_000 for n in range(4)]
        assert {rate for _, _, rate, _ in heard} == {48_000}
        samples = heard[0][3]
        assert len(samples) == 1024
        assert (samples == round(1001 * 10 ** (12 / 20))).all(), "microphone 1, 12 dB louder"
        await ann.send("listen", on=False)
        await until(lambda: not channel.wanted)
        await ben.send("ping", t=1)
        while not isinstance(frame := await ben.receive(), dict) or frame["type"] != "pong":
            assert isinstance(frame, dict), "who does not listen hears nothing"


async def test_a_slow_listener_loses_sound_and_learns_how_much(url: str, system: System, hub: Hub) -> None:
    channel = system.graph.channel(SOUND_CHANNEL)
    async with page(url, "slow", max_queue=1) as slow, page(url, "fast") as fast:
        for ann in (slow, fast):
            await ann.send("listen", on=True)
        viewer = next(viewer for viewer in hub.viewers if viewer.operator == "slow")
        await until(lambda: channel.wanted and all(viewer.listens for viewer in hub.viewers))
        await slow.stop_reading()
        long = "x" * 50_000
        while viewer.outbox.statistics().replaced < 20:
            system.timeline.add("module", "Nothing", long)
            await fast.until("events")
        for number in range(40):
            channel.publish(sound(number / 50, 960 * number, samples=960))
            assert (await fast.sound())[0] == number + 1
        slow.begin_reading()
        seqs = [(await slow.sound())[0] for _ in range(MOST_SOUND)]
        assert seqs == list(range(41 - MOST_SOUND, 41))


async def test_a_listener_that_goes_is_not_listened_for(url: str, system: System) -> None:
    """A page that is reloaded finds the desire still there; after 2 s it is withdrawn, and the microphones rest."""
    channel = system.graph.channel(SOUND_CHANNEL)
    async with page(url) as ann:
        await ann.send("listen", on=True)
        await until(lambda: system.graph.channel("microphones").wanted)
    await until(lambda: not channel.wanted)
    assert [desire for desire in system.workspace.desires() if desire.cls == "Listen"]
    await until(lambda: not [desire for desire in system.workspace.desires() if desire.cls == "Listen"])
    await until(lambda: not system.graph.channel("microphones").wanted)


async def test_a_page_that_cannot_hear_gets_a_notice(url: str, system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(system.graph.producers, SOUND_CHANNEL)
    async with page(url) as ann:
        assert not (await ann.until("hello"))["audio"]["listen"]
        await ann.send("listen", on=True)
        assert "nothing to listen to" in (await ann.until("notice"))["text"]
        assert not [desire for desire in system.workspace.desires() if desire.cls == "Listen"]


async def test_what_is_said_into_a_page_is_played_by_the_robot(url: str, system: System, body: Body, hub: Hub) -> None:
    async with page(url) as ann, page(url, "Ben") as ben:
        for number in range(1, 4):
            await ann.connection.send(voice(number))
        mine = await ann.until("status", lambda m: m["speaker"] is not None)
        assert mine["speaker"] == {"operator": "Ann", "mine": True}
        theirs = await ben.until("status", lambda m: m["speaker"] is not None)
        assert theirs["speaker"] == {"operator": "Ann", "mine": False}
        assert [audio.first_sample for audio in body.played] == [0, 320, 640]
        assert (body.played[0].samples == 500).all()
        assert abs(body.played[0].stamp - system.clock.now()) < 5
        await ann.connection.send(voice(4))
        await ben.connection.send(voice(1))
        assert "in use by Ann" in (await ben.until("notice"))["text"]
        await ann.connection.send(voice(5, samples=0))
        await ben.until("status", lambda m: m["speaker"] is None)
    assert hub.speech.speaker is None


async def test_malformed_speech_gets_a_notice_and_stops_no_other(url: str, body: Body, hub: Hub) -> None:
    async with page(url) as ann:
        await ann.drive(0.1)
        await ann.until("status", lambda m: m["driver"] is not None)
        await ann.connection.send(voice(1, rate=44_100))
        assert "not 44100" in (await ann.until("notice", lambda m: m["level"] == "warning"))["text"]
        assert hub.driving.lease.driver_name == "Ann"
        assert body.played == []


async def test_a_lost_connection_ends_a_talk(url: str, hub: Hub) -> None:
    async with page(url, "Ben") as ben:
        async with page(url) as ann:
            await ann.connection.send(voice(1))
            await ben.until("status", lambda m: m["speaker"] is not None)
            ann.connection.transport.abort()
        await until(lambda: hub.speech.speaker is None)
        await ben.connection.send(voice(1))
        await ben.until("status", lambda m: m["speaker"] == {"operator": "Ben", "mine": True})


async def test_rest_lists_what_is_perceived(url: str, system: System) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as rest:
        system.graph.channel("faces").publish(faces(system.clock.now()))
        sent = (await rest.get("/percepts")).json()
    assert [face["track"] for face in sent["faces"]] == [1]
    assert sent["sounds"] == sent["noises"] == []
