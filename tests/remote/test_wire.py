"""Envelopes: what comes back, and what is none."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from app.remote import wire
from app.remote.wire import Beat, Data, Handled, Orders, Pulse, Result


@pytest.mark.parametrize(
    "envelope",
    [
        Data("FaceDetector", "images", 7, b"\xff\xd8", {"next track": 12}),
        Orders("FaceDetector", {"fine": True, "min_score": 0.8}, {"faces": True}),
        Beat(3, 1795477318.25, bytes(10)),
    ],
)
def test_what_the_robot_sends_comes_back(envelope: wire.ToNode) -> None:
    assert wire.to_node(wire.encode(envelope)) == envelope


@pytest.mark.parametrize("envelope", [Result("F", "faces", b"x", {"n": 1}), Handled(7), Pulse(3, {"F": "is hung"})])
def test_what_a_node_sends_comes_back(envelope: wire.FromNode) -> None:
    assert wire.from_node(wire.encode(envelope)) == envelope


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        b"text",
        wire.encode(Beat(1, 0.0)),
        msgspec.msgpack.encode({"type": "Result", "module": 1}),
        msgspec.msgpack.encode({"type": "Orders"}),
    ],
)
def test_a_node_is_not_taken_at_its_word(data: bytes) -> None:
    with pytest.raises(wire.BadEnvelope):
        wire.from_node(data)


@pytest.mark.parametrize(
    "kept", [{"next": 2**60}, {"next": "1"}, {"n" * 100: 1}, {str(number): number for number in range(20)}]
)
def test_what_is_kept_is_few_numbers_that_fit(kept: dict[str, Any]) -> None:
    with pytest.raises(wire.BadEnvelope):
        wire.from_node(wire.encode(Result("F", "faces", b"", kept)))
