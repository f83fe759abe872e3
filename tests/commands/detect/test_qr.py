from __future__ import annotations

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.cli import main
from tests.scenery.posters import KINECT, PANORAMA, TEXT, facing_camera, picture


def write(path: Path, image: np.ndarray) -> str:
    assert cv2.imwrite(str(path), image[..., ::-1])
    return str(path)


def test_codes_are_reported_with_their_corners_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with_code = write(tmp_path / "door.png", picture(KINECT, {TEXT: facing_camera(1.0)}))
    without = write(tmp_path / "wall.png", picture(KINECT, {}))
    assert main(["detect", "qr", "--json", "--draw", str(tmp_path / "drawn"), with_code, without]) == 0
    door, wall = json.loads(capsys.readouterr().out)["files"]
    assert (door["width"], door["height"]) == (640, 480)
    (code,) = door["codes"]
    assert code["text"] == TEXT
    half = 589 * 0.09
    expected = [(-half, -half), (half, -half), (half, half), (-half, half)]
    np.testing.assert_allclose(code["corners"], np.array(expected) + np.array((319.5, 239.5)), atol=3)
    assert wall["codes"] == []
    assert {p.name for p in (tmp_path / "drawn").iterdir()} == {"door.codes.jpg", "wall.codes.jpg"}


def test_a_table_for_people_and_one_when_nothing_was_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wall = write(tmp_path / "wall.png", picture(KINECT, {}))
    assert main(["detect", "qr", wall]) == 1
    assert capsys.readouterr().out.splitlines() == [f"{wall}  no code", "0 codes in 1 image"]


def test_a_fisheyes_image_is_read_far_from_its_middle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    far = write(tmp_path / "far.png", picture(PANORAMA, {TEXT: facing_camera(1.0, math.radians(75))}))
    assert main(["detect", "qr", "--fisheye", far]) == 0
    assert TEXT in capsys.readouterr().out


def test_what_cannot_be_read_is_said_and_the_rest_is_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.png").write_text("no image")
    good = write(tmp_path / "b.png", picture(KINECT, {TEXT: facing_camera(1.0)}))
    assert main(["detect", "qr", str(tmp_path / "a.png"), good]) == 2
    output = capsys.readouterr()
    assert TEXT in output.out
    assert "a.png: is no image that can be read here" in output.err
    assert main(["detect", "qr", str(tmp_path / "missing.png")]) == 2
    assert "there is no file or folder" in capsys.readouterr().err
