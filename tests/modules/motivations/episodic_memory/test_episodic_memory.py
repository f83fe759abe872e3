"""The module: what it makes of channels, what it keeps, and what it desires."""

from __future__ import annotations

import asyncio
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel, ConfigDict

from app.attention.desires import Desire, DesireClass, DesireClasses, Source
from app.attention.emotions import EMOTIONS
from app.attention.reports import desires_report
from app.attention.timeline import Timeline
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.memory.service import MemoryOff, MemoryService, UnknownEpisode
from app.memory.store import FILE, MemoryStore
from app.messages import (
    Accomplishment,
    EmotionLevel,
    EmotionState,
    Localization,
    MemoryState,
    PerceptEvent,
    Person,
    Persons,
    Place,
    Places,
)
from app.modules.motivations.episodic_memory.scene import Scene, Senses
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.fakes import drain
from tests.modules.motivations.episodic_memory.week import fulfilled, memory_bench

PLACES = (Place("door", "Door", 0.0, 0.0, 0.0, "poster", "HBBA:STOP/DOOR", 1), Place("arm", "Arm", 5.0, 0.0, 0.0))
WORDS = {"words": "who, what"}
STEP_S = 1.0

pytestmark = pytest.mark.slow


async def content(folder: Path) -> bytes:
    """Of the file of memory."""
    return await asyncio.to_thread((folder / FILE).read_bytes)


async def names(folder: Path) -> list[str]:
    """What is in ``folder``."""
    return sorted(await asyncio.to_thread(os.listdir, folder))


class Anything(BaseModel):
    model_config = ConfigDict(extra="allow")


CLASSES = DesireClasses(
    [DesireClass(name, name, name, Anything, achievement=name == "Say") for name in ("Say", "ListenForWords", "GoTo")]
)


class Robot:
    """A robot that remembers in ``folder``, and what a test lets it perceive and do."""

    def __init__(self, folder: Path, **settings: object) -> None:
        self.clock = VirtualClock()
        self.workspace = IntentionWorkspace(CLASSES, self.clock.now)
        self.timeline = Timeline(200, self.clock.now)
        self.service = MemoryService()
        self.bench = memory_bench(MemoryStore(folder), self.workspace, self.timeline, self.service, **settings)
        self.x = 0.0
        self.persons: tuple[int | None, ...] = ()
        self.exploited: list[str] = []
        self.states: list[MemoryState] = []

    async def __aenter__(self) -> Robot:
        await self.bench.__aenter__()
        self._listen = self.bench.listen("memory")
        self.states += [] if (latest := self.bench.graph.channel("memory").latest) is None else [latest]
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.bench.__aexit__(*error)

    @property
    def state(self) -> MemoryState:
        self.states += drain(self._listen)
        return self.states[-1]

    @property
    def own(self) -> list[Desire]:
        """Desires of memory's."""
        return [desire for desire in self.workspace.desires() if desire.source.name.startswith("Tested")]

    def event(self, name: str, subject: str) -> None:
        now = self.clock.now()
        kind = name.partition(".")[0]
        self.bench.feed("events", PerceptEvent(now, name, kind, subject, "kinect", now, 1.0, None, None))

    async def live(self, seconds: float) -> None:
        """All inputs at their rates."""
        for _ in range(round(seconds / STEP_S)):
            now, feed = self.clock.now(), self.bench.feed
            pose = Pose2(self.x, 0.0, 0.0)
            feed("places", Places(now, PLACES))
            feed("localization", Localization(now, Pose2(), pose, np.eye(3), "tracking", 1.0, "lab"))
            feed("persons", Persons(now, tuple(self._person(now, n, each) for n, each in enumerate(self.persons))))
            feed("desires", desires_report(self.workspace, now, tuple(self.exploited)))
            feed("intention", fulfilled(now, tuple(self.workspace.strongest())))
            await self.clock.sleep(STEP_S)

    def _person(self, now: float, track: int, identity: int | None) -> Person:
        p_OP = (self.x + 1.5, 0.0, 1.6)
        return Person(
            track, identity, "confirmed", p_OP, (0, 0), np.eye(2), face=None, voice=None, legs=True, speaking=False,
            last_seen=now,
        )  # fmt: skip

    async def say(self, text: str) -> None:
        """Say ``text`` for 3 s, because a client desires it, while words are listened for."""
        source = Source("rest", "client")
        listen = self.workspace.add("ListenForWords", intensity=5, utility=1, source=source, params=WORDS)
        desire = self.workspace.add("Say", intensity=5, utility=1, source=source, params={"text": text})
        self.exploited = [desire.id]
        await self.live(3.0)
        self.workspace.accomplish(Accomplishment(self.clock.now(), desire.id, "Say", "done"))
        self.exploited = []
        await self.live(1.0)
        self.workspace.remove(listen.id)

    async def visit(self) -> None:
        """Someone comes, is answered, and leaves."""
        self.persons = (3,)
        await self.live(3.0)
        await self.say("It weighs 80 kg, Anna.")
        self.persons = ()
        await self.live(40.0)


