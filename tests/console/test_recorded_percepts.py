"""People on a recording: seen and heard as they were, at the place in time that is played; speech is not taken."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import pytest

from app.base import paths
from app.logs.log import Logged
from app.logs.manifest import Manifest
from app.messages import LoudNoise, Message
from app.program.config import load_configuration
from app.program.system import System
from tests.console.live_client import page, voice
from tests.console.percepts import faces, sound_source, sound_sources
from tests.console.program import sound, write_program
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_messages
from tests.logs.replay.playing import Played, prepare


def manifest(folder: Path) -> Manifest:
    """What a recording of the console's test program carries: what it perceived comes from the log alone."""
    program = write_program(folder)
    robot = paths.config_dir() / "robots" / "irl1_tr.yaml"
    program.write_text(program.read_text().replace("robot: robot.yaml", f"robot: {robot}"))
    system = System(load_configuration(program))
    return system.graph.modules["Kinect"].context.services[Manifest]


@pytest.fixture
def prepared(tmp_path: Path) -> Any:
    """Six seconds of the lab: a person is there from 1 to 3 s and claps at 2 s; the microphones hear until 4 s."""
    recorded: list[tuple[str, Message]] = [("loud_noises", LoudNoise(BEGIN + 2.0, 40.0, -9.0))]
    for number in range(20):
        stamp = BEGIN + 1.0 + 0.1 * number
        recorded += [("faces", faces(stamp)), ("sound_sources", sound_sources(stamp, sound_source(azimuth=0.5)))]
    recorded += [("microphones", sound(BEGIN + number * 512 / 48_000, number * 512)) for number in range(375)]
    messages = [*lab_messages(6.0), *(Logged(message.stamp, channel, message) for channel, message in recorded)]
    return prepare(MemoryLog(sorted(messages, key=lambda logged: logged.at), manifest(tmp_path)))


async def test_people_are_there_when_they_were_there(replay_url: str, play: Played) -> None:
    async with page(replay_url) as ann:
        assert (await ann.until("perceived"))["faces"] == []
        await play.playback.seek(BEGIN + 1.9)
        play.playback.play()
        recorded = await ann.until("perceived", lambda m: m["faces"] and m["sounds"] and m["noises"])
        assert BEGIN + 1.9 <= recorded["faces"][0]["stamp"] < BEGIN + 3.0
        # The robot drives ahead at 0.1 m/s: the face is 2 m ahead of where it was at that stamp.
        assert recorded["faces"][0]["x"] == pytest.approx(0.1 * (recorded["faces"][0]["stamp"] - BEGIN) + 2.0, abs=0.02)
        assert recorded["sounds"][0]["azimuth"] == 0.5
        assert recorded["noises"][0]["stamp"] == BEGIN + 2.0
        await play.playback.seek(BEGIN + 4.9)
        await ann.until("jump")
        assert (await ann.until("perceived"))["faces"] == []


async def test_a_recording_can_be_listened_to(replay_url: str, play: Played) -> None:
    async with page(replay_url) as ann:
        assert (await ann.until("hello"))["audio"] == {"listen": True, "speak": False}
        await ann.send("listen", on=True)
        await ann.send("ping", t=1)
        await ann.until("pong")
        system = play.replay.system
        # Past attention: no desire asks for it, so that no other intention is made than there was.
        assert system.graph.filters.divisors()["AudioStream.audio"] == 1
        assert not [desire for desire in system.workspace.desires() if desire.cls == "Listen"]
        play.playback.play()
        heard = [await ann.sound() for _ in range(10)]
        assert all(len(samples) == 1024 for *_, samples in heard)
        assert [after[0] - before[0] for before, after in itertools.pairwise(heard)] == [1] * 9
        assert heard[-1][1] - heard[0][1] == pytest.approx(9 * 1024 / 48_000, abs=1e-3)


async def test_a_recording_takes_no_speech(replay_url: str) -> None:
    async with page(replay_url) as ann:
        assert not (await ann.until("hello"))["audio"]["speak"]
        for number in range(3):
            await ann.connection.send(voice(number))
        assert "recording" in (await ann.until("notice"))["text"]
        await ann.send("ping", t=1)
        while (frame := await ann.receive())["type"] != "pong":  # type: ignore[call-overload]
            assert frame["type"] != "notice"  # type: ignore[call-overload]
