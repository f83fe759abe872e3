from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.cli import main
from app.commands.detect.images import DRAWN, SUFFIXES, NoImage, read_image
from app.commands.detect.outputs import find_files
from app.commands.detect.videos import VIDEO_SUFFIXES
from tests.base.test_image_source import BOMBS


def find_images(paths: list[Path]) -> list[Path]:
    return find_files(paths, SUFFIXES | VIDEO_SUFFIXES, "image or video", DRAWN)


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".webp", ".bmp", ".tiff"])
@pytest.mark.parametrize("share", [0.99, 0.5, 0.1])
def test_an_image_that_is_cut_off_is_said_to_be_damaged(tmp_path: Path, suffix: str, share: float) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (60, 80, 3), np.uint8)
    whole = cv2.imencode(suffix, noise)[1].tobytes()
    file = tmp_path / f"cut{suffix}"
    file.write_bytes(whole[: int(len(whole) * share)])
    with pytest.raises(NoImage, match=r"cut\.\w+: is damaged: it begins as a "):
        read_image(file)
    file.write_bytes(whole)
    assert read_image(file).shape == (60, 80, 3)


@pytest.mark.parametrize("kind", BOMBS)
def test_an_image_that_says_it_is_gigabytes_is_refused_and_not_decoded(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "a.jpg"
    file.write_bytes(BOMBS[kind])
    with pytest.raises(NoImage, match=r"a\.jpg: has \d+ x \d+ pixels; at most 128 million are decoded"):
        read_image(file)


@pytest.mark.parametrize("what", ["qr", "faces", "voices"])
def test_a_pipe_in_a_files_place_is_not_waited_for(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    os.mkfifo(tmp_path / "a.jpg")
    array = ["--array", str(paths.config_dir() / "arrays" / "irl1.yaml")] if what == "voices" else []
    assert main(["detect", what, *array, str(tmp_path / "a.jpg")]) != 0
    assert "a.jpg: cannot be read: is a pipe, no regular file" in capsys.readouterr().err


def test_a_gif_is_read_and_reported(tmp_path: Path) -> None:
    file = tmp_path / "a.gif"
    file.write_bytes(cv2.imencode(".gif", np.full((60, 80, 3), 127, np.uint8))[1].tobytes())
    assert read_image(file).shape == (60, 80, 3)
    assert find_images([tmp_path]) == [file]
    file.write_bytes(file.read_bytes()[:20])
    with pytest.raises(NoImage, match="is damaged: it begins as a GIF file"):
        read_image(file)


@pytest.mark.parametrize("what", ["faces", "qr"])
def test_no_name_at_all_is_not_the_current_folder(what: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["detect", what, ""])
    assert "argument FILE: the name of a file is empty" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"", b"no image at all", b"RIFF\x24\0\0\0WAVEfmt "])
def test_what_never_was_an_image_is_not_said_to_be_damaged(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "a.jpg"
    file.write_bytes(content)
    with pytest.raises(
        NoImage, match=r"is no image that can be read here \(JPEG, PNG, WebP, BMP, TIFF, GIF, PNM\), nor a video"
    ):
        read_image(file)


def test_copies_that_were_drawn_on_are_not_searched_again_unless_they_are_named(tmp_path: Path) -> None:
    below = tmp_path / "below"
    below.mkdir()
    names = (
        "x.jpg",
        "x.faces.jpg",
        "x-2.faces.jpg",
        "x.codes.jpg",
        "x.faces.mp4",
        "below/y.png",
        "below/y.faces.jpg",
        "faces.jpg",
    )
    for name in names:
        (tmp_path / name).touch()
    assert find_images([tmp_path]) == [below / "y.png", tmp_path / "faces.jpg", tmp_path / "x.jpg"]
    assert find_images([tmp_path / "x.faces.jpg"]) == [tmp_path / "x.faces.jpg"]
    (below / "y.png").unlink()
    with pytest.raises(ConfigError, match="no image or video in this folder"):
        find_images([below])


@pytest.mark.parametrize("what", ["faces", "qr"])
def test_drawing_into_its_own_folder_twice_finds_the_same_again(
    what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cv2.imwrite(str(tmp_path / "wall.png"), np.full((60, 80, 3), 127, np.uint8))
    for _ in range(2):
        assert main(["detect", what, str(tmp_path), "--draw", str(tmp_path)]) == 1
        assert capsys.readouterr().out.splitlines()[-1].endswith("in 1 image")
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("what", ["faces", "qr"])
def test_drawing_into_a_file_is_refused_in_words(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wall = tmp_path / "wall.png"
    cv2.imwrite(str(wall), np.full((60, 80, 3), 127, np.uint8))
    before = wall.read_bytes()
    assert main(["detect", what, str(wall), "--draw", str(wall)]) == 2
    assert f"--draw: {wall} is a file; give a folder to write into" in capsys.readouterr().err
    assert wall.read_bytes() == before
