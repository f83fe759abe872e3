"""PersonTracker by itself: percepts at their own poses become one person, who speaks and is recognized again."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.base.geometry import Pose2, Pose3
from app.messages import (
    Face,
    Faces,
    LaserScan,
    Localization,
    OccupancyGrid,
    Odometry,
    Person,
    Persons,
    SoundSource,
    SoundSources,
    TorsoColors,
    read_only,
)
from app.modules.perception.people.torso_color import histogram
from app.runtime.clock import in_virtual_time
from tests.modules.behaviors.navigation.boxes import World
from tests.modules.fakes import Bench, drain

SHINS = ((1.95, 0.75, 2.05, 0.85, 0.0, 0.8), (1.95, 1.15, 2.05, 1.25, 0.0, 0.8))
WHERE = (2.0, 1.0)
P_BA = (0.0, 0.0, 0.7)


def bench() -> Bench:
    return Bench(
        "app.modules.perception.person_tracker:PersonTracker",
        inputs={
            "faces": Faces,
            "torsos": TorsoColors,
            "sources": SoundSources,
            "scans": LaserScan,
            "localization": Localization,
            "map": OccupancyGrid,
            "odometry": Odometry,
        },
        outputs={"persons": Persons},
        attended=("scans", "persons"),
    )


def face(stamp: float, X_OB: Pose2, track: int) -> Faces:
    x, y = X_OB.inverse().transform(np.array(WHERE)).tolist()
    marks, spread = read_only(np.zeros((5, 2), np.float32)), read_only(0.01 * np.eye(3))
    seen = Face(track, 0.9, (0, 0, 9, 9), marks, p_BF=(x, y, 1.6), covariance=spread, range_m=2.0, range_sigma_m=0.1)
    return Faces(stamp, "kinect", width=640, height=480, X_BC=Pose3.identity(), faces=(seen,))


def voice(stamp: float, X_OB: Pose2, track: int) -> SoundSources:
    azimuth = math.atan2(WHERE[1] - X_OB.y, WHERE[0] - X_OB.x) - X_OB.theta
    direction = (math.cos(azimuth), math.sin(azimuth), 0.0)
    source = SoundSource(track, direction, 0.5, -30.0, active=True, speech=0.9, range_m=2.0, range_sigma_m=0.5)
    return SoundSources(stamp, P_BA, (source,))


async def perceive(b: Bench, seconds: float, *, track: int = 1, seen: bool = True, heard: bool = False) -> None:
    """Percepts of a person who stands, ten times a second, while the robot turns slowly."""
    for _ in range(round(seconds / 0.1)):
        stamp = b.clock.now()
        X_OB = Pose2(0.0, 0.0, 0.2 * math.sin(stamp))
        b.feed("odometry", Odometry(stamp, X_OB, 0.0, 0.0))
        if seen:
            b.feed("scans", World(SHINS).scan(stamp, X_OB))
            b.feed("faces", face(stamp, X_OB, track))
            shirt = histogram(np.full((50, 3), (196, 88, 52), np.uint8))[None]
            b.feed("torsos", TorsoColors(stamp, "kinect", (track,), read_only(shirt)))
        if heard:
            b.feed("sources", voice(stamp, X_OB, 4))
        await b.clock.sleep(0.1)


def attend(b: Bench) -> None:
    b.graph.filters.apply({"Tested.scans": 1, "Tested.persons": 1})


def newest(given: object) -> tuple[Person, ...]:
    message: Persons = drain(given)[-1]  # type: ignore[arg-type]
    return message.persons


@in_virtual_time
async def test_face_legs_and_voice_are_one_person_where_it_stands() -> None:
    async with bench() as b:
        attend(b)
        given = b.listen("persons")
        await perceive(b, 2.0)
        (person,) = newest(given)
        assert (person.person, person.state, person.face, person.legs) == (1, "confirmed", 1, True)
        assert person.p_OP == pytest.approx((*WHERE, 1.6), abs=0.12)
        assert not person.speaking
        await perceive(b, 1.0, heard=True)
        (person,) = newest(given)
        assert (person.speaking, person.voice) == (True, 4)


@in_virtual_time
async def test_a_person_who_comes_back_in_the_same_clothes_has_the_same_number() -> None:
    async with bench() as b:
        attend(b)
        given = b.listen("persons")
        await perceive(b, 2.0)
        await perceive(b, 20.0, seen=False)
        assert newest(given) == ()
        await perceive(b, 2.0, track=9)
        (person,) = newest(given)
        assert (person.person, person.face) == (1, 9)


@in_virtual_time
async def test_nothing_is_published_while_nothing_wants_persons() -> None:
    async with bench() as b:
        given = b.listen("persons")
        await perceive(b, 1.0)
        assert not drain(given)
