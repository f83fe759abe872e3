"""Where what is seen and heard is, from what was published of it."""

from __future__ import annotations

import asyncio
import json
import math
import sys
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2, Pose3
from app.console.wire import encode
from app.messages import (
    EncodedImage,
    Faces,
    LoudNoise,
    Odometry,
    PlacedPercepts,
    QRCodes,
    SoundSources,
)
from app.modules.perception.percept_placer import PERIOD_S, Percepts
from app.runtime.clock import run_virtual
from tests.console.percepts import P_BA, codes, faces, no_codes, panorama, sound_source, sound_sources
from tests.modules.fakes import Bench

MODULE = "app.modules.perception.percept_placer:PerceptPlacer"
INPUTS = {
    "faces": Faces,
    "codes": QRCodes,
    "sounds": SoundSources,
    "noises": LoudNoise,
    "panorama": EncodedImage,
    "odometry": Odometry,
}
NOTHING: dict[str, list[Any]] = {"faces": [], "sounds": [], "noises": [], "codes": []}


class Perception:
    """What is said on channels, and what becomes of it, as JSON."""

    def __init__(self) -> None:
        self.percepts = Percepts()

    def say(self, _: str, message: Any) -> None:
        self.percepts.take(message)

    def odometry(self, stamp: float, pose: Pose2) -> None:
        self.percepts.take(Odometry(stamp, pose, 0.0, 0.0))

    def at(self, now: float) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(encode(self.percepts.at(now)))
        return found


@pytest.fixture
def perception() -> Perception:
    return Perception()


def test_nothing_is_perceived_where_nothing_was_said(perception: Perception) -> None:
    assert perception.at(5.0) == {"stamp": 5.0, **NOTHING}


def test_a_face_is_where_the_robot_was_when_it_was_seen(perception: Perception) -> None:
    """The robot turns on: seen is half way between two reports, and never now."""
    perception.say("faces", faces(10.05, (2.0, 0.0, 1.7)))
    perception.odometry(10.0, Pose2(1.0, 0.0, 0.0))
    assert [perception.at(10.1)["faces"][0][name] for name in "xyz"] == [None] * 3, "odometry is not there yet"
    perception.odometry(10.1, Pose2(1.0, 0.0, math.pi / 2))
    perception.odometry(10.2, Pose2(5.0, 5.0, math.pi))
    (face,) = perception.at(10.2)["faces"]
    assert [face[name] for name in "xyz"] == pytest.approx([1.0 + math.sqrt(2), math.sqrt(2), 1.7], abs=1e-3)


def test_angles_are_seen_from_the_camera(perception: Perception) -> None:
    perception.say("faces", faces(10.0, (1.1, 1.0, 2.2)))
    (face,) = perception.at(10.0)["faces"]
    assert face["azimuth"] == pytest.approx(math.pi / 4, abs=1e-3)
    assert face["elevation"] == pytest.approx(math.atan2(1.0, math.sqrt(2)), abs=1e-3)
    assert face["panorama"] is None
    perception.say("panorama_jpeg", panorama(9.9))
    (face,) = perception.at(10.0)["faces"]
    assert face["panorama"] == [face["azimuth"], face["elevation"]]
    assert (face["camera"], face["image"], face["box"]) == ("panorama_optical_frame", [1024, 768], [400, 300, 40, 50])


def test_a_face_is_seen_from_where_its_camera_was_when_it_was_seen(perception: Perception) -> None:
    """The head moves on: a newer picture of the same camera, from elsewhere, changes nothing of what was seen."""
    low, high = (Pose3.from_translation_rpy((0.0, 0.0, z), (0.0, 0.0, 0.0)) for z in (1.0, 3.0))
    perception.say("faces", faces(10.0, (2.0, 0.0, 1.0), X_BC=low))
    assert perception.at(10.0)["faces"][0]["elevation"] == 0.0
    perception.say("faces", faces(10.1, (2.0, 0.0, 1.0), first=2, X_BC=high))
    perception.say("panorama_jpeg", panorama(10.1, X_BC=high))
    old, new = perception.at(10.2)["faces"]
    assert (old["elevation"], new["elevation"]) == (0.0, pytest.approx(-math.pi / 4, abs=1e-4))
    # In the picture that is shown, both are where the camera of that picture sees them.
    assert old["panorama"] == new["panorama"] == pytest.approx([0.0, -math.pi / 4], abs=1e-4)


