"""How large a picture says it is, read before it is decoded."""

from __future__ import annotations

import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.image_source import TooLarge, declared_size, decoded, kind_of

ENDINGS = {
    "JPEG": [".jpg"], "PNG": [".png"], "WebP": [".webp"], "BMP": [".bmp"], "TIFF": [".tiff"], "GIF": [".gif"],
    "PNM": [".pgm", ".ppm", ".pbm"],
}  # fmt: skip
PIXELS = np.arange(37 * 53 * 3, dtype=np.uint32).astype(np.uint8).reshape(37, 53, 3)


def encoded(ending: str) -> bytes:
    pixels = PIXELS[..., 0] if ending in (".pgm", ".pbm") else PIXELS
    done, data = cv2.imencode(ending, np.ascontiguousarray(pixels))
    assert done
    return data.tobytes()


def png(width: int, height: int) -> bytes:
    """The head of a PNG of this size, and nothing in it."""

    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize(("kind", "ending"), [(kind, ending) for kind, all_ in ENDINGS.items() for ending in all_])
def test_the_size_of_every_kind_is_read_from_its_head(kind: str, ending: str) -> None:
    data = encoded(ending)
    assert kind_of(data) == kind
    assert declared_size(data) == (53, 37)
    found = decoded(data, cv2.IMREAD_COLOR)
    assert found is not None
    assert found.shape == (37, 53, 3)


def test_webp_of_every_kind() -> None:
    lossless = cv2.imencode(".webp", PIXELS, [cv2.IMWRITE_WEBP_QUALITY, 101])[1].tobytes()
    lossy = [cv2.IMWRITE_WEBP_QUALITY, 80]
    opaque = cv2.imencode(".webp", PIXELS, lossy)[1].tobytes()
    clear = cv2.imencode(".webp", np.dstack((PIXELS, PIXELS[..., 0])), lossy)[1].tobytes()
    assert [data[12:16] for data in (lossless, opaque, clear)] == [b"VP8L", b"VP8 ", b"VP8X"]
    for data in (lossless, opaque, clear):
        assert declared_size(data) == (53, 37)
    extended = b"RIFF\x00\x00\x00\x00WEBPVP8X" + struct.pack("<I4xHBHB", 10, 0x1F3F, 1, 36, 0)
    assert declared_size(extended) == (0x11F40, 37)


def test_a_big_endian_tiff_and_an_upside_down_bmp() -> None:
    tiff = b"MM\0*" + struct.pack(">IH", 8, 2) + struct.pack(">HHIHH", 256, 3, 1, 53, 0)
    assert declared_size(tiff + struct.pack(">HHII", 257, 4, 1, 37)) == (53, 37)
    bmp = bytearray(encoded(".bmp"))
    bmp[22:26] = struct.pack("<i", -37)
    assert declared_size(bytes(bmp)) == (53, 37)


def test_a_pgm_with_comments() -> None:
    assert declared_size(b"P5\n# 3 4\n 53 # w\n# h\n37\n255\n") == (53, 37)
    assert declared_size(b"P5\n" + b"# c\n" * 20_000 + b"53 37\n255\n") is None


BOMBS = {
    "PNG": png(60_000, 60_000),
    "PGM": b"P5\n2000000000 2000000000\n255\nxxxx",
    "JPEG": b"\xff\xd8\xff\xe0\x00\x10" + bytes(14) + b"\xff\xff\xc2\x00\x11\x08\xea\x60\xea\x60\x03" + bytes(20),
    "BMP": b"BM" + bytes(12) + struct.pack("<Iii", 40, 60_000, -60_000) + bytes(30),
    "GIF": b"GIF89a" + struct.pack("<HH", 60_000, 60_000) + bytes(30),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_a_picture_that_says_it_is_gigabytes_is_not_decoded(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError("it was decoded")

    monkeypatch.setattr("app.base.image_source.cv2.imdecode", never)
    for data in (BOMBS[kind], np.frombuffer(BOMBS[kind], np.uint8)):
        with pytest.raises(TooLarge, match=r"has \d{5,} x \d{5,} pixels; at most 128 million are decoded"):
            decoded(data, cv2.IMREAD_COLOR)
    with pytest.raises(TooLarge, match=r"53 x 37 pixels; at most 0\.001 million"):
        decoded(encoded(".png"), cv2.IMREAD_COLOR, 1_000)


@given(st.binary(max_size=200), st.sampled_from(sorted(BOMBS)), st.integers(0, 80))
def test_whatever_the_bytes_are_nothing_is_raised_but_too_large(data: bytes, kind: str, kept: int) -> None:
    declared_size(data)
    size = declared_size(BOMBS[kind][:kept] + data)
    assert size is None or min(size) >= 0


def test_what_is_no_picture_or_damaged_is_none() -> None:
    for data in (b"", b"a drawing", encoded(".png")[:40], encoded(".jpg")[:30], b"\x00\x00\x00\x0cjP  \r\n\x87\n"):
        assert decoded(data, cv2.IMREAD_COLOR) is None
