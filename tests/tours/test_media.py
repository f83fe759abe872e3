"""Pictures and videos beside the tours."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from app.tours import media as module
from app.tours.media import MediaLibrary, NoRoom, ShippedMedia, UnknownMedia
from app.tours.media_content import NotShown
from tests.tours.media_files import mp4, picture


@pytest.fixture
def media(tmp_path: Path) -> MediaLibrary:
    (tmp_path / "shipped" / "media").mkdir(parents=True)
    (tmp_path / "shipped" / "media" / "own.png").write_bytes(picture(shade=1))
    return MediaLibrary((tmp_path / "own", tmp_path / "shipped"))


def keep(media: MediaLibrary, content: bytes, name: str) -> tuple[str, bool]:
    with media.partial(len(content)) as partial:
        partial.write_bytes(content)
        found, is_new = media.keep(partial, name)
        return found.file, is_new


def test_a_file_is_kept_under_a_name_like_its_own(media: MediaLibrary) -> None:
    assert keep(media, picture(), "Été à la mer.PNG") == ("media/Ete-a-la-mer.png", True)
    assert keep(media, picture(), "../../Été à la mer.png") == ("media/Ete-a-la-mer.png", False), "it is there"
    assert keep(media, picture(shade=9), "Été à la mer.png") == ("media/Ete-a-la-mer-2.png", True)
    assert keep(media, picture("jpg"), "photo.jpeg") == ("media/photo.jpeg", True)
    assert keep(media, picture("jpg"), "photo.png") == ("media/photo.jpg", True), "it is called what it is"
    assert keep(media, mp4(), ".mp4") == ("media/video.mp4", True)
    assert keep(media, picture(), "日本") == ("media/picture.png", True)
    assert keep(media, picture(shade=1), "own.png") == ("media/own.png", False), "the program has it"
    assert keep(media, picture(shade=2), "own.png") == ("media/own-2.png", True)
    files = {each.file: each for each in media.listing()}
    assert sorted(files) == [
        *("media/Ete-a-la-mer-2.png", "media/Ete-a-la-mer.png", "media/own-2.png", "media/own.png"),
        *("media/photo.jpeg", "media/photo.jpg", "media/picture.png", "media/video.mp4"),
    ]
    assert (files["media/own.png"].shipped, files["media/video.mp4"].kind.type) == (True, "video/mp4")
    assert files["media/own.png"].size == len(picture(shade=1))
    assert os.stat(media.find("media/own-2.png")[0]).st_mode & 0o777 == 0o644


def test_what_is_refused_leaves_nothing(media: MediaLibrary) -> None:
    with pytest.raises(NotShown):
        keep(media, b"<script>", "page.png")
    with pytest.raises(NotShown):
        keep(media, picture()[:60], "cut.png")
    assert os.listdir(media.folders[0] / "media") == []


def test_there_is_an_end_of_room(media: MediaLibrary, monkeypatch: pytest.MonkeyPatch) -> None:
    free = shutil.disk_usage(media.folders[1]).free
    with pytest.raises(NoRoom, match="disk"), media.partial(free):
        pass
    keep(media, picture(), "one.png")
    monkeypatch.setattr(module, "MOST_FILES", 1)
    with pytest.raises(NoRoom, match="1 pictures and videos"):
        keep(media, picture(), "two.png")


def test_what_a_killed_program_left_is_swept(media: MediaLibrary) -> None:
    keep(media, picture(), "one.png")
    left, fresh = (media.folders[0] / "media" / f".partial-{name}" for name in ("old", "new"))
    left.touch()
    fresh.touch()
    os.utime(left, (0, 0))
    with media.partial(0):
        assert (left.exists(), fresh.exists()) == (False, True)
    assert [each.file for each in media.listing()] == ["media/one.png", "media/own.png"]


def test_only_plain_files_within_the_folder_are_found(media: MediaLibrary, tmp_path: Path) -> None:
    folder = tmp_path / "own"
    folder.mkdir()
    (tmp_path / "secret.png").write_bytes(b"secret")
    (folder / "out.png").symlink_to(tmp_path / "secret.png")
    (folder / "round.png").symlink_to(folder / "round.png")
    (folder / "folder.png").mkdir()
    (folder / "page.html").write_bytes(b"<script>")
    for file in ("out.png", "round.png", "folder.png", "page.html", "gone.png", "../secret.png", "a\0.png", ""):
        with pytest.raises(UnknownMedia):
            media.find(file)
    assert [each.file for each in media.listing()] == ["media/own.png"]


def test_the_programs_own_are_not_deleted(media: MediaLibrary) -> None:
    file, _ = keep(media, picture(), "one.png")
    media.delete(file)
    with pytest.raises(UnknownMedia):
        media.delete(file)
    with pytest.raises(ShippedMedia):
        media.delete("media/own.png")
