"""``hbba replay``: what it understands, what it refuses, and what it prints and writes."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest

from app.base import paths
from app.base.errors import ConfigError
from app.cli import main
from app.commands.arguments import find_log, moment, names, number, whole
from app.commands.replay import _phi, _speed
from app.logs.mcap.damage import place
from app.logs.mcap.open_file import McapFile
from app.logs.ros.encoder import Encoder
from app.program.config import load_configuration
from tests.logs.replay.logs import BEGIN, damage, lab_manifest, lab_messages, write_log
from tests.patience import PATIENCE_S

pytestmark = [pytest.mark.slow, pytest.mark.blocking(reason="the virtual loop waits for threads by design")]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("recordings") / "morning.mcap", lab_messages(3.0), lab_manifest())


def test_headless_prints_tables_and_writes_json(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = tmp_path / "result.json"
    assert main(["replay", str(recording), "--headless", "--out", str(result)]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"qr_codes +│ +\d+ │ [0-9a-f]{32}", printed)
    assert re.search(r"QRCodeDetector +│ +\d+\.\d{3} │ images \d+, panorama 0, ", printed)
    assert "find-qr-codes-1" in printed
    assert "times real time" in printed
    values = json.loads(result.read_text())
    assert values["channels"]["odometry"]["messages"] == 150
    assert (
        values["modules"]["QRCodeDetector"]["inputs"]["images"]["taken"] == values["channels"]["qr_codes"]["messages"]
    )
    assert set(values["cost"]["modules"]) == set(values["modules"])
    assert values["intentions"][0]["strategies"] == ["drive-by-hand"]


def test_two_runs_write_the_same(recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    reports = []
    for run in range(2):
        file = tmp_path / f"{run}.json"
        options = ["--phi", "QRCodeDetector.images=3", "--offset", "2", "--from", "0.5", "--to", "0:02.5"]
        assert main(["replay", str(recording), "--headless", "--out", str(file), *options]) == 0
        values = json.loads(file.read_text())
        del values["cost"]
        reports.append(values)
    assert reports[0] == reports[1]
    assert reports[0]["end"] - reports[0]["begin"] == pytest.approx(2.0)


def test_behind_damage_it_goes_on_and_says_what_is_missing(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "hurt.mcap"
    path.write_bytes(recording.read_bytes())
    begin, end = damage(path, BEGIN + 1.5)
    reports = []
    for run in range(2):
        file = tmp_path / f"{run}.json"
        assert main(["replay", str(path), "--headless", "--out", str(file)]) == 0
        values = json.loads(file.read_text())
        del values["cost"]
        reports.append(values)
    words = f"the log is damaged: {end - begin:.1f} s from {place(begin - BEGIN)} cannot be read"
    assert words in capsys.readouterr().out
    assert reports[0] == reports[1]
    assert reports[0]["notes"][-1] == words
    assert all(": the log has no " in note for note in reports[0]["notes"][:-1])
    # What arrived at the very moment that the chunk begins may stand in the one before.
    lost = sum(begin < m.at <= end for m in lab_messages(3.0) if m.channel == "odometry")
    assert 0 <= 150 - lost - reports[0]["channels"]["odometry"]["messages"] <= 1
    assert lost > 10


def test_a_replay_can_be_recorded_and_replayed_by_its_name(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path))
    assert main(["replay", str(recording), "--headless", "--record", "again"]) == 0
    assert (tmp_path / "again.mcap").is_file()
    assert capsys.readouterr().out.splitlines()[-1] == "recorded as again"
    assert main(["replay", str(recording), "--headless", "--record", "again", "--to", "0.5", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["recorded"] == "again-2"
    assert main(["replay", "again", "--headless", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)  # and nothing else is printed
    assert result["channels"]["odometry"]["messages"] == 150


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere.mcap", "--headless"], "no file nowhere.mcap, and no recording of that name"),
        (["../../etc/x", "--headless"], "no file ../../etc/x"),
        (["{log}", "--headless", "--only", "QRCodeDetecter"], "--only: there is no module 'QRCodeDetecter'; did you"),
        (
            ["{log}", "--headless", "--phi", "QRCodeDetector.image=2"],
            "no filter 'QRCodeDetector.image'; did you mean 'QRCode",
        ),
        (["{log}", "--headless", "--from", "9"], "the log has"),
        (["{log}", "--headless", "--from", "2", "--to", "1"], "must be later"),
        (["{log}", "--json"], "--json says what came of a replay without the console: add --headless"),
        (["{log}", "--out", "x.json"], "--out says what came of a replay without the console: add --headless"),
        (["{log}", "--headless", "--out", "{here}/none/x.json"], "there is no such folder"),
        (["{here}", "--headless"], "is no log this program can read"),
    ],
)
def test_a_mistake_is_one_sentence(
    recording: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    places = {"log": str(recording), "here": __file__}
    assert main(["replay", *(argument.format(**places) for argument in arguments)]) == 2
    errors = capsys.readouterr().err
    assert words in errors
    assert "hbba-replay-" not in errors
    assert errors.startswith("hbba replay: ")
    assert "Traceback" not in errors


def test_an_unfinished_recording_says_what_helps(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[:-500])
    assert main(["replay", str(cut), "--headless"]) == 2
    assert "hbba log repair" in capsys.readouterr().err


def test_a_recording_in_progress_is_said_to_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "now.mcap"
    file = McapFile(path, Encoder(load_configuration(paths.config_dir() / "lab.yaml").channels), lab_manifest(), BEGIN)
    assert main(["replay", str(path), "--headless"]) == 2
    assert "now.mcap: is still being recorded; stop that first" in capsys.readouterr().err
    file.close()


def test_the_range_of_speeds_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["replay", "--help"])
    assert "0.1 to 20 with the console, 0.1 to 100 without" in " ".join(capsys.readouterr().out.split())


def test_times_speeds_and_divisors_as_people_write_them() -> None:
    assert [moment(text)(1000.0) for text in ("90", "1:30", "0:02.5", "1:00:00")] == [1090.0, 1090.0, 1002.5, 4600.0]
    assert names("a, b") == ("a", "b")
    assert (whole(0)("0"), whole(1, 9)("9")) == (0, 9)
    assert (_speed("max"), _speed("0.5")) == (math.inf, 0.5)
    assert _phi("M.port=4") == ("M.port", 4.0)
    assert _phi("M.port=off") == ("M.port", math.inf)
    assert number("inf") is None
    for function, wrong in (
        (moment, "-3"), (moment, "1:x"), (names, "a,,b"), (whole(0), "1.5"), (whole(1), "0"),
        (whole(1, 9), "10"), (_speed, "0"), (_speed, "nan"),
        (_phi, "M=4"), (_phi, "M.p=0"), (_phi, "M.p=1.5"),
    ):  # fmt: skip
        with pytest.raises(argparse.ArgumentTypeError, match=re.escape(repr(wrong))):
            function(wrong)


def test_a_path_wins_over_a_recordings_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path / "library"))
    (tmp_path / "library").mkdir()
    kept = tmp_path / "library" / "walk.mcap"
    kept.touch()
    monkeypatch.chdir(tmp_path)
    assert find_log("walk") == kept
    assert find_log("walk.mcap") == kept
    (tmp_path / "walk").touch()
    assert find_log("walk") == Path("walk")
    with pytest.raises(ConfigError, match="no recording of that name"):
        find_log("talk")


def test_the_console_serves_a_replay_and_ends_with_a_signal(recording: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "app.cli", "replay", str(recording), "--port", "0"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONASYNCIODEBUG": ""},
        cwd=Path(__file__).parents[2],
    )  # fmt: skip
    try:
        assert process.stdout is not None
        line = next(line for line in process.stdout if "http" in line)
        assert line.startswith("HBBA replays morning.mcap: http://127.0.0.1:")
        url = re.search(r"http://[^\s#]+", line)
        assert url is not None
        with urllib.request.urlopen(f"{url[0]}/api/v1/playback", timeout=PATIENCE_S) as answer:
            assert json.load(answer)["file"] == "morning.mcap"
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0
    finally:
        process.kill()
        process.communicate()


def test_a_replay_without_viewers_ends(recording: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "app.cli", "replay", str(recording), "--port", "0", "--exit-when-unwatched", "1"],
        capture_output=True, text=True, timeout=PATIENCE_S, check=False, cwd=Path(__file__).parents[2],
        env={**os.environ, "PYTHONASYNCIODEBUG": ""},
    )  # fmt: skip
    assert done.returncode == 0
    assert "HBBA replays" in done.stdout
