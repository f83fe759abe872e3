"""Frames over a socket pair: whole however they are cut, and no writer ever waits."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.robots.simulated import link_protocol


@pytest.fixture
def pair() -> Iterator[tuple[link_protocol.Socket, socket.socket]]:
    ours, theirs = socket.socketpair()
    link = link_protocol.Socket(ours, capacity=8)
    theirs.setblocking(False)
    yield link, theirs
    link.close()
    theirs.close()


@given(st.lists(st.floats(allow_nan=False), max_size=20), st.lists(st.integers(1, 400), max_size=60))
def test_frames_survive_any_cutting(values: list[float], cuts: list[int]) -> None:
    frames = [link_protocol.DriveRequest(v, v, -v) for v in values]
    data = b"".join(link_protocol.encode(frame) for frame in frames)
    reader, got = link_protocol.FrameReader(), []
    for cut in [*cuts, len(data)]:
        got += reader.feed(data[:cut])
        data = data[cut:]
    assert got == frames


def test_a_reader_that_is_frozen_costs_the_oldest_frames_and_no_waiting(
    pair: tuple[link_protocol.Socket, socket.socket],
) -> None:
    link, theirs = pair
    sent = 4000
    for i in range(sent):
        link.send(link_protocol.Sample("odometry", i))
        link.flush()
    assert link.has_unsent
    assert link.dropped > 0
    reader, got = link_protocol.FrameReader(), []
    while True:
        try:
            got += reader.feed(theirs.recv(65536))
        except BlockingIOError:
            if not link.has_unsent:
                break
        link.flush()
    numbers = [sample.message for sample in got]
    assert numbers == sorted(numbers)
    assert numbers[-1] == sent - 1  # the newest is never the one that is lost
    assert len(numbers) == sent - link.dropped


def test_what_arrived_is_read_and_the_end_is_noticed(pair: tuple[link_protocol.Socket, socket.socket]) -> None:
    link, theirs = pair
    assert link.receive() == []
    theirs.send(link_protocol.encode(link_protocol.EStopRequest("x")) + link_protocol.encode(link_protocol.Stop()))
    assert link.receive() == [link_protocol.EStopRequest("x"), link_protocol.Stop()]
    theirs.close()
    assert link.receive() == []
    assert link.closed


def test_writing_to_a_closed_socket_is_noticed_and_no_error(pair: tuple[link_protocol.Socket, socket.socket]) -> None:
    link, theirs = pair
    theirs.close()
    link.send(link_protocol.Stop())
    link.flush()
    assert link.closed
