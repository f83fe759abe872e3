"""What a file is, by its content."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from app.tours import media_content
from app.tours.media_content import Kind, NotShown, TooLarge, checked, kind_of_head, kind_of_name
from tests.tours.media_files import box, element, mp4, picture, webm


@pytest.mark.parametrize(
    ("content", "type_"),
    [
        (picture("png"), "image/png"),
        (picture("jpg"), "image/jpeg"),
        (picture("webp"), "image/webp"),
        (mp4(), "video/mp4"),
        (webm(), "video/webm"),
    ],
)
def test_a_whole_file_is_what_its_content_says(content: bytes, type_: str, tmp_path: Path) -> None:
    (tmp_path / "called.txt").write_bytes(content)
    assert checked(tmp_path / "called.txt").type == type_
    assert kind_of_head(content[:64]).type == type_
    # A PNG has all its pixels before its end mark and two check sums; what has them is shown.
    whole = len(content) - (20 if type_ == "image/png" else 0)
    for end in itertools.chain(range(0, whole, 1 + len(content) // 40), (whole - 1,)):
        (tmp_path / "cut").write_bytes(content[:end])
        with pytest.raises(NotShown):
            checked(tmp_path / "cut")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"<svg xmlns='http://www.w3.org/2000/svg'/>", "no picture"),
        (b"<html><script>", "no picture"),
        (b"", "empty"),
        (mp4(b"qt  "), "QuickTime"),
        (mp4(b"heic"), "HEIC"),
        (webm(b"matroska"), "Matroska"),
        (box(b"ftyp", b"isom") + box(b"mdat", b"x"), "lacks"),
        (box(b"ftyp", b"isom") + b"\x00\x00\x00\x02moov", "end is missing"),
        (element(b"\x1a\x45\xdf\xa3", element(b"\x42\x82", b"webm")) + bytes(40), "damaged"),
    ],
)
def test_what_is_not_shown_says_why(content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(content)
    with pytest.raises(NotShown, match=words):
        checked(tmp_path / "file")


def test_what_is_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wide").write_bytes(picture(width=100))
    monkeypatch.setattr(media_content, "MOST_PIXELS", 2399)
    with pytest.raises(NotShown, match="100 x 24 pixels"):
        checked(tmp_path / "wide")
    monkeypatch.setattr(media_content, "LARGEST_PICTURE_BYTES", 20)
    with pytest.raises(TooLarge, match="larger than"):
        checked(tmp_path / "wide")
    Kind("mp4").check_size(21)


def test_an_ending_says_what_a_file_should_be() -> None:
    assert kind_of_name("media/a.JPG") == Kind("jpg")
    assert kind_of_name("page.html") is None
    assert kind_of_name("jpg.") is None