@in_virtual_time
async def test_what_happened_before_is_recognized_anticipated_and_desired_again(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        await robot.live(5.0)
        assert (robot.state.under_way, robot.state.episodes) == ((), ()), "a robot alone has no episodes"
        await robot.visit()
        (episode,) = robot.state.episodes
        assert (episode.times, episode.deeds) == (1, ("ListenForWords",))
        items = {(each.channel, each.item.partition("#")[0]) for each in episode.items}
        assert {("person", "someone"), ("person", "person 3"), ("place", "lab/door"), ("desire", "Say")} <= items
        assert not robot.own, "nothing is recognized any more"

        robot.persons = (4,)
        await robot.live(3.0)
        state = robot.state
        assert (state.recognized, len(state.anticipated)) == (1, 1)
        assert any(each.channel == "desire" for each in state.anticipated[0].event.items)
        (desire,) = robot.own
        assert (desire.cls, desire.params, desire.intensity, desire.security) == ("ListenForWords", WORDS, 2.0, False)
        assert desire.source == Source("motivation", "Tested, episode 1", motive="rational")
        (raised,) = state.raised
        assert (raised.id, raised.episode) == (desire.id, 1)
        assert raised.why == "episode 1 was accomplished with it in 100% of the last times"
        assert desire.expires is not None, "it would leave by itself"
        await robot.live(60.0)
        assert [each.id for each in robot.own] == [desire.id], "it is renewed"

        await robot.say("It weighs 80 kg, Anna.")
        kinds = [event.subject for event in robot.timeline.query(kinds=["memory"])]
        assert "expected" in kinds
        robot.persons = ()
        await robot.live(40.0)
        (episode,) = robot.state.episodes
        assert episode.times == 2
        assert not robot.own
    # The file has neither what was said nor who was there but a number, and that is void after the program's end.
    data = await content(tmp_path)
    assert b"Anna" not in data
    assert b"weighs" not in data
    async with Robot(tmp_path) as robot:
        (episode,) = robot.state.episodes
        assert episode.times == 2
        assert [each.item for each in episode.items if each.channel == "person"] == ["someone"]
    assert b"person 3" not in await content(tmp_path)


@in_virtual_time
async def test_another_place_ends_the_episode_and_a_code_is_known_by_its_place(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        robot.persons = (1,)
        robot.event("code.appears", "HBBA:STOP/DOOR")
        robot.event("code.appears", "BEGIN:VCARD Anna")
        await robot.live(4.0)
        robot.x = 2.5
        await robot.live(4.0)
        assert robot.state.episode_count == 0, "on the way it is still where it came from"
        robot.x = 4.5
        await robot.live(8.0)
        (episode,) = robot.state.episodes
        assert next(each.item for each in episode.items if each.channel == "object").startswith("code #")
        assert [each.item for each in episode.items if each.channel == "object"][1] == "code door"
        assert "Anna" not in str(episode)
        places = {each.item for event in robot.state.under_way for each in event.items if each.channel == "place"}
        assert places == {"lab/arm"}
        assert not any(each.item.startswith("code") for each in robot.state.under_way[-1].items), "it is elsewhere"


@in_virtual_time
async def test_what_people_withdraw_is_not_desired_again_in_this_episode(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        await robot.visit()
        robot.persons = (4,)
        await robot.live(3.0)
        (desire,) = robot.own
        robot.workspace.remove(desire.id)
        await robot.live(20.0)
        assert not robot.own
        robot.persons = ()
        await robot.live(40.0)
        robot.persons = (5,)
        await robot.live(3.0)
        assert len(robot.own) == 1, "the next time it is"


@in_virtual_time
async def test_a_desire_of_others_is_raised_within_bounds_and_never_outdone(tmp_path: Path) -> None:
    async with Robot(tmp_path, boost=1.5) as robot:
        await robot.visit()
        robot.persons = (4,)
        await robot.live(3.0)
        source = Source("operator", "ada")
        same = robot.workspace.add("ListenForWords", intensity=7, utility=2, source=source, params=WORDS)
        await robot.live(1.0)
        assert [(each.intensity, each.utility) for each in robot.own] == [(8.0, 2.0)], "the scale ends at 8"
        robot.workspace.change(same.id, intensity=3)
        await robot.live(1.0)
        assert [each.intensity for each in robot.own] == [4.5]
        changes: tuple[dict[str, Any], ...] = (
            {"params": {"words": "stop"}},
            {"params": WORDS, "utility": 0},
            {"utility": 1, "security": True},
        )
        for change in changes:
            robot.workspace.change(same.id, **change)
            await robot.live(1.0)
            assert robot.own == [], change
        robot.workspace.change(same.id, security=False)
        await robot.live(1.0)
        assert len(robot.own) == 1


@in_virtual_time
async def test_nothing_that_moves_is_desired_unless_it_is_named(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        going = robot.workspace.add("GoTo", intensity=5, utility=1, source=Source("rest", ""), params={"x": 1})
        for visitor in (1, 2):
            robot.persons = (visitor,)
            await robot.live(3.0)
            robot.exploited = [going.id]
            await robot.live(4.0)
            robot.workspace.accomplish(Accomplishment(robot.clock.now(), going.id, "PlanAndFollowPath", "done"))
            robot.exploited, robot.persons = [], ()
            await robot.live(40.0)
        robot.workspace.remove(going.id)
        robot.persons = (3,)
        await robot.live(3.0)
        assert robot.state.recognized == 1
        assert robot.own == []


@in_virtual_time
async def test_episodes_are_deleted_one_or_all_also_in_the_file(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        for x in (0.0, 5.0):
            robot.x = x
            await robot.live(2.0)
            await robot.visit()
        server = robot.service.server
        report = await server.report()
        assert [each.id for each in report.episodes] == [2, 1]
        assert {each.event for episode in report.episodes for each in episode.events} == {e.id for e in report.events}
        assert report.episodes[0].deeds[0].params == WORDS
        with pytest.raises(UnknownEpisode, match="no episode has the number 9"):
            await server.forget(9)
        robot.persons = (9,)
        await robot.live(3.0)
        assert robot.state.recognized == 2
        assert robot.own
        await server.forget(2)
        assert (robot.state.recognized, [each.id for each in robot.state.episodes]) == (None, [1])
        await robot.live(1.0)
        assert not robot.own
        await server.forget_all()
        assert robot.state.episodes == ()
        assert robot.state.under_way == ()
        assert robot.state.event_count == 0
    assert b"lab/" not in await content(tmp_path)
    with pytest.raises(MemoryOff, match="remembers nothing"):
        _ = robot.service.server


@in_virtual_time
async def test_off_nothing_is_kept_not_even_what_was(tmp_path: Path) -> None:
    async with Robot(tmp_path) as robot:
        await robot.visit()
    assert await names(tmp_path) == [FILE]
    async with Robot(tmp_path, enabled=False) as robot:
        assert await names(tmp_path) == []
        assert [event.text for event in robot.timeline.query()] == ["Memory is off: what was remembered is deleted"]
        await robot.visit()
        assert robot.states == [robot.state]
        assert not robot.state.on
        assert not robot.service.available
    assert await names(tmp_path) == []


@in_virtual_time
async def test_what_has_not_happened_for_long_is_forgotten(tmp_path: Path) -> None:
    async with Robot(tmp_path, kept_days=0.002) as robot:  # 173 s
        await robot.visit()
        robot.persons = (4,)
        await robot.live(5.0)
        assert (robot.state.episode_count, robot.state.recognized, len(robot.own)) == (1, 1, 1)
        await robot.live(200.0)
        assert (robot.state.episode_count, robot.state.recognized, robot.own) == (0, None, [])
        assert b"lab/" not in await content(tmp_path), "what is under way is not kept, either"
    assert b"lab/" not in await content(tmp_path)


@in_virtual_time
async def test_an_unreadable_file_is_set_aside_in_words(tmp_path: Path) -> None:
    await asyncio.to_thread((tmp_path / FILE).write_bytes, b"no memory " * 1000)
    async with Robot(tmp_path) as robot:
        (event,) = robot.timeline.query()
        assert "cannot be read: file is not a database; it is set aside as memory.unreadable-1.sqlite" in event.text
        assert "set aside" in robot.state.problem
        await robot.visit()
        assert robot.state.episode_count == 1
    assert await names(tmp_path) == [FILE, "memory.unreadable-1.sqlite"]


@in_virtual_time
async def test_a_disk_that_refuses_is_said_once_and_tried_again(tmp_path: Path) -> None:
    folder = tmp_path / "memory"
    await asyncio.to_thread(folder.write_text, "in the way")
    async with Robot(folder) as robot:
        for x in (0.0, 5.0):
            robot.x = x
            await robot.visit()
        problems = [event.text for event in robot.timeline.query() if event.subject == "file"]
        assert len(problems) == 1
        assert problems[0].startswith("What is remembered cannot be kept: ")
        await asyncio.to_thread(folder.unlink)
        robot.x = 0.0
        await robot.visit()
        assert robot.state.problem == ""
    async with Robot(folder) as robot:
        assert robot.state.episode_count == 2


def scene() -> Scene:
    return Scene(Senses(2.0, 4.0, ("code",), ("face",), None, identity=0.2, stays_s=120.0))


def test_only_a_pose_that_can_be_relied_on_is_at_a_place() -> None:
    there = scene()
    lost = Localization(1.0, Pose2(), Pose2(math.nan, 0, 0), np.eye(3), "lost", 0.0, "")
    there.take_localization(lost)
    there.take_places(Places(1.0, PLACES))
    assert there.look(1.0) == ({}, False)
    there.take_localization(replace(lost, X_MB=Pose2(), state="tracking"))
    assert there.look(2.0) == ({"place": {"door": 1.0}}, False)


def test_emotions_are_a_channel_and_have_no_effect_while_nothing_is_heard_of_them() -> None:
    there = scene()
    assert there.emotion is None
    there.take_emotions(felt(1.0, joy=0.72, anger=0.03))
    assert there.emotion == 0.72
    assert there.look(2.0) == ({"emotion": {"joy": 0.7}}, False)
    assert there.look(100.0) == ({"emotion": {"joy": 0.7}}, False), "it is felt until something else is heard"
    there.take_emotions(felt(101.0))
    assert there.emotion == 0.0
    assert there.look(114.0) == ({"emotion": {"joy": 0.7}}, False)
    assert there.look(116.0) == ({}, False), "15 s"


@in_virtual_time
async def test_what_is_felt_strongly_is_part_of_its_events_and_overwritten_more_slowly(tmp_path: Path) -> None:
    episodes = {}
    for anger in (0.0, 1.0):
        async with Robot(tmp_path / str(anger)) as robot:
            robot.bench.feed("emotions", felt(robot.clock.now(), anger=anger))
            await robot.visit()
            (episodes[anger],) = (await robot.service.server.report()).episodes
            items = {(each.channel, each.item) for each in robot.state.episodes[0].items}
            assert (("emotion", "anger") in items) == (anger > 0)
    # As published: L + 0.375 L (0.5 - E), of 0.6.
    assert {emotion: each.learning_rate for emotion, each in episodes.items()} == {0.0: 0.7125, 1.0: 0.4875}


def felt(stamp: float, **intensities: float) -> EmotionState:
    """Emotions of these intensities, all others 0."""
    levels = tuple(EmotionLevel(name, intensities.get(name, 0.0), ()) for name in EMOTIONS)
    return EmotionState(stamp, levels, modulates=False)
