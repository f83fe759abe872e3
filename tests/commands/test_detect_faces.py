from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.base.geometry import Pose2
from app.cli import main
from tests.scenery.face_scenes import facing, kinect_image


@pytest.fixture(scope="module")
def scene() -> np.ndarray:
    """A picture (480, 640, 3) BGR of two faces."""
    cards = [facing("pilot", (1.5, 0.3, 1.5)), facing("visitor", (1.6, -0.3, 1.4))]
    return cv2.cvtColor(kinect_image(0, Pose2(), cards).color, cv2.COLOR_RGB2BGR)


def write(path: Path, picture: np.ndarray) -> Path:
    assert cv2.imwrite(str(path), picture)
    return path


def test_a_table_for_people(scene: np.ndarray, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path / "both.png", scene)
    write(tmp_path / "none.jpg", np.full((200, 300, 3), 127, np.uint8))
    assert main(["detect", "faces", str(tmp_path)]) == 0
    header, *rows, summary = capsys.readouterr().out.splitlines()
    assert header.split() == ["file", "score", "left", "top", "width", "height"]
    assert [Path(row.split()[0]).name for row in rows] == ["both.png", "both.png", "none.jpg"]
    assert rows[2].endswith("no face")
    assert summary == "2 faces in 2 images"


def test_json_for_machines(scene: np.ndarray, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(tmp_path / "both.png", scene)
    assert main(["detect", "faces", str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["threshold"] == 0.8
    (entry,) = said["files"]
    assert (entry["file"], entry["width"], entry["height"]) == (str(file), 640, 480)
    for face in entry["faces"]:
        left, top, width, height = face["box"]
        assert 0.8 <= face["score"] <= 1
        assert list(face["landmarks"]) == ["right_eye", "left_eye", "nose", "mouth_right", "mouth_left"]
        assert all(left < u < left + width and top < v < top + height for u, v in face["landmarks"].values())
        assert face["landmarks"]["right_eye"][0] < face["landmarks"]["left_eye"][0]


def test_a_photograph_taken_upright_is_read_upright(
    scene: np.ndarray, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, jpeg = cv2.imencode(".jpg", cv2.rotate(scene, cv2.ROTATE_90_COUNTERCLOCKWISE))
    # EXIF with the one entry Orientation = 6: to be turned by 90 degrees clockwise.
    exif = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
    file = tmp_path / "upright.jpg"
    file.write_bytes(b"\xff\xd8\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif + jpeg.tobytes()[2:])
    assert main(["detect", "faces", str(file), "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)["files"]
    assert (entry["width"], entry["height"], len(entry["faces"])) == (640, 480, 2)


def test_faces_are_framed_in_copies(scene: np.ndarray, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        write(tmp_path / folder / "both.png", scene)
    out = tmp_path / "drawn" / "here"
    assert main(["detect", "faces", str(tmp_path / "a"), str(tmp_path / "b"), "--draw", str(out)]) == 0
    assert sorted(p.name for p in out.iterdir()) == ["both-2.faces.jpg", "both.faces.jpg"]
    drawn = cv2.imread(str(out / "both.faces.jpg"))
    assert drawn is not None
    assert drawn.shape == scene.shape
    assert np.abs(drawn.astype(int) - scene).max() > 100


def test_no_face_is_exit_code_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write(tmp_path / "none.png", np.full((200, 300, 3), 127, np.uint8))
    assert main(["detect", "faces", str(file)]) == 1
    assert "0 faces in 1 image" in capsys.readouterr().out


def test_files_that_are_no_images_are_named_and_the_others_read(
    scene: np.ndarray, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = write(tmp_path / "both.png", scene)
    (tmp_path / "notes.txt").write_text("not a picture")
    (tmp_path / "empty.jpg").write_bytes(b"")
    assert main(["detect", "faces", str(tmp_path / "notes.txt"), str(tmp_path), "--json"]) == 2
    captured = capsys.readouterr()
    assert "notes.txt: is no image that can be read here" in captured.err
    assert "empty.jpg: is no image" in captured.err
    by_name = {Path(entry["file"]).name: entry for entry in json.loads(captured.out)["files"]}
    assert len(by_name[good.name]["faces"]) == 2
    assert by_name["notes.txt"]["error"].startswith("is no image")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere.jpg"], "there is no file or folder nowhere.jpg"),
        (["."], "there is no image or video in this folder or below"),
        (["x.png", "--threshold", "2"], "must be a number from 0 to 1, not '2'"),
        ([], "FILE"),
    ],
)
def test_mistakes_are_said_in_words(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    code: object
    try:
        code = main(["detect", "faces", *arguments])
    except SystemExit as ended:
        code = ended.code
    assert code == 2
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error


def test_the_threshold_can_be_set(scene: np.ndarray, tmp_path: Path) -> None:
    assert main(["detect", "faces", str(write(tmp_path / "both.png", scene)), "--threshold", "0.99"]) == 1
