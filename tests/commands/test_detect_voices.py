from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from app.cli import main
from tests.modules.perception.voices.sounds import ARRAY, RATE, as_int16, babble, heard, toward


@pytest.fixture(scope="module")
def talker() -> NDArray[np.int16]:
    """A talker to the left for 2 s."""
    sound = heard(babble(0, 2.0), toward(60))
    return as_int16(sound + np.random.default_rng(1).normal(0, 1e-3, sound.shape))


@pytest.fixture
def array(tmp_path: Path) -> str:
    path = tmp_path / "array.yaml"
    path.write_text(f"positions: {ARRAY.positions.tolist()}\n", encoding="utf-8")
    return str(path)


def write(path: Path, sound: NDArray[np.int16], rate: int = RATE) -> str:
    soundfile.write(path, sound, rate)
    return str(path)


def test_a_talker_is_reported_and_written_to_a_file(
    tmp_path: Path, talker: NDArray[np.int16], array: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write(tmp_path / "room.flac", talker)
    apart = tmp_path / "apart"
    assert (
        main(["detect", "voices", file, "--array", array, "--json", "--separate", str(apart), "--height", "0.8"]) == 0
    )
    (document,) = json.loads(capsys.readouterr().out)["files"]
    assert (document["duration_s"], document["rate"], document["microphones"]) == (2.0, RATE, 8)
    (track,) = document["tracks"]
    assert track["azimuth_deg"] == pytest.approx(60, abs=3)
    assert track["elevation_deg"] == pytest.approx(15, abs=4)
    assert 0 < track["begin_s"] < 0.6 < track["end_s"]
    assert 0 <= track["voice"] <= 1
    assert 1 < track["range_m"] < 6
    stamps = [row["time_s"] for row in document["timeline"]]
    np.testing.assert_allclose(np.diff(stamps), 2048 / RATE, atol=1e-3)
    assert document["timeline"][-1]["sources"][0]["track"] == track["track"]
    voice, rate = soundfile.read(track["file"], dtype="float32")
    assert (Path(track["file"]).parent, rate) == (apart, 16_000)
    assert voice.ndim == 1
    assert 1.0 < len(voice) / rate < 2.0
    assert voice.std() > 0.01


def test_a_table_for_people_and_one_without_voices(
    tmp_path: Path, talker: NDArray[np.int16], array: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write(tmp_path / "room.wav", talker)
    assert main(["detect", "voices", file, "--array", array, "--microphones", "4"]) == 0
    first, head, row = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{file}: 2.0 s, 1 source, ")
    assert head.split()[-4:] == ["azimuth", "elevation", "voice", "level"]
    assert row.split()[0] == "1"
    silent = write(tmp_path / "silent.wav", np.zeros((RATE // 2, 8), np.int16))
    assert main(["detect", "voices", silent, "--array", array]) == 1
    assert capsys.readouterr().out == f"{silent}: 0.5 s, 0 sources, 0 of them voices\n"


def test_any_rate_will_do(tmp_path: Path, array: str, capsys: pytest.CaptureFixture[str]) -> None:
    sound = heard(babble(0, 1.5, 44_100), toward(-40), 44_100)
    file = write(tmp_path / "cd.wav", as_int16(sound), 44_100)
    apart = tmp_path / "apart"
    assert main(["detect", "voices", file, "--array", array, "--json", "--separate", str(apart)]) == 0
    (document,) = json.loads(capsys.readouterr().out)["files"]
    assert document["tracks"][0]["azimuth_deg"] == pytest.approx(-40, abs=4)
    assert soundfile.info(document["tracks"][0]["file"]).samplerate == 22_050


def test_what_cannot_be_used_is_said_and_the_rest_is_done(
    tmp_path: Path, talker: NDArray[np.int16], array: str, capsys: pytest.CaptureFixture[str]
) -> None:
    good = write(tmp_path / "good.wav", talker)
    stereo = write(tmp_path / "stereo.wav", talker[:, :2])
    slow = write(tmp_path / "slow.wav", talker[:800], 8000)
    fast = write(tmp_path / "fast.wav", talker[:800], 2_000_000_000)
    text = tmp_path / "text.wav"
    text.write_text("no sound")
    silent = write(tmp_path / "silent.wav", talker[:0])
    assert main(["detect", "voices", stereo, slow, fast, str(text), silent, good, "--array", array]) == 2
    printed = capsys.readouterr()
    assert f"{stereo}: has 2 channels, but {array} has 8 microphones; there must be one channel for each" in printed.err
    assert f"{slow}: has 8000 samples a second; at least 16000 are needed" in printed.err
    assert f"{fast}: says it has 2000000000 samples a second; at most 384000 are taken" in printed.err
    assert f"{text}: cannot be read as a recording (WAV, FLAC, Ogg, MP3): Format not recognised\n" in printed.err
    assert f"{silent}: holds no sound" in printed.err
    assert f"{silent}: 0.0 s" not in printed.out
    assert f"{good}: 2.0 s, 1 source" in printed.out


def test_mistakes_on_the_command_line(tmp_path: Path, array: str, capsys: pytest.CaptureFixture[str]) -> None:
    missing = str(tmp_path / "missing.wav")
    assert main(["detect", "voices", missing, "--array", array]) == 2
    assert f"there is no file or folder {missing}" in capsys.readouterr().err
    assert main(["detect", "voices", array, "--array", array, "--microphones", "9"]) == 2
    assert f"--microphones: {array} has 8, not 9" in capsys.readouterr().err
    assert main(["detect", "voices", missing, "--array", missing]) == 2
    with pytest.raises(SystemExit):
        main(["detect", "voices", missing, "--array", array, "--height", "tall"])
    assert "must be a height from 0 to 10 (m), not 'tall'" in capsys.readouterr().err


def test_a_folder_is_listened_through_with_what_is_below(
    tmp_path: Path, talker: NDArray[np.int16], array: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sounds = tmp_path / "sounds"
    (sounds / "below").mkdir(parents=True)
    write(sounds / "below" / "room.flac", talker[: RATE // 2])
    write(sounds / "silent.wav", np.zeros((RATE // 2, 8), np.int16))
    (sounds / "notes.txt").write_text("no sound")
    assert main(["detect", "voices", str(sounds), "--array", array, "--json"]) in (0, 1)
    files = json.loads(capsys.readouterr().out)["files"]
    assert [Path(file["file"]).name for file in files] == ["room.flac", "silent.wav"]
    (sounds / "empty.wav").write_bytes(b"")
    assert main(["detect", "voices", str(sounds), "--array", array]) == 2
    printed = capsys.readouterr()
    assert f"{sounds / 'empty.wav'}: holds no sound: the file is empty" in printed.err
    assert printed.out.count(": 0.5 s, ") == 2
    empty = tmp_path / "empty"
    empty.mkdir()
    assert main(["detect", "voices", str(empty), "--array", array]) == 2
    assert f"{empty}: there is no recording in this folder or below" in capsys.readouterr().err


def test_sound_without_a_header_and_videos_are_refused_in_words(
    tmp_path: Path, array: str, capsys: pytest.CaptureFixture[str]
) -> None:
    raw = tmp_path / "sound.raw"
    raw.write_bytes(bytes(1024))
    assert main(["detect", "voices", str(raw), "--array", array]) == 2
    assert f"{raw}: cannot be read as a recording: " in capsys.readouterr().err
    video = tmp_path / "talk.mp4"
    video.write_bytes(b"\0\0\0\x20ftypisom" + bytes(100))
    assert main(["detect", "voices", str(video), "--array", array]) == 2
    assert "of a video, write the sound by itself: ffmpeg -i" in capsys.readouterr().err


def test_a_file_that_cannot_be_used_does_not_wait_for_what_hears(tmp_path: Path, array: str) -> None:
    empty = tmp_path / "empty.wav"
    empty.write_bytes(b"")
    arguments = ["detect", "voices", str(empty), "--array", array]
    heavy = "[name for name in ('scipy', 'onnxruntime', 'soundfile') if name in sys.modules]"
    command = f"import sys; from app.cli import main; main({arguments}); print({heavy})"
    done = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True)
    assert "holds no sound: the file is empty" in done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


def test_channels_in_another_order_than_the_array_says_are_noticed(
    tmp_path: Path, array: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sound = heard(babble(0, 4.0), toward(60)) + heard(babble(1, 4.0), toward(-75, 5))
    right = as_int16(sound + np.random.default_rng(1).normal(0, 1e-3, sound.shape))
    good, bad = (
        write(tmp_path / "right.wav", right),
        write(tmp_path / "swapped.wav", right[:, [0, 2, 1, 3, 4, 5, 6, 7]]),
    )
    assert main(["detect", "voices", good, bad, "--array", array, "--json"]) == 0
    printed = capsys.readouterr()
    assert f"{bad}: the microphones' positions do not explain what they heard (" in printed.err
    assert f"check the order of the channels, the positions (m) and body_m in {array}" in printed.err
    assert f"{good}: " not in printed.err
    of_good, of_bad = json.loads(printed.out)["files"]
    assert of_bad["warning"] in printed.err
    assert "warning" not in of_good
    assert of_bad["array_explains"] < 0.7 < of_good["array_explains"] <= 1
