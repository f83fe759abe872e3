"""A tour and its media as one file, from one robot to another."""

from __future__ import annotations

import io
import os
import zipfile
from pathlib import Path

import pytest

from app.tours import archive
from app.tours.archive import BadArchive, packed, unpacked
from app.tours.checks import media_of
from app.tours.consistency import tour_of
from app.tours.media import MediaLibrary
from app.tours.media_content import Kind
from app.tours.model import Tour
from tests.tours.media_files import mp4, picture, showing
from tests.tours.tours import ARM, tour_data

FILES = {"media/arm.png": picture(shade=7), "robots/walk.mp4": mp4()}


def tour_showing(*files: str) -> Tour:
    return tour_of(tour_data(stops=[ARM | {"do": showing(*files)}]))


def filled(folder: Path, files: dict[str, bytes]) -> MediaLibrary:
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return MediaLibrary((folder,))


def zipped(path: Path, files: dict[str, bytes | str], how: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", how) as target:
        for name, content in files.items():
            target.writestr(name, content)
    return path


def shown(tour: Tour) -> list[str]:
    return [file for _, file in media_of(tour)]


def test_another_robot_has_the_tour_and_its_media(tmp_path: Path) -> None:
    here, there = filled(tmp_path / "here", FILES), MediaLibrary((tmp_path / "there",))
    tour = tour_showing(*FILES, "media/missing.png", "media/arm.png")
    file = tmp_path / "tour.zip"
    file.write_bytes(b"".join(packed(tour, here)))
    assert sorted(zipfile.ZipFile(file).namelist()) == sorted([f"{tour.id}.yaml", *FILES])
    come = unpacked(file, there, lambda each: each)
    assert shown(come) == ["media/arm.png", "media/walk.mp4", "media/missing.png", "media/arm.png"]
    assert [there.find(name)[0].read_bytes() for name in shown(come)[:2]] == list(FILES.values())
    assert unpacked(file, there, lambda each: each) == come, "once more is the same"
    assert len(there.listing()) == 2
    assert unpacked(file, here, lambda each: each) == tour, "where all is there already, nothing changes"


def test_another_picture_of_the_same_name_stays(tmp_path: Path) -> None:
    there = filled(tmp_path, {"media/arm.png": picture(shade=8)})
    file = tmp_path / "tour.zip"
    tour = tour_showing("media/arm.png")
    file.write_bytes(b"".join(packed(tour, filled(tmp_path / "here", FILES))))
    assert shown(unpacked(file, there, lambda each: each)) == ["media/arm-2.png"]
    assert there.find("media/arm.png")[0].read_bytes() == picture(shade=8)


def test_where_the_tour_is_refused_no_media_are_kept(tmp_path: Path) -> None:
    there = filled(tmp_path, {"media/arm.png": FILES["media/arm.png"]})
    file = tmp_path / "tour.zip"
    file.write_bytes(b"".join(packed(tour_showing(*FILES), filled(tmp_path / "here", FILES))))

    def refuse(tour: Tour) -> None:
        assert there.find("media/walk.mp4")
        raise KeyError(tour.id)

    with pytest.raises(KeyError):
        unpacked(file, there, refuse)
    assert os.listdir(tmp_path / "media") == ["arm.png"], "what was there before stays"


def yaml_of(tour: Tour, folder: Path) -> str:
    content = b"".join(packed(tour, MediaLibrary((folder,))))
    return zipfile.ZipFile(io.BytesIO(content)).read(f"{tour.id}.yaml").decode()


def test_a_folder_that_people_packed_is_read_too(tmp_path: Path) -> None:
    text = yaml_of(tour_showing("media/arm.png"), tmp_path)
    file = zipped(
        tmp_path / "a.zip",
        {"my tour/tour.yaml": text, "my tour/media/arm.png": picture(), "__MACOSX/tour.yaml": b"", "else.png": b""},
    )
    library = MediaLibrary((tmp_path / "own",))
    assert shown(unpacked(file, library, lambda each: each)) == ["media/arm.png"]
    assert [each.file for each in library.listing()] == ["media/arm.png"]


def test_what_is_no_archive_of_a_tour_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = MediaLibrary((tmp_path / "own",))
    text = yaml_of(tour_showing("media/arm.png"), tmp_path)

    def refused(files: dict[str, bytes | str], words: str, how: int = zipfile.ZIP_DEFLATED) -> None:
        with pytest.raises(BadArchive, match=words):
            unpacked(zipped(tmp_path / "a.zip", files, how), library, lambda each: each)
        assert library.listing() == ()

    refused({}, "not none")
    refused({"a.yaml": text, "b.yaml": text}, r"not a\.yaml, b\.yaml")
    refused({"a.yaml": b"#" * 1_000_001}, "more than 1000 kB")
    refused({"a.yaml": text, "media/arm.png": b"<script>"}, r"media/arm\.png is no picture")
    refused({"a.yaml": text, "media/arm.png": picture()[:60]}, "damaged picture")
    refused({"a.yaml": text}, "packed in a manner", zipfile.ZIP_LZMA)
    refused({f"{n}.txt": b"" for n in range(2001)}, "at most 2000")
    monkeypatch.setattr(archive, "LARGEST_BYTES", 50)
    refused({"a.yaml": text, "media/arm.png": picture()}, "archive's media")
    monkeypatch.setattr(archive, "LARGEST_BYTES", 10**6)
    monkeypatch.setattr(Kind, "largest_bytes", 40)
    refused({"a.yaml": text, "media/arm.png": picture()}, "larger than")
    (tmp_path / "a.zip").write_bytes(b"PK\x03\x04 no more")
    with pytest.raises(BadArchive, match="damaged"):
        unpacked(tmp_path / "a.zip", library, lambda each: each)
