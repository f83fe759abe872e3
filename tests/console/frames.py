"""One frame of each type that the console sends, with something in it."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from app.messages import Landmark, Landmarks, LoudNoise
from app.system import System
from tests.console.live_client import page, voice
from tests.console.percepts import codes, faces, sound_sources
from tests.console.places import grid, localization, path, status, zones
from tests.console.program import Body


async def of_each_type(url: str, system: System, body: Body, types: Collection[str]) -> dict[str, dict[str, Any]]:
    """The newest frame of each of ``types`` that a page at ``url`` gets of a program in which everything happens.

    Fails at a frame of another type.
    """
    system.graph.channel("landmarks").publish(
        Landmarks(system.clock.now(), (Landmark("door", (1.0, 2.0, 0.5), 0.1, 3, 1.0, 2.0),))
    )
    body.emit_status(system.clock.now())
    system.graph.channel("faces").publish(faces(system.clock.now()))
    system.graph.channel("qr_codes").publish(codes(system.clock.now()))
    system.graph.channel("sound_sources").publish(sound_sources(system.clock.now()))
    system.graph.channel("loud_noises").publish(LoudNoise(system.clock.now(), 30.0, -12.0))
    told = {"localization": localization, "zones": zones, "path": path, "navigation": status, "map": grid}
    for channel, message in {**told, "local_costmap": grid}.items():
        system.graph.channel(channel).publish(message(system.clock.now()))
    frames: dict[str, dict[str, Any]] = {}
    async with page(url) as ann:
        await ann.send("ping", t=1, rtt_ms=None)
        await ann.send("view", map=True, costmap=True)
        await ann.connection.send("{")
        system.timeline.add("module", "Nobody", "said")
        await ann.drive(0.1)
        await ann.connection.send(voice(1))
        while frames.keys() != set(types) or None in (frames["status"]["driver"], frames["status"]["speaker"]):
            frame = await ann.receive()
            if isinstance(frame, dict):
                assert frame["type"] in types
                frames[frame["type"]] = frame
    return frames