def test_a_percept_is_where_the_newest_panorama_shows_it_though_the_robot_has_turned(perception: Perception) -> None:
    turned = math.radians(40)
    camera = Pose3.from_translation_rpy((0.1, 0.0, 1.2))
    perception.odometry(10.0, Pose2(1.0, 2.0, 0.0))
    perception.say("faces", faces(10.0, (2.0, 0.0, 1.2)))
    perception.say("sounds", sound_sources(10.0, sound_source(range_m=math.inf)))
    perception.say("panorama_jpeg", panorama(10.2, X_BC=camera))
    before = perception.at(10.2)
    assert before["faces"][0]["panorama"] == [0.0, 0.0], "odometry is not there yet"
    assert perception.percepts.unplaced
    perception.odometry(10.2, Pose2(1.0, 2.0, turned))
    found = perception.at(10.2)
    aside = math.atan2(2.0 * math.sin(turned), 2.0 * math.cos(turned) - 0.1)
    assert found["faces"][0]["panorama"] == pytest.approx([-aside, 0.0], abs=1e-3)
    assert found["sounds"][0]["panorama"] == pytest.approx([-turned, 0.0], abs=1e-3)
    assert found["faces"][0]["azimuth"] == before["faces"][0]["azimuth"], "that is of its own instant"


def test_a_face_is_told_until_it_was_not_seen_for_a_second(perception: Perception) -> None:
    perception.say("faces", faces(10.0))
    perception.say("faces", faces(10.1, (3.0, 0.0, 1.2), first=2))
    assert [face["track"] for face in perception.at(11.0)["faces"]] == [1, 2]
    assert [face["track"] for face in perception.at(11.05)["faces"]] == [2]
    assert perception.at(11.2)["faces"] == []


def test_a_face_stays_between_images_that_come_seldom(perception: Perception) -> None:
    """The camera's images at φ = 15: one in 1.5 s."""
    for number in range(4):
        stamp = 10.0 + 1.5 * number
        perception.say("faces", faces(stamp))
        if number > 0:
            assert perception.at(stamp + 1.4)["faces"]
    assert perception.at(14.5 + 3.7)["faces"]
    assert not perception.at(14.5 + 3.8)["faces"]


def test_one_face_in_two_cameras_is_two_entries_of_one_track(perception: Perception) -> None:
    perception.say("faces", faces(10.0))
    perception.say("faces", faces(10.0, frame="kinect_optical_frame"))
    entries = [(face["track"], face["camera"]) for face in perception.at(10.0)["faces"]]
    assert entries == [(1, "kinect_optical_frame"), (1, "panorama_optical_frame")]


def test_a_sound_falls_silent_and_goes(perception: Perception) -> None:
    perception.say("sound_sources", sound_sources(10.0, sound_source()))
    assert perception.at(10.0)["sounds"][0]["active"]
    perception.say("sound_sources", sound_sources(10.3, sound_source(active=False)))
    (sound,) = perception.at(10.4)["sounds"]
    assert (sound["active"], sound["last_active"], sound["stamp"]) == (False, 10.0, 10.3)
    assert perception.at(11.9)["sounds"]
    assert not perception.at(12.1)["sounds"]


def test_a_sound_whose_track_ended_or_is_not_reported_is_silent(perception: Perception) -> None:
    perception.say("sound_sources", sound_sources(10.0, sound_source(1), sound_source(2, 1.0)))
    perception.say("sound_sources", sound_sources(10.1, sound_source(2, 1.0)))
    assert [(sound["track"], sound["active"]) for sound in perception.at(10.1)["sounds"]] == [(1, False), (2, True)]
    assert [sound["active"] for sound in perception.at(10.7)["sounds"]] == [False, False]


def test_a_sounds_place_and_direction(perception: Perception) -> None:
    perception.odometry(9.9, Pose2(1.0, 2.0, math.pi / 2))
    perception.odometry(10.1, Pose2(1.0, 2.0, math.pi / 2))
    perception.say("panorama_jpeg", panorama(9.9))
    perception.say("sound_sources", sound_sources(10.0, sound_source(azimuth=0.0, range_m=2.0)))
    (sound,) = perception.at(10.0)["sounds"]
    assert (sound["azimuth"], sound["elevation"]) == (0.0, 0.0)
    assert [sound[name] for name in "xyz"] == pytest.approx([1.0, 4.0, P_BA[2]])
    # The camera is 0.7 m above the microphones and 0.1 m ahead of them: from there it is below the horizon.
    assert sound["panorama"] == pytest.approx([0.0, -math.atan2(0.7, 1.9)], abs=1e-3)


def test_what_is_not_known_of_a_sound_is_null(perception: Perception) -> None:
    perception.odometry(10.0, Pose2())
    perception.say("sound_sources", sound_sources(10.0, sound_source(speech=math.nan, range_m=math.inf)))
    (sound,) = perception.at(10.0)["sounds"]
    assert [sound[name] for name in ("speech", "range_m", "x", "y", "z", "panorama")] == [None] * 6


def test_noises_are_published_for_two_seconds(perception: Perception) -> None:
    for number in range(5):
        perception.say("loud_noises", LoudNoise(10.0 + number, 25.123456, -20.0))
    assert [noise["stamp"] for noise in perception.at(14.5)["noises"]] == [13.0, 14.0]
    assert perception.at(14.5)["noises"][0]["ratio"] == 25.12
    assert perception.at(20.0)["noises"] == []


said = st.one_of(
    st.tuples(st.just("faces"), st.integers(1, 4)),
    st.tuples(st.just("sounds"), st.integers(1, 4)),
    st.tuples(st.just("noise"), st.just(0)),
)


