"""Faces and codes in people's videos."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.base.geometry import Pose2
from app.cli import main
from app.commands.detect.videos import NoVideo, VideoFile, is_video
from tests.scenery.face_scenes import facing, kinect_image
from tests.scenery.posters import KINECT, TEXT, facing_camera, picture

RATE_HZ = 10.0
KINDS = {".mp4": "mp4v", ".avi": "MJPG", ".webm": "VP80", ".mkv": "mp4v"}


def write(path: Path, frames: list[np.ndarray], rate_hz: float = RATE_HZ) -> Path:
    """A video of pictures (H, W, 3) RGB."""
    size = (frames[0].shape[1], frames[0].shape[0])
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*KINDS[path.suffix]), rate_hz, size)
    assert writer.isOpened()
    for frame in frames:
        writer.write(np.ascontiguousarray(frame[..., ::-1]))
    writer.release()
    return path


def grey(count: int, level: int = 127) -> list[np.ndarray]:
    """Pictures of 320 x 240 of noise, without a face or a code."""
    rng = np.random.default_rng(level)
    return [rng.integers(level - 20, level + 20, (240, 320, 3), np.uint8) for _ in range(count)]


def nothing(done: float, total: float, text: str = "") -> None: ...


@pytest.fixture(scope="module")
def people() -> list[np.ndarray]:
    """Two people; from the fourth of eight frames on the left one is gone."""
    both = [facing("pilot", (1.5, 0.3, 1.5)), facing("visitor", (1.6, -0.3, 1.4))]
    return [kinect_image(0, Pose2(), both if number < 3 else both[1:]).color for number in range(8)]


@pytest.mark.parametrize("suffix", list(KINDS))
def test_every_kind_is_read_frame_by_frame_with_its_times(suffix: str, tmp_path: Path) -> None:
    video = VideoFile(write(tmp_path / f"video{suffix}", grey(7)))
    frames = list(video.frames(None, None, nothing))
    assert [time_s for time_s, _ in frames] == pytest.approx([0.1 * number for number in range(7)], abs=2e-3)
    assert {frame.shape for _, frame in frames} == {(240, 320, 3)}
    assert (video.width, video.height, video.end_s) == (320, 240, pytest.approx(0.7, abs=2e-3))


def test_every_nth_frame_or_so_many_a_second(tmp_path: Path) -> None:
    file = write(tmp_path / "video.mp4", grey(10))

    def times(every: int | None, fps: float | None) -> list[float]:
        return [round(time_s, 2) for time_s, _ in VideoFile(file).frames(every, fps, nothing)]

    assert times(4, None) == [0, 0.4, 0.8]
    assert times(None, 5) == [0, 0.2, 0.4, 0.6, 0.8]
    assert times(None, 3) == [0, 0.4, 0.7]
    assert len(times(None, 100)) == 10


def test_a_video_is_known_by_its_beginning_and_by_its_name(tmp_path: Path) -> None:
    nameless = write(tmp_path / "video.webm", grey(2)).rename(tmp_path / "upload")
    assert is_video(nameless)
    assert is_video(tmp_path / "missing.MOV")
    image = tmp_path / "image"
    image.write_bytes(cv2.imencode(".png", grey(1)[0])[1].tobytes())
    assert not is_video(image)


def test_a_video_that_breaks_off_is_reported_with_its_detections_before(
    tmp_path: Path, people: list[np.ndarray], capsys: pytest.CaptureFixture[str]
) -> None:
    whole = write(tmp_path / "whole.avi", people * 4).read_bytes()
    cut = tmp_path / "cut.avi"
    cut.write_bytes(whole[: len(whole) // 2])
    assert main(["detect", "faces", "--json", str(cut)]) == 2
    said = capsys.readouterr()
    (document,) = json.loads(said.out)["files"]
    assert document["error"].startswith("breaks off at 1.")
    assert document["error"].endswith(" s of 3.2 s")
    assert f"{cut}: {document['error']}" in said.err
    assert 1.0 < document["duration_s"] < 2.2
    assert len(document["frames"]) == document["frames_looked_at"] > 10
    assert document["tracks"]


@pytest.mark.parametrize("content", [b"", b"no video at all", b"\0\0\0\x20ftypisom" + bytes(100)])
def test_what_is_no_video_is_said_in_words(content: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "video.mp4"
    file.write_bytes(content)
    with pytest.raises(NoVideo, match=r"is empty|cannot be read as a video"):
        VideoFile(file)
    assert main(["detect", "qr", str(file)]) == 2
    said = capfd.readouterr()
    assert said.err.splitlines()[-1].startswith(f"hbba detect qr: {file}: ")
    assert "Traceback" not in said.err


def test_faces_keep_their_numbers_through_a_video(
    tmp_path: Path, people: list[np.ndarray], capsys: pytest.CaptureFixture[str]
) -> None:
    file = write(tmp_path / "people.mp4", people)
    assert main(["detect", "faces", "--json", str(file)]) == 0
    (document,) = json.loads(capsys.readouterr().out)["files"]
    assert (document["width"], document["height"], document["duration_s"]) == (640, 480, 0.8)
    frames = document["frames"]
    assert [frame["time_s"] for frame in frames] == pytest.approx([0.1 * number for number in range(8)])
    numbers = [{face["track"] for face in frame["faces"]} for frame in frames]
    assert numbers[:3] == [{1, 2}] * 3
    assert len(set.union(*numbers[3:])) == 1
    stays = numbers[-1].pop()
    by_number = {track["track"]: track for track in document["tracks"]}
    assert {number: track["frames"] for number, track in by_number.items()} == {stays: 8, 3 - stays: 3}
    assert (by_number[stays]["begin_s"], by_number[stays]["end_s"]) == (0.0, 0.7)
    left = [face["box"][0] for frame in frames for face in frame["faces"] if face["track"] == stays]
    assert np.ptp(left) < 5


def test_a_table_of_photographs_and_videos_of_a_folder(
    tmp_path: Path, people: list[np.ndarray], capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "people.mp4", people)
    write(tmp_path / "wall.webm", grey(3))
    cv2.imwrite(str(tmp_path / "photo.png"), people[0][..., ::-1])
    out = tmp_path / "drawn"
    assert main(["detect", "faces", str(tmp_path), "--every", "2", "--draw", str(out)]) == 0
    *rows, last = capsys.readouterr().out.splitlines()
    assert last == "4 faces in 1 image and 2 videos"
    assert [row.split()[0] for row in rows if "people.mp4" in row] == [str(tmp_path / "people.mp4")] * 2
    assert any(row.endswith("no face") and "wall.webm" in row for row in rows)
    assert {path.name for path in out.iterdir()} == {"people.faces.mp4", "photo.faces.jpg", "wall.faces.mp4"}
    copy = VideoFile(out / "people.faces.mp4")
    drawn = list(copy.frames(None, None, nothing))
    assert [time_s for time_s, _ in drawn] == pytest.approx([0, 0.2, 0.4, 0.6], abs=0.01)
    assert np.abs(drawn[0][1].astype(int) - people[0]).max() > 60


def test_codes_in_a_video_are_reported_with_begin_and_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shown, hidden = picture(KINECT, {TEXT: facing_camera(1.0)}), picture(KINECT, {})
    file = write(tmp_path / "door.mp4", [hidden] * 2 + [shown] * 3 + [hidden])
    assert main(["detect", "qr", str(file)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f'{file}  "{TEXT}"  0.2 to 0.4 s, 3 frames',
        "1 code in 1 video",
    ]
    assert main(["detect", "qr", "--json", "--draw", str(tmp_path / "drawn"), str(file)]) == 0
    (document,) = json.loads(capsys.readouterr().out)["files"]
    assert [len(frame["codes"]) for frame in document["frames"]] == [0, 0, 1, 1, 1, 0]
    assert np.shape(document["frames"][2]["codes"][0]["corners"]) == (4, 2)
    assert (tmp_path / "drawn" / "door.codes.mp4").is_file()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--every", "0"], "must be a whole number from 1, not '0'"),
        (["--fps", "none"], "must be a number of frames a second up to 1000, not 'none'"),
        (["--every", "2", "--fps", "2"], "not allowed with argument"),
    ],
)
def test_a_pace_that_is_none(options: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["detect", "qr", "video.mp4", *options])
    assert said in capsys.readouterr().err
