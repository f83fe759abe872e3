"""SCIP 2: the examples of its specification, replies in pieces, and every damage noticed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.robots.drivers import scip
from app.robots.simulated.parts.hokuyo_laser import HokuyoLaser


@pytest.mark.parametrize(
    ("characters", "value", "text"), [(2, 1234, b"CB"), (3, 5432, b"1Dh"), (4, 16_000_000, b"m2@0")]
)
def test_the_specifications_own_values(characters: int, value: int, text: bytes) -> None:
    assert scip.decode(text, characters).tolist() == [value]
    assert scip.encode(np.array([value]), characters) == text


def test_a_status_has_the_specifications_own_sum() -> None:
    assert scip.checksum(b"00") == b"P"
    assert scip.checksum(b"99") == b"b"


@given(st.lists(st.integers(0, 64**3 - 1)), st.sampled_from((3, 4)))
def test_values_come_back(values: list[int], characters: int) -> None:
    assert scip.decode(scip.encode(np.array(values, np.int64), characters), characters).tolist() == values


@given(st.integers(0, 4095), st.integers(1, 40))
def test_values_run_on_over_the_ends_of_lines(value: int, count: int) -> None:
    values = np.full(count, value, np.int64)
    lines = scip.data_lines(77, scip.encode(values, 3))
    reply = scip.parse(scip.reply_bytes(f"MD0000{count - 1:04d}01000", "99", lines)[:-2], 0.0)
    taken = scip.measurement(reply)
    assert taken.milliseconds == 77
    assert taken.distances.tolist() == values.tolist()


def replies(data: bytes, *sizes: int) -> list[scip.Reply]:
    """The replies in ``data``, which comes in pieces of ``sizes``, the last one for the rest."""
    reader, found = scip.ReplyReader(), []
    for size in sizes:
        found += reader.feed(data[:size], 1.0)
        data = data[size:]
    return found + reader.feed(data, 2.0)


@given(st.lists(st.integers(1, 200), max_size=20))
def test_replies_in_pieces_of_any_size(sizes: list[int]) -> None:
    laser = HokuyoLaser()
    data = laser.receive(b"VV\nPP\nBM\nMD0000010001000\n", 0.0) + laser.scan(0.5)
    found = replies(data, *sizes)
    assert [reply.code for reply in found] == ["VV", "PP", "BM", "MD", "MD"]
    assert scip.table(found[0])["PROD"] == "UST-10LX"
    laser_geometry = scip.geometry(scip.table(found[1]))
    assert (laser_geometry.first, laser_geometry.front, laser_geometry.last) == (0, 540, 1080)
    assert laser_geometry.within(np.pi) == (180, 900)
    assert scip.measurement(found[-1]).distances.size == 101


@given(st.integers(0, 10_000), st.integers(1, 63))
def test_a_changed_byte_never_passes_for_a_distance(place: int, change: int) -> None:
    laser = HokuyoLaser()
    laser.receive(b"MD0000002001000\n", 0.0)
    laser.distances = np.arange(1081, dtype=np.int64) + 700
    data = bytearray(laser.scan(0.25))
    data[place % len(data)] ^= change
    for reply in replies(bytes(data)):
        if reply.command != "MD0000002001000":
            continue  # of another command, and so no scan
        try:
            taken = scip.measurement(reply)
        except scip.Garbled:
            continue
        # What is left is a change of the kind that no sum notices: none of one byte.
        assert taken.distances.tolist() == (np.arange(21) + 700).tolist()
        assert reply.status == "99"
        assert taken.milliseconds == 250


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"MD", "no reply"),
        (b"MD0000000001000\n00Q", "sum"),
        (b"MD0000000001000\n0P", "sum"),
        (b"\xff\xfe\n00P", "no reply"),
        (b"PP\n00P\nDMIN:20;x", "sum"),
    ],
)
def test_what_is_no_reply_is_refused(data: bytes, said: str) -> None:
    with pytest.raises(scip.Garbled, match=said):
        scip.parse(data, 0.0)


def test_noise_without_an_end_is_dropped() -> None:
    reader = scip.ReplyReader()
    for _ in range(40):
        assert reader.feed(bytes(4096), 0.0) == []
    assert reader.garbled >= 2
    assert [reply.code for reply in reader.feed(b"\n\nQT\n00P\n\n", 0.0)] == ["QT"]


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({}, "does not say DMIN"),
        (dict.fromkeys(("DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN"), "many"), "no numbers"),
        (dict.fromkeys(("DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN"), "5"), "impossible"),
    ],
)
def test_an_impossible_laser_is_refused(values: dict[str, str], said: str) -> None:
    with pytest.raises(scip.Garbled, match=said):
        scip.geometry(values)


def test_requests_of_each_kind() -> None:
    assert scip.scan_command(0, 1080) == "MD0000108001000"
    assert scip.scan_command(44, 725, characters=2) == "MS0044072501000"
    assert scip.scan_command(0, 1080, intensities=True) == "ME0000108001000"
    assert scip.scan_command(0, 1080, single=True) == "GD0000108001"
    with pytest.raises(ValueError, match="2 or 3"):
        scip.scan_command(0, 1, characters=2, intensities=True)