@given(st.lists(st.tuples(st.floats(0.0, 0.5), said), max_size=60))
def test_percepts_are_young_and_published_once(story: list[tuple[float, tuple[str, int]]]) -> None:
    perception, now = Perception(), 100.0
    for pause, (what, track) in story:
        now += pause
        match what:
            case "faces":
                perception.say("faces", faces(now, (1.0, 0.0, 1.2), first=track))
            case "sounds":
                perception.say("sound_sources", sound_sources(now, sound_source(track, active=track % 2 == 0)))
            case _:
                perception.say("loud_noises", LoudNoise(now, 21.0, -20.0))
        perceived = perception.percepts.at(now)
        assert all(0 <= now - face.stamp <= 4 for face in perceived.faces)
        assert all(0 <= now - sound.last_active <= 2 for sound in perceived.sounds)
        assert all(0 <= now - noise.stamp <= 2 for noise in perceived.noises)
        assert len({face.track for face in perceived.faces}) == len(perceived.faces)
        assert len({sound.track for sound in perceived.sounds}) == len(perceived.sounds)


def test_a_code_is_published_as_it_was_read_until_it_is_gone(perception: Perception) -> None:
    perception.say("qr_codes", codes(10.0))
    (code,) = perception.at(10.5)["codes"]
    assert code == {
        "text": "stop 1",
        "camera": "panorama_optical_frame",
        "stamp": 10.0,
        "corners": [[1, 2], [11, 2], [11, 12], [1, 12]],
        "image": [1024, 768],
    }
    perception.say("qr_codes", no_codes(10.1))
    assert perception.at(11.05)["codes"] == []


def test_what_is_over_is_forgotten_without_a_request(perception: Perception) -> None:
    """A robot that runs for days meets many people while no page is open."""
    seen = faces(10.0)
    heard = sound_sources(10.0)
    read = codes(10.0)
    perception.say("faces", seen)
    perception.say("sound_sources", heard)
    perception.say("qr_codes", read)
    remembered = [sys.getrefcount(seen.faces[0]), sys.getrefcount(heard.sources[0]), sys.getrefcount(read.codes[0])]
    perception.say("faces", faces(20.0, first=2))
    perception.say("sound_sources", sound_sources(20.0, sound_source(2)))
    perception.say("qr_codes", no_codes(20.0))
    now = [sys.getrefcount(seen.faces[0]), sys.getrefcount(heard.sources[0]), sys.getrefcount(read.codes[0])]
    assert now == [count - 1 for count in remembered]


def bench() -> Bench:
    return Bench(MODULE, inputs=INPUTS, outputs={"percepts": PlacedPercepts})


def test_percepts_are_published_as_they_change_and_are_over_by_themselves() -> None:
    async def main() -> None:
        async with bench() as robot:
            published = robot.listen("percepts")
            now = robot.clock.now()
            robot.feed("odometry", Odometry(now - 0.1, Pose2(), 0.0, 0.0))
            robot.feed("faces", faces(now))
            first = await published.receive()
            while not first.faces:
                first = await published.receive()
            assert first.faces[0].x is None, "odometry is not there yet"
            robot.feed("odometry", Odometry(now + 0.1, Pose2(), 0.0, 0.0))
            placed = await published.receive()
            assert placed.faces[0].x == 2.0
            assert placed.stamp == first.stamp
            gone = await published.receive()
            assert gone.faces == ()
            assert 1.0 < gone.stamp - now < 1.0 + 2 * PERIOD_S

    run_virtual(main())


def test_where_time_stands_percepts_are_published_all_the_same() -> None:
    """In a paused replay no timer comes round."""

    async def main() -> None:
        async with bench() as robot:
            published = robot.listen("percepts")
            await robot.clock.sleep(0.3 * PERIOD_S)
            now = robot.clock.now()
            for number in range(3):
                robot.feed("odometry", Odometry(now, Pose2(float(number), 0.0, 0.0), 0.0, 0.0))
                robot.feed("faces", faces(now, first=number))
                # Every task gets its turn; no time passes.
                for _ in range(10):
                    await asyncio.sleep(0)
            assert robot.clock.now() == now
            newest = None
            while published.waiting:
                newest = published.receive_nowait()
            assert newest is not None
            assert [face.track for face in newest.faces] == [0, 1, 2]

    run_virtual(main())


def test_perceptions_rest_unless_placed_percepts_are_wanted() -> None:
    async def main() -> None:
        async with bench() as robot:
            assert robot.slot.context.inputs["panorama"].wants == "never", "a picture nobody looks at"
            channels = {name: robot.graph.channel(name) for name in INPUTS if name != "panorama"}
            assert not any(channel.wanted for channel in channels.values())
            channel = robot.graph.channel("percepts")
            wanted = channel.subscribe("test")
            assert all(channel.wanted for channel in channels.values())
            channel.unsubscribe(wanted)
            assert not any(channel.wanted for channel in channels.values())

    run_virtual(main())
