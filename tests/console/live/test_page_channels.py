"""Channels to the page, as the table of channels says."""

from __future__ import annotations

import json
from typing import Any

import pytest
from pydantic import ValidationError

from app.console.live.page_channels import PageChannels
from app.messages import Landmarks, TimelineEvent, Twist
from app.runtime.channel_table import ChannelSpec
from app.runtime.clock import VirtualClock, run_virtual
from app.runtime.graph import Graph

TABLE: dict[str, dict[str, Any]] = {
    "wish": {"type": "Twist", "external": True, "latched": True, "page": {"every_hz": 10}},
    "drive": {"type": "Twist", "external": True, "page": {"as": "wheels"}},
    "events": {"type": "TimelineEvent", "external": True, "page": {"keep": "all"}},
    "found": {"type": "Landmarks", "external": True, "page": {"as": "landmarks"}},
    "quiet": {"type": "Twist", "external": True},
}


class Pages:
    """What the pages are given."""

    def __init__(self) -> None:
        self.moving = False
        self.frames: list[dict[str, Any]] = []
        self.items: list[tuple[str, dict[str, Any]]] = []
        self.clock = VirtualClock()
        specs = {name: ChannelSpec.model_validate(row) for name, row in TABLE.items()}
        self.graph = Graph(clock=self.clock, channels=specs, modules={}, services={})
        self.channels = PageChannels(self.graph, self.clock, self)

    def broadcast(self, kind: str, frame: str) -> None:
        self.frames.append(json.loads(frame))
        assert self.frames[-1]["type"] == kind

    def broadcast_each(self, kind: str, item: str) -> None:
        self.items.append((kind, json.loads(item)))

    def say(self, channel: str, message: Any) -> None:
        self.graph.channel(channel).publish(message)

    async def settle(self) -> None:
        await self.clock.sleep(0.001)


def twist(stamp: float) -> Twist:
    return Twist(stamp, 0.5, 0.0)


def test_a_channel_is_wanted_and_forwarded_while_it_is_open_as_its_row_says() -> None:
    async def main() -> None:
        pages = Pages()
        assert not pages.graph.channel("drive").wanted
        close = pages.channels.open()
        wanted = {name for name in TABLE if pages.graph.channel(name).wanted}
        assert wanted == TABLE.keys() - {"quiet"}
        pages.say("quiet", twist(1.0))
        pages.say("drive", twist(1.0))
        await pages.settle()
        assert pages.frames == [
            {"type": "wheels", "stamp": 1.0, "linear_mps": 0.5, "angular_radps": 0.0, "lateral_mps": 0.0}
        ]
        close()
        assert not pages.graph.channel("drive").wanted

    run_virtual(main())


def test_no_more_come_than_the_row_allows_and_the_newest_comes_last() -> None:
    async def main() -> None:
        pages = Pages()
        pages.channels.open()
        for number in range(100):
            pages.say("wish", twist(float(number)))
            await pages.clock.sleep(0.01)
        await pages.clock.sleep(0.2)
        assert 10 <= len(pages.frames) <= 11
        assert pages.frames[-1]["stamp"] == 99.0

    run_virtual(main())


def test_of_a_channel_that_keeps_all_every_message_comes_and_none_stands() -> None:
    async def main() -> None:
        pages = Pages()
        pages.channels.open()
        for number in range(1, 4):
            pages.say("events", TimelineEvent(number, 1.0, "module", "Kinect", "failed", {"a": 1}))
        await pages.settle()
        assert [(kind, item["id"], item["data"]) for kind, item in pages.items] == [
            ("events", number, {"a": 1}) for number in range(1, 4)
        ]
        assert "events" not in pages.channels.standing()

    run_virtual(main())


def test_who_comes_later_is_given_the_last_and_after_a_jump_what_still_holds() -> None:
    async def main() -> None:
        pages = Pages()
        assert pages.channels.standing() == {"landmarks": '{"type":"landmarks","landmarks":[]}'}
        pages.say("wish", twist(1.0))
        pages.say("drive", twist(2.0))
        pages.say("found", Landmarks(3.0, ()))
        assert {kind: json.loads(frame).get("stamp") for kind, frame in pages.channels.standing().items()} == {
            "wish": 1.0,
            "wheels": 2.0,
            "landmarks": None,
        }
        assert pages.channels.states().keys() == {"wish"}

    run_virtual(main())


def test_while_time_is_moved_nothing_comes_and_what_waited_is_dropped() -> None:
    async def main() -> None:
        pages = Pages()
        pages.channels.open()
        pages.say("wish", twist(1.0))
        await pages.settle()
        pages.say("wish", twist(2.0))
        await pages.settle()
        pages.moving = True
        pages.say("drive", twist(3.0))
        await pages.settle()
        pages.channels.clear()
        pages.moving = False
        await pages.clock.sleep(1.0)
        assert [frame["stamp"] for frame in pages.frames] == [1.0]

    run_virtual(main())


@pytest.mark.parametrize("row", [{"every_hz": 0}, {"keep": "some"}, {"as": "two words"}, {"every": 3}])
def test_a_row_that_cannot_be_is_refused(row: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ChannelSpec.model_validate({"type": "Twist", "page": row})
