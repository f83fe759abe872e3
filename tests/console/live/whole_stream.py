"""A program that publishes messages of every type, and a page that asks for all of them."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from app.attention.desires import Source
from app.messages import (
    AnticipatedEvent,
    BatteryState,
    EmotionLevel,
    EmotionSource,
    EmotionState,
    EpisodeSummary,
    HeardWords,
    Landmark,
    Landmarks,
    LoudNoise,
    MemoryEvent,
    MemoryItem,
    MemoryState,
    OperatorQuestion,
    Person,
    Persons,
    RaisedDesire,
    RaisedIntensity,
    RuleReport,
    RulesReport,
    SaliencyMap,
    SalientRegion,
    SalientRegions,
    ShownEmotion,
    ShownMedia,
    Speech,
    TourFailure,
    TourProgress,
    TourQuestion,
    read_only,
)
from app.program.system import System
from tests.console.live_client import page, voice
from tests.console.percepts import codes, faces, sound_sources
from tests.console.places import grid, localization, path, status, zones
from tests.console.program import Body
from tests.patience import PATIENCE_S


def say_everything(system: System, body: Body) -> None:
    """Publish a message on each channel that the stream reports."""
    now = system.clock.now()
    # Of a time to come, so that none of it is over before the page has it, however slow the computer.
    soon = now + 60.0
    system.graph.channel("landmarks").publish(Landmarks(now, (Landmark("door", (1.0, 2.0, 0.5), 0.1, 3, 1.0, 2.0),)))
    body.emit_status(now)
    system.graph.channel("faces").publish(faces(soon))
    system.graph.channel("qr_codes").publish(codes(soon))
    system.graph.channel("sound_sources").publish(sound_sources(soon))
    system.graph.channel("loud_noises").publish(LoudNoise(soon, 30.0, -12.0))
    speech = Speech(now, "speaking", "Hello.", 0, 6, viseme="open", language="en", desire="d-1", waiting=0)
    system.graph.channel("speech").publish(speech)
    battery = BatteryState(now, 0.5, 24.0, -2.0, charging=False, remaining_s=3600.0)
    system.graph.channel("battery").publish(battery)
    ahead, words = (1.0, 0.0, 0.0), ("yes", "no")
    heard = HeardWords(now, "yes", False, confidence=0.9, likeliest="yes", direction=ahead, words=words, language="en")
    system.graph.channel("heard_words").publish(heard)
    region = SalientRegion(0.5, 0.1, 0.8, motion=0.5, color=0.1, contrast=0.0, faces=0.2, sounds=0.0)
    system.graph.channel("salient_regions").publish(SalientRegions(now, (0.1, 0.0, 1.3), (region,)))
    someone = Person(
        4,
        3,
        "confirmed",
        p_OP=(1.0, 0.5, 1.6),
        v_O=(0.1, 0.0),
        covariance=read_only(0.01 * np.eye(2)),
        face=7,
        voice=None,
        legs=True,
        speaking=False,
        last_seen=now,
    )
    system.graph.channel("persons").publish(Persons(now, (someone,)))
    event = MemoryEvent(7, (MemoryItem("person", "someone", 1.0),))
    memory = MemoryState(
        now, on=True, problem="", under_way=(event,), recognized=3, match=0.9,
        anticipated=(AnticipatedEvent(event, 1.0),),
        raised=(RaisedDesire("d-1", "Listen", 2.0, 3, "it was accomplished with it"),),
        episodes=(EpisodeSummary(3, times=2, first=1.0, last=2.0, events=1, items=event.items, deeds=("Listen",)),),
        episode_count=1, event_count=1,
    )  # fmt: skip
    system.graph.channel("memory").publish(memory)
    angry = EmotionLevel("anger", 0.6, (EmotionSource("GoTo", 0.5, neglected=True),))
    raised = RaisedIntensity("d-1", "GoTo", 1.0, "anger")
    shown = ShownEmotion("anger", 0.5, "d-2")
    emotions = EmotionState(now, (angry,), modulates=True, raised=(raised,), shows=True, shown=shown)
    system.graph.channel("emotions").publish(emotions)
    rule = RuleReport(
        "greet", "for visitors", words="when a face appears", file="rules.yaml", line=3, enabled=True, holds=None,
        fired=1, last_fired=now, last_event="face.appears 7", desires=("d-1",),
    )  # fmt: skip
    system.graph.channel("rules").publish(RulesReport(now, (rule,), ("rules.yaml",)))
    text = {"en": "The arm"}
    tour = TourProgress(
        now, "run", "arm-tour", title=text, language="en", languages=("en",), waits=False, state="blocked", since=now,
        reason="the way is blocked", stop="arm", stop_title=text, number=1, stops=2, step=1, steps=3, text=text,
        sentence=0, shown=ShownMedia("arm.jpg", text, video=False), press=text, questions=(TourQuestion("old", text),),
        buttons=("pause", "skip"), question=OperatorQuestion("Skip it?", ("skip",), "it is skipped", now + 60.0),
        people=2, farthest_m=1.5, presented=("desk",), skipped=("door",), failures=(TourFailure("door", "no way"),),
    )  # fmt: skip
    system.graph.channel("tour_progress").publish(tour)
    cells = read_only(np.zeros((32, 120), np.uint8))
    system.graph.channel("saliency").publish(SaliencyMap(now, math.radians(3), 1.0, cells))
    messages: dict[str, Callable[[float], Any]]
    messages = {"localization": localization, "zones": zones, "path": path, "navigation": status, "map": grid}
    for channel, message in {**messages, "local_costmap": grid}.items():
        system.graph.channel(channel).publish(message(now))
    system.workspace.add("Telepresence", intensity=2.0, utility=1.0, source=Source("rest", "rest"))


async def heard(
    url: str, system: System, wanted: set[str], check: Callable[[dict[str, Any]], None]
) -> dict[str, dict[str, Any]]:
    """The last frame of each type, once every type of ``wanted`` came and, after that, the page drives and speaks.

    ``check`` is called with every frame. Raises AssertionError, which names what did not come."""
    frames: dict[str, dict[str, Any]] = {}
    async with page(url) as ann:

        async def take() -> None:
            frame = await ann.receive()
            if isinstance(frame, dict):
                check(frame)
                frames[frame["type"]] = frame

        await ann.send("ping", t=1, rtt_ms=None)
        await ann.send("view", map=True, costmap=True)
        await ann.connection.send("{")
        system.timeline.add("module", "Nothing", "said")
        try:
            async with asyncio.timeout(PATIENCE_S):
                while not wanted <= frames.keys():
                    await take()
        except TimeoutError:
            raise AssertionError(f"did not come: {', '.join(sorted(wanted - frames.keys()))}") from None
        assert frames.keys() == wanted
        await ann.drive(0.1)
        await ann.connection.send(voice(1))
        while None in (frames["status"]["driver"], frames["status"]["speaker"]):
            await take()
    return frames
