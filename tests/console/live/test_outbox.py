"""What waits for one viewer."""

from __future__ import annotations

import asyncio
import json

from hypothesis import given
from hypothesis import strategies as st

from app.console.live.outbox import MOST_ITEMS, MOST_NOTICES, MOST_SOUND, Frame, Outbox


async def drained(outbox: Outbox) -> list[Frame]:
    """Everything that waits, in order."""
    frames = []
    while outbox.statistics().waiting:
        frames.append(await outbox.take())
    return frames


async def test_of_each_kind_only_the_newest_waits_and_kinds_take_turns() -> None:
    outbox = Outbox()
    outbox.put("status", "s1")
    outbox.put("lanes", "l1")
    outbox.put("status", "s2")
    outbox.put_urgent("notice")
    assert await outbox.take() == "notice"
    assert await outbox.take() == "s2"
    outbox.put("status", "s3")
    assert await drained(outbox) == ["l1", "s3"]
    assert outbox.statistics().replaced == 1


async def test_events_are_kept_in_order_until_there_are_too_many() -> None:
    outbox = Outbox()
    outbox.put_each("events", ['{"id":1}'])
    outbox.put_each("events", ['{"id":2}', '{"id":3}'])
    frame = await outbox.take()
    assert json.loads(frame) == {"type": "events", "events": [{"id": 1}, {"id": 2}, {"id": 3}]}
    outbox.put_each("events", ("{}" for _ in range(MOST_ITEMS + 1)))
    assert outbox.statistics().items == 0
    notice = json.loads(await outbox.take())
    assert (notice["type"], notice["level"]) == ("notice", "warning")
    outbox.put_each("events", ['{"id":4}'])
    assert json.loads(await outbox.take())["events"] == [{"id": 4}]


async def test_one_picture_is_under_way() -> None:
    outbox = Outbox()
    outbox.put_picture(1, b"1")
    outbox.put_picture(1, b"2")
    assert await outbox.take() == b"2"
    outbox.put_picture(1, b"3")
    outbox.put_picture(1, b"4")
    assert outbox.statistics().waiting == 0
    outbox.picture_drawn(1)
    assert await outbox.take() == b"4"
    outbox.picture_drawn(1)
    assert outbox.statistics().waiting == 0
    outbox.put_picture(1, b"5")
    outbox.drop_picture(1)
    assert await drained(outbox) == []


async def test_each_kind_of_picture_is_acknowledged_by_itself() -> None:
    outbox = Outbox()
    outbox.put_picture(1, b"camera 1")
    outbox.put_picture(2, b"panorama 1")
    assert await drained(outbox) == [b"camera 1", b"panorama 1"]
    outbox.put_picture(1, b"camera 2")
    outbox.put_picture(2, b"panorama 2")
    assert await drained(outbox) == []
    outbox.picture_drawn(2)
    assert await drained(outbox) == [b"panorama 2"]
    outbox.drop_picture(2)
    outbox.picture_drawn(1)
    assert await drained(outbox) == [b"camera 2"]


async def test_sound_keeps_its_order_takes_turns_and_is_bounded() -> None:
    outbox = Outbox()
    for number in range(3):
        outbox.put_sound(bytes([number]))
    outbox.put("status", "s")
    assert await drained(outbox) == [b"\0", "s", b"\1", b"\2"]
    for number in range(MOST_SOUND + 5):
        outbox.put_sound(bytes([number]))
    assert await drained(outbox) == [bytes([number]) for number in range(5, MOST_SOUND + 5)]
    assert outbox.statistics().replaced == 5
    outbox.put_sound(b"x")
    outbox.drop_sound()
    assert await drained(outbox) == []


async def test_taking_waits_for_the_next() -> None:
    outbox = Outbox()
    taking = asyncio.create_task(outbox.take())
    await asyncio.sleep(0)
    assert not taking.done()
    outbox.put("status", "s")
    assert await taking == "s"


puts = st.one_of(
    st.tuples(st.just("put"), st.sampled_from(["status", "lanes", "load"])),
    st.tuples(st.just("urgent"), st.just("")),
    st.tuples(st.just("events"), st.integers(1, 400)),
    st.tuples(st.just("picture"), st.sampled_from([1, 2])),
    st.tuples(st.just("drawn"), st.sampled_from([1, 2])),
    st.tuples(st.just("sound"), st.just("")),
    st.tuples(st.just("take"), st.just("")),
)


@given(st.lists(puts, max_size=200))
def test_whatever_happens_it_stays_bounded(story: list[tuple[str, object]]) -> None:
    async def run() -> None:
        outbox = Outbox()
        for what, how in story:
            match what, how:
                case "put", str(kind):
                    outbox.put(kind, "x")
                case "urgent", _:
                    outbox.put_urgent("x")
                case "events", int(number):
                    outbox.put_each("events", ("{}" for _ in range(number)))
                case "picture", int(kind):
                    outbox.put_picture(kind, b"x")
                case "drawn", int(kind):
                    outbox.picture_drawn(kind)
                case "sound", _:
                    outbox.put_sound(b"x")
                case "take", _ if outbox.statistics().waiting:
                    await outbox.take()
            statistics = outbox.statistics()
            assert statistics.waiting <= MOST_NOTICES + 7
            assert statistics.items <= MOST_ITEMS

    asyncio.run(run())


async def test_at_a_jump_all_of_before_is_dropped_but_notices() -> None:
    outbox = Outbox()
    outbox.put_urgent("notice")
    outbox.put("status", "s1")
    outbox.put_each("events", ['{"id":1}'])
    outbox.put_picture(1, b"old")
    outbox.put_sound(b"old")
    outbox.reset("jump")
    outbox.put("lanes_history", "past")
    outbox.put_each("events", ['{"id":2}'])
    assert await drained(outbox) == ["notice", "jump", "past", '{"type":"events","events":[{"id":2}]}']
    outbox.put_picture(1, b"new")
    assert await drained(outbox) == [b"new"]
