"""The protocol of docs/serial-base.md: its own examples, frames in pieces, and every damage noticed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.robots.drivers import base_protocol as protocol
from app.robots.drivers.base_protocol import Battery, Fault, Frame, FrameReader, Hello, Identity, State, Text, Velocity

DOCUMENT = Path(__file__).parents[3] / "docs" / "serial-base.md"
EXAMPLES: dict[str, tuple[Frame, int]] = {
    "HELLO": (Hello(), 1),
    "VELOCITY": (Velocity(200, -300, 200), 2),
    "IDENTITY": (Identity(1, 7, 600, 2000, ticks_per_m=20000, track_um=300000, name="mine"), 1),
    "STATE": (State(1500000, 4000, -12, taken=2, faults=Fault.EMERGENCY_BUTTON), 3),
    "BATTERY": (Battery(12440, -800, 90, charging=False), 4),
    "TEXT": (Text("hi"), 5),
}
frames = st.one_of(
    st.builds(Hello, st.integers(0, 255)),
    st.builds(
        Velocity, st.integers(-32768, 32767), st.integers(-32768, 32767), st.integers(0, 65535), brake=st.booleans()
    ),
    st.builds(
        State, st.integers(0, 2**32 - 1), st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1),
        taken=st.integers(0, 255), faults=st.sampled_from(Fault) | st.just(Fault(0)),
    ),
    st.builds(
        Battery, st.integers(0, 65535), st.integers(-32768, 32767), st.integers(0, 100) | st.none(),
        charging=st.booleans(),
    ),
    st.builds(Text, st.text("abc \0é", max_size=20)),
)  # fmt: skip


def test_the_documents_examples_are_these_bytes() -> None:
    rows = re.findall(r"^\| `([A-Z]+)` \|.*\| `([0-9a-f ]+)` \|$", DOCUMENT.read_text("utf-8"), re.MULTILINE)
    assert {name for name, _ in rows} == set(EXAMPLES)
    for name, text in rows:
        frame, sequence = EXAMPLES[name]
        assert bytes.fromhex(text) == protocol.encode(frame, sequence), name
        assert FrameReader().feed(bytes.fromhex(text)) == [(frame, sequence)]


def test_the_crc_is_the_one_that_is_named() -> None:
    assert protocol.crc(b"123456789") == 0x29B1  # the check value of CRC-16/CCITT-FALSE


@given(st.binary(max_size=700))
def test_stuffing_has_no_zero_and_comes_back(data: bytes) -> None:
    assert 0 not in protocol.stuffed(data)
    assert protocol.unstuffed(protocol.stuffed(data)) == data


@given(st.lists(st.tuples(frames, st.integers(0, 255)), max_size=5), st.lists(st.integers(1, 30), max_size=30))
def test_frames_in_pieces_of_any_size(sent: list[tuple[Frame, int]], sizes: list[int]) -> None:
    reader, found = FrameReader(), []
    data = b"".join(protocol.encode(*each) for each in sent)
    for size in sizes:
        found += reader.feed(data[:size])
        data = data[size:]
    assert found + reader.feed(data) == sent
    assert reader.garbled == 0


@given(frames, st.integers(0, 10_000), st.integers(1, 255))
def test_a_changed_byte_is_noticed_and_the_next_frame_is_right(frame: Frame, place: int, change: int) -> None:
    data = bytearray(protocol.encode(frame, 9))
    data[place % len(data)] ^= change
    reader = FrameReader()
    found = reader.feed(bytes(data) + protocol.END + protocol.encode(Hello(), 10))
    assert found == [(Hello(), 10)]
    assert reader.garbled >= 1


@given(st.binary(max_size=400))
def test_noise_is_never_a_reason_to_fail(data: bytes) -> None:
    reader = FrameReader()
    reader.feed(data)
    assert reader.feed(protocol.END + protocol.encode(Hello(), 1))[-1] == (Hello(), 1)


def test_a_frame_without_an_end_is_not_kept_for_ever() -> None:
    reader = FrameReader()
    for _ in range(50):
        assert reader.feed(b"\x55" * 100) == []
    assert reader.garbled == 1
    assert len(reader._buffer) <= protocol.MOST_FRAME


@pytest.mark.parametrize(
    ("body", "said"),
    [(b"\x7f\x01", "no frame of type 0x7f"), (b"\x02\x01\x00", "has 1 bytes"), (b"\x01\x01\x01\x01", "has 2 bytes")],
)
def test_frames_of_another_shape_are_refused(body: bytes, said: str) -> None:
    whole = body + protocol.crc(body).to_bytes(2, "little")
    with pytest.raises(protocol.Garbled, match=said):
        protocol.decode(protocol.stuffed(whole))
