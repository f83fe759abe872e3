"""``hbba log``: what it prints, writes, refuses, and leaves behind when it is interrupted."""

from __future__ import annotations

import csv
import errno
import io
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import SeekingReader
from mcap.records import ChunkIndex

from app import cli
from app.commands import progress as progressing
from app.commands.arguments import moment
from app.commands.log_report import clock, size
from app.logs.manifest import YAML, AttachedFile, Manifest
from app.logs.mcap.open_file import create
from app.logs.mcap.reader import McapLog
from app.logs.output_file import Progress
from tests.logs.mcap.mcap_files import BEGIN, drive, write_log
from tests.patience import PATIENCE_S

MANIFEST = Manifest(
    (AttachedFile("lab.yaml", YAML, b"robot: robot.yaml\n"),),
    {"program": "lab.yaml", "robot": "IRL-1/TR", "version": "0.1.0", "commit": "abcdef123456"},
)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("made") / "tour.mcap", drive(2.0), manifest=MANIFEST)


@pytest.fixture
def library(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of recordings with one in it, `tour`; the current folder is another, empty one."""
    folder, here = tmp_path / "recordings", tmp_path / "here"
    folder.mkdir()
    here.mkdir()
    shutil.copy(made, folder / "tour.mcap")
    monkeypatch.setenv("HBBA_RECORDINGS", str(folder))
    monkeypatch.chdir(here)
    return folder


def hbba(*arguments: str) -> int:
    return cli.main(["log", *arguments])


def damage(path: Path) -> None:
    """Flip a byte in the middle of the file, which is in a chunk."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)


def cut_off(path: Path, share: float = 0.7) -> None:
    os.truncate(path, int(share * path.stat().st_size))


def chunks(data: bytes) -> list[ChunkIndex]:
    summary = SeekingReader(io.BytesIO(data)).get_summary()
    assert summary is not None
    return summary.chunk_indexes


# --- list and info -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [(), ("list",)])
def test_the_list_says_size_length_and_state(
    arguments: tuple[str, ...], library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(library / "tour.mcap", library / "killed.mcap")
    cut_off(library / "killed.mcap")
    assert hbba(*arguments) == 0
    out = capsys.readouterr().out
    rows = {line.split()[0]: line for line in out.splitlines() if line}
    assert "2.0 s" in rows["tour"]
    assert rows["tour"].endswith("IRL-1/TR  complete")
    assert rows["killed"].endswith("unfinished")
    assert f"2 in {library}" in out


@pytest.mark.parametrize("arguments", [("--json",), ("list", "--json"), ("--json", "list")])
def test_the_list_is_printed_for_programs(
    arguments: tuple[str, ...], library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert hbba(*arguments) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["folder"] == str(library)
    assert document["free_bytes"] > 0
    (tour,) = document["recordings"]
    assert tour == {
        "name": "tour",
        "bytes": (library / "tour.mcap").stat().st_size,
        "duration_s": pytest.approx(2.0, abs=0.1),
        "began": pytest.approx(BEGIN, abs=0.1),
        "state": "complete",
        "robot": "IRL-1/TR",
    }


def test_what_was_done_is_printed_for_programs(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def result(*arguments: str) -> dict[str, Any]:
        assert hbba(*arguments, "--json") == 0
        document: dict[str, Any] = json.loads(capsys.readouterr().out)
        return document

    cut = result("cut", "tour", "--to", "1")
    assert cut["out"] == str(library / "tour-cut.mcap")
    assert cut["bytes"] == (library / "tour-cut.mcap").stat().st_size
    exported = result("export", "tour", "csv", "--channels", "odometry")
    assert exported["folder"] == "tour-export"
    assert len(exported["written"]) == 1
    assert result("repair", "tour")["healthy"]
    damage(library / "tour.mcap")
    repaired = result("repair", "tour")
    assert repaired["out"] == str(library / "tour-repaired.mcap")
    assert [loss for loss in repaired["losses"] if not loss["index"]]


def test_a_mistake_leaves_standard_output_empty_for_programs(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("cut", "none", "--json") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "there is no file none" in err


@pytest.mark.parametrize("arguments", [[], ["info", "tour"]])
def test_a_reader_that_has_gone_causes_no_message(arguments: list[str], library: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    code = "import sys; from app.cli import main; sys.exit(main(['log', *sys.argv[1:]]))"
    # Unbuffered, as a long list is: the first line finds a closed pipe.
    done = subprocess.run(
        [sys.executable, "-u", "-c", code, *arguments],
        stdout=write,
        stderr=subprocess.PIPE,
        timeout=PATIENCE_S,
        check=False,
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")


def test_an_empty_library_is_said_to_be_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HBBA_RECORDINGS", str(tmp_path / "none"))
    assert hbba() == 0
    assert capsys.readouterr().out == f"There are no recordings in {tmp_path / 'none'} yet.\n"


def test_info_finds_a_recording_by_its_name(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("info", "tour") == 0
    out = capsys.readouterr().out
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line}
    assert rows["robot"][1:] == ["IRL-1/TR"]
    assert rows["commit"][1:] == ["abcdef123456"]
    assert rows["begin"][1] == datetime.fromtimestamp(BEGIN).strftime("%Y-%m-%d")
    assert rows["scan"][1:3] == ["LaserScan", "80"]
    assert float(rows["scan"][3]) == pytest.approx(40, abs=0.5)
    assert rows["lab.yaml"][1:] == ["18", "B"]


def test_info_as_json_counts_what_each_channel_takes(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("info", "tour", "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["state"], document["format"], document["facts"]["robot"]) == ("complete", "HBBA MCAP", "IRL-1/TR")
    assert document["bytes"] == (library / "tour.mcap").stat().st_size
    channels = {channel["name"]: channel for channel in document["channels"]}
    assert channels["kinect"]["messages"] == 30
    assert channels["kinect"]["nominal_hz"] == 15
    # Depth is kept raw, 48 x 64 of two bytes, and ranges and intensities four bytes a ray.
    assert 30 * 48 * 64 * 2 < channels["kinect"]["bytes"] < 30 * (48 * 64 * 2 + 6000)
    assert 80 * 720 * 8 < channels["scan"]["bytes"] < 80 * (720 * 8 + 700)


def test_info_of_an_unfinished_log_says_what_can_be_read_and_what_to_do(
    library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut_off(library / "tour.mcap")
    assert hbba("info", "tour") == 1
    out = capsys.readouterr().out
    assert "unfinished; readable are" in out
    assert "`hbba log repair` makes it readable" in out
    assert hbba("info", "tour", "--json") == 1
    document = json.loads(capsys.readouterr().out)
    assert document["state"] == "unfinished"
    assert document["messages"] > 100


def test_a_recording_being_written_is_distinct_from_an_abandoned_one(
    library: Path, made: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = create(library / "now.mcap")
    try:
        file.write(memoryview(made.read_bytes()[:30_000]))
        assert hbba("info", "now") == 1
        assert "is being recorded now" in capsys.readouterr().out
        for arguments in ([], ["--in-place"], ["-o", "other.mcap"]):
            assert hbba("repair", "now", *arguments) == 2
            assert "is being recorded now" in capsys.readouterr().err
        assert sorted(each.name for each in library.iterdir()) == ["now.mcap", "tour.mcap"]
    finally:
        file.close()


@pytest.mark.parametrize("content", [b"", b"no log", b"\x89MCAP0\r\nwhat is this"])
def test_what_is_no_log_is_one_sentence(
    content: bytes, library: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "thing.mcap"
    file.write_bytes(content)
    for action in (["info"], ["repair"], ["cut"], ["export"]):
        assert hbba(*action, str(file), *(["png"] if action == ["export"] else [])) == 2
        error = capsys.readouterr().err
        assert error.startswith("hbba log: ")
        assert str(file) in error
        assert error.count("\n") == 1


def test_junk_that_begins_as_a_log_is_not_sent_from_one_command_to_the_next(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "junk.mcap"
    file.write_bytes(b"\x89MCAP0\r\n" + random.Random(1).randbytes(5000))
    for action in ("info", "repair"):
        assert hbba(action, str(file)) == 2
        error = capsys.readouterr().err
        assert f"{file}: nothing in it can be read" in error
        assert "hbba log repair" not in error


def test_a_log_without_a_name_is_said_to_have_none(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("info", "") == 2
    assert "a log is named by its file" in capsys.readouterr().err


def test_of_a_folder_full_of_logs_some_are_named(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in range(5):
        shutil.copy(library / "tour.mcap", library / f"tour-{number}.mcap")
    for action in ("info", "repair"):
        assert hbba(action, str(library)) == 2
        error = capsys.readouterr().err
        assert "tour-2.mcap" in error
        assert "tour-3.mcap" not in error
        assert "and 3 more" in error


def test_a_name_that_is_not_there_is_said(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("info", "tuor") == 2
    assert f"no recording of that name in {library}" in capsys.readouterr().err


# --- cut and repair ----------------------------------------------------------------------------------------------


def test_cut_from_the_library_into_a_file_beside_it(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("cut", "tour", "--from", "0.5", "--to", "0:01.5") == 0
    assert capsys.readouterr().out.startswith(f"{library / 'tour-cut.mcap'}: 1.0 s from 0.5 s to 1.5 s, ")
    log = McapLog(library / "tour-cut.mcap")
    assert log.info.begin == pytest.approx(BEGIN + 0.5, abs=0.02)
    assert log.info.end == pytest.approx(BEGIN + 1.5, abs=0.02)
    log.close()
    assert hbba("cut", "tour") == 2
    assert "exists already; --force replaces it" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--from", "5"], "the log has 1.99"),
        (["--from", "1", "--to", "0.5"], "--to must not be before --from"),
        (["--to", "2001-01-01T12:00"], "the log has 1.99"),
        (["--channels", "laser"], "there is no channel laser; there are joints, kinect, link_status, odometry, scan"),
    ],
)
def test_a_cut_that_makes_no_sense_is_refused(
    arguments: list[str], sentence: str, library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert hbba("cut", "tour", *arguments) == 2
    assert sentence in capsys.readouterr().err
    assert [each.name for each in library.iterdir()] == ["tour.mcap"]


def test_repair_says_what_was_recovered_and_what_is_missing(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    damage(library / "tour.mcap")
    assert hbba("cut", "tour") == 2
    assert "hbba log repair" in capsys.readouterr().err
    assert hbba("repair", "tour") == 0
    out = capsys.readouterr().out
    assert f"{library / 'tour-repaired.mcap'}: recovered " in out
    assert "a chunk: " in out
    assert " s are missing" in out
    assert "% of the file)" in out
    assert hbba("info", "tour-repaired") == 0
    capsys.readouterr()
    assert hbba("repair", "tour-repaired") == 0
    assert "there is nothing to repair" in capsys.readouterr().out


def test_repair_does_not_claim_to_know_what_never_came_into_the_file(
    library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = (library / "tour.mcap").read_bytes()
    cut_off(library / "tour.mcap", 0.3)
    assert hbba("repair", "tour") == 0
    out = capsys.readouterr().out
    assert "Missing in all" not in out
    length = re.search(r"topics over (\d\.\d s)", out)
    assert length is not None
    assert float(length[1].removesuffix(" s")) < 1
    ending = f"The recording ends at {length[1]}, where the file does. Whether anything came after cannot be known"
    assert ending in out
    # Killed just behind a chunk: nothing in it is hurt, but what waited for the next chunk is not there.
    end = min(index.chunk_start_offset + index.chunk_length for index in chunks(whole)[3:])
    (library / "killed.mcap").write_bytes(whole[:end])
    assert hbba("repair", "killed") == 0
    out = capsys.readouterr().out
    assert "No message" not in out
    assert "Nothing that is in the file is lost" in out
    assert "Whether anything came after cannot be known" in out
    # Only the summary is hurt: all that was written is there.
    (library / "summary.mcap").write_bytes(whole[:-20])
    assert hbba("repair", "summary") == 0
    assert capsys.readouterr().out.endswith("No message is missing: only the index at the end was.\n")


def test_a_folder_is_no_file_to_cut(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("cut", str(library)) == 2
    assert f"{library} is a folder; name an MCAP file: {library / 'tour.mcap'}" in capsys.readouterr().err


def test_repair_in_place_replaces_the_file(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cut_off(library / "tour.mcap")
    assert hbba("repair", "tour", "--in-place") == 0
    assert hbba("info", "tour") == 0
    assert [each.name for each in library.iterdir()] == ["tour.mcap"]


def test_a_full_disk_is_said_and_leaves_nothing(
    library: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("app.logs.output_file.os.fsync", full)
    assert hbba("cut", "tour") == 1
    assert f"the disk under {library} is full: tour-cut.mcap was not written" in capsys.readouterr().err
    assert [each.name for each in library.iterdir()] == ["tour.mcap"]


@pytest.mark.parametrize(
    "arguments", [("cut", "tour"), ("repair", "tour"), ("export", "tour", "csv"), ("export", "tour", "mp4")], ids=str
)
def test_ctrl_c_leaves_no_half_file(
    arguments: tuple[str, ...], library: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    @contextmanager
    def interrupted(title: str) -> Iterator[Progress]:
        def progress(done: float, total: float, text: str = "") -> None:
            if done > 0.7 * total:
                signal.raise_signal(signal.SIGINT)

        yield progress

    # As at the start of a program, whatever was done with the signal in this one before.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if "repair" in arguments:
        cut_off(library / "tour.mcap", 0.9)
    monkeypatch.setattr(progressing, "shown", interrupted)
    assert hbba(*arguments) == 130
    assert [each.name for each in library.iterdir()] == ["tour.mcap"]
    assert [each for each in Path().rglob("*") if each.is_file()] == []
    assert capsys.readouterr() == ("", "")


# --- export ------------------------------------------------------------------------------------------------------


def test_export_into_a_folder_named_after_the_log(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("export", "tour", "csv", "--channels", "odometry,joints", "--from", "1") == 0
    folder = Path("tour-export")
    assert sorted(each.name for each in folder.iterdir()) == ["joints.csv", "odometry.csv"]
    with (folder / "odometry.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 100
    assert float(rows[0]["stamp_s"]) == pytest.approx(BEGIN + 1)
    assert f"tour-export/odometry.csv: {len(rows)} rows" in capsys.readouterr().out


@pytest.mark.slow
def test_every_kind_of_file_comes_out_of_a_recording(library: Path) -> None:
    for kind in ("png", "mp4", "csv", "pcd"):
        assert hbba("export", "tour", kind, "--to", "0.4") == 0
    assert sorted(each.name for each in Path("tour-export").iterdir()) == [
        "joints.csv", "kinect", "kinect-depth", "kinect-points", "kinect.mp4", "link_status.csv", "odometry.csv",
        "scan-points", "scan.csv",
    ]  # fmt: skip


def test_a_file_in_place_of_the_folder_is_named(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("out").write_text("mine")
    assert hbba("export", "tour", "csv", "-o", "out") == 2
    assert capsys.readouterr().err == "hbba log: out is a file, no folder; -o names another\n"


def test_a_log_without_sound_says_so(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("export", "tour", "wav") == 2
    assert "the log has no sound" in capsys.readouterr().err
    assert list(Path().iterdir()) == []


def test_a_channel_of_another_kind_is_refused(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hbba("export", "tour", "mp4", "--channels", "scan") == 2
    assert "scan holds LaserScan, which mp4 does not; it could hold kinect" in capsys.readouterr().err


# --- Times and sizes ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "seconds"), [("0", 0), ("90.5", 90.5), ("1:30", 90), ("1:02:03.5", 3723.5), ("00:07", 7)]
)
def test_times_count_from_the_begin(text: str, seconds: float) -> None:
    assert moment(text)(BEGIN) == BEGIN + seconds


def test_a_date_is_that_moment_whatever_the_begin() -> None:
    assert moment("2026-03-14T15:09:26+01:00")(BEGIN) == 1_773_497_366
    assert moment("2026-03-14 15:09:26")(BEGIN) == datetime(2026, 3, 14, 15, 9, 26).timestamp()


@pytest.mark.parametrize("text", ["x", "1:x", "-5", "1:2:3:4", "", "nan", "2026-13-01"])
def test_what_is_no_time_is_refused(text: str, library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        hbba("cut", "tour", f"--from={text}")
    assert left.value.code == 2
    assert "a time is seconds from the log's begin" in capsys.readouterr().err


def test_lengths_and_sizes_for_people() -> None:
    assert [clock(seconds) for seconds in (0.04, 59.94, 61.26, 3723.5)] == ["0.0 s", "59.9 s", "1:01.3", "1:02:03"]
    assert [size(count) for count in (12, 999, 1500, 999_900, 12_340_000_000)] == [
        "12 B", "999 B", "1.5 kB", "1 MB", "12.3 GB",
    ]  # fmt: skip
