"""How much packed data unpacks to, computed before it is unpacked."""

from __future__ import annotations

from contextlib import suppress

import lz4.frame
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from app.logs.mcap.decompression import TooMuch, check_unpacked, within

MB = 1_000_000


def zstd(content: bytes, *, sized: bool = True, checksum: bool = False) -> bytes:
    packer = zstandard.ZstdCompressor(write_content_size=sized, write_checksum=checksum)
    if sized:
        return packer.compress(content)
    stream = packer.compressobj()
    return stream.compress(content) + stream.flush()


def lz4_(content: bytes, *, sized: bool = True, checksum: bool = False) -> bytes:
    return lz4.frame.compress(content, store_size=sized, content_checksum=checksum, block_checksum=checksum)


PACKERS = {"zstd": zstd, "lz4": lz4_}


@pytest.mark.parametrize("kind", PACKERS)
@pytest.mark.parametrize("sized", [True, False])
@pytest.mark.parametrize("checksum", [True, False])
def test_gigabytes_of_nothing_are_refused_whatever_the_frame_says(kind: str, sized: bool, checksum: bool) -> None:
    packed = PACKERS[kind](bytes(20 * MB), sized=sized, checksum=checksum)
    assert len(packed) < MB
    check_unpacked(within(packed), len(packed), kind, 20 * MB, 22 * MB)
    for data in (packed, packed * 3, b"\x50\x2a\x4d\x18\x03\x00\x00\x00abc" + packed):
        with pytest.raises(TooMuch, match=r"may unpack to [\d.]+ MB; at most 19 MB are unpacked"):
            check_unpacked(within(data), len(data), kind, 0, 19 * MB)
    with pytest.raises(TooMuch):
        check_unpacked(within(packed * 2), 2 * len(packed), kind, 0, 30 * MB)


@pytest.mark.parametrize("kind", ["", "zstd", "lz4"])
def test_what_is_declared_beside_counts_too(kind: str) -> None:
    with pytest.raises(TooMuch, match=r"may unpack to 4\.3 GB; at most 256 MB"):
        check_unpacked(within(b""), 0, kind, 1 << 32)


@given(st.binary(max_size=4000), st.sampled_from(sorted(PACKERS)), st.booleans(), st.booleans(), st.integers(0, 3))
def test_the_bound_is_never_below_what_comes_out(
    content: bytes, kind: str, sized: bool, checksum: bool, repeats: int
) -> None:
    content *= 10**repeats
    packed = PACKERS[kind](content, sized=sized, checksum=checksum)
    if content:
        with pytest.raises(TooMuch):
            check_unpacked(within(packed), len(packed), kind, 0, len(content) - 1)


@given(st.binary(max_size=300), st.sampled_from(sorted(PACKERS)), st.binary(max_size=50))
def test_damage_is_let_pass(content: bytes, kind: str, damage: bytes) -> None:
    packed = PACKERS[kind](content)
    check_unpacked(within(damage), len(damage), "", len(damage))
    for data in (damage, packed[: len(packed) // 2] + damage, packed[:4] + damage):
        with suppress(TooMuch):  # chance may say anything of its size
            check_unpacked(within(data), len(data), kind, 0)
