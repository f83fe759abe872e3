"""``hbba detect noises``: claps in people's recordings."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import soundfile
from numpy.typing import NDArray

from app.cli import main
from app.commands.detect.noises_plot import Levels

CLAPS_S = (1.8, 2.6, 3.5)


def claps(rate: int, seconds: float = 4.0, at: tuple[float, ...] = CLAPS_S, seed: int = 0) -> NDArray[np.float64]:
    """Fans at -50 dB and claps (N,), full scale 1."""
    rng = np.random.default_rng(seed)
    sound = rng.normal(0, 0.003, round(seconds * rate))
    for begin in at:
        first = round(begin * rate)
        times = np.arange(min(rate // 4, len(sound) - first)) / rate
        decay = np.exp(-times / 0.02)
        sound[first : first + len(times)] += rng.normal(0, 0.3, len(times)) * decay
    return np.clip(sound, -1, 1)


@pytest.mark.parametrize("rate", [8_000, 16_000, 22_050, 44_100, 48_000, 96_000])
def test_claps_are_found_at_any_rate(rate: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "claps.wav"
    soundfile.write(file, claps(rate), rate)
    assert main(["detect", "noises", str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["ratio"], said["floor_db"], said["hold_off_s"]) == (20, -32, 0.25)
    (document,) = said["files"]
    assert (document["duration_s"], document["rate"], document["channels"]) == (4.0, rate, 1)
    assert [noise["time_s"] for noise in document["noises"]] == pytest.approx(CLAPS_S, abs=0.03)
    assert all(noise["ratio"] > 20 and -30 < noise["level_db"] < 0 for noise in document["noises"])


def test_what_several_channels_hear_is_one_noise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    near, far = claps(48_000), 0.5 * claps(48_000, at=(1.803, 2.602), seed=1)
    file = tmp_path / "stereo.flac"
    soundfile.write(file, np.stack([far, near], axis=1), 48_000)

    def noises(*options: str) -> list[dict[str, float]]:
        assert main(["detect", "noises", str(file), "--json", *options]) == 0
        return list(json.loads(capsys.readouterr().out)["files"][0]["noises"])

    both = noises()
    assert [noise["time_s"] for noise in both] == pytest.approx(CLAPS_S, abs=0.03)
    assert both[2]["microphone"] == 1
    assert [noise["time_s"] for noise in noises("--microphone", "0")] == pytest.approx(CLAPS_S[:2], abs=0.03)


def test_a_folder_a_table_and_plots(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "below").mkdir()
    soundfile.write(tmp_path / "below" / "claps.wav", claps(48_000), 48_000)
    soundfile.write(tmp_path / "calm.wav", claps(48_000, at=()), 48_000)
    out = tmp_path / "drawn"
    assert main(["detect", "noises", str(tmp_path), "--draw", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{tmp_path / 'below' / 'claps.wav'}: 4.0 s, 3 loud noises"
    assert lines[1].split() == ["at", "s", "background", "level", "microphone"]
    assert float(lines[2].split()[0]) == pytest.approx(1.8, abs=0.02)
    assert lines[5] == f"{tmp_path / 'calm.wav'}: 4.0 s, 0 loud noises"
    assert {path.name for path in out.iterdir()} == {"claps.noises.png", "calm.noises.png"}
    plot = cv2.imread(str(out / "claps.noises.png"))
    assert plot is not None
    assert plot.std() > 5
    assert main(["detect", "noises", str(tmp_path / "calm.wav")]) == 1


def test_the_settings_are_those_of_the_module(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "claps.wav"
    soundfile.write(file, claps(48_000), 48_000)

    def found(*options: str) -> int:
        main(["detect", "noises", str(file), "--json", *options])
        return len(json.loads(capsys.readouterr().out)["files"][0]["noises"])

    assert found("--ratio", "100000") == 0
    assert found("--floor", "0") == 0
    assert found("--hold-off", "5") == 1
    assert found("--window", "4", "--history", "3") == 1


def test_bad_files_are_named_and_the_others_listened_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    soundfile.write(tmp_path / "claps.wav", claps(48_000), 48_000)
    soundfile.write(tmp_path / "slow.wav", claps(4_000), 4_000)
    (tmp_path / "empty.wav").write_bytes(b"")
    (tmp_path / "text.wav").write_text("no sound")
    assert main(["detect", "noises", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert "claps.wav: 4.0 s, 3 loud noises" in printed.out
    assert "empty.wav: holds no sound" in printed.err
    assert "text.wav: cannot be read as a recording" in printed.err
    assert "slow.wav: has 4000 samples a second; at least 8000 are needed" in printed.err
    assert main(["detect", "noises", str(tmp_path / "claps.wav"), "--microphone", "1"]) == 2
    assert "has 1 channel, so no --microphone 1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--ratio", "1"], "must be a number above 1 to 1e+06, not '1'"),
        (["--floor", "3"], "must be a number from -120 to 0, not '3'"),
        (["--microphone", "left"], "must be a whole number from 0, not 'left'"),
    ],
)
def test_mistakes_are_said_in_words(options: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["detect", "noises", "sound.wav", *options])
    assert said in capsys.readouterr().err


def test_levels_of_a_long_recording_are_kept_where_they_come_nearest_to_the_threshold(tmp_path: Path) -> None:
    levels = Levels()
    for frame in range(100_000):
        levels.add(frame / 93.75, 0.5 if frame == 54_321 else 1e-5, 1e-3)
    assert len(levels._points) < 4096
    assert max(energy for _, energy, _ in levels._points) == 0.5
    levels.draw(tmp_path / "plot.png", "an hour $x", [])
    assert (tmp_path / "plot.png").stat().st_size > 1000
