from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.modules.viewers.ros2.protocol import Answer, Frames, Open, Publish, Service, Stop, Topic, ToProcess, encode

MESSAGES: tuple[Open | Publish | Answer | Stop, ...] = (
    Open("hbba", None, (("a_msgs/msg/A", "float64 x\n"),), (Topic("/a", "a_msgs/msg/A", latched=True),),
         (Service("/s", "a_msgs/srv/S", "", "bool ok\n"),)),
    Publish(3, bytes(range(256))),
    Answer(7, b""),
    Stop(),
)  # fmt: skip


@given(st.lists(st.integers(1, 400), max_size=20))
def test_frames_come_as_they_were_sent_however_the_stream_is_cut(cuts: list[int]) -> None:
    stream = b"".join([encode(message) for message in MESSAGES])
    frames, found = Frames(ToProcess), []  # type: ignore[arg-type]  # a union of types
    for cut in (*cuts, len(stream)):
        found += frames.feed(stream[:cut])
        stream = stream[cut:]
    assert tuple(found) == MESSAGES
