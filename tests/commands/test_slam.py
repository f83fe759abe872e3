"""``hbba slam``: maps out of logs, figures, files, and what is said of people's mistakes."""

from __future__ import annotations

import gzip
import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from app.cli import main
from app.maps.map_file import read_map
from app.modules.perception.slam.relations import between
from app.modules.perception.slam.storage import read_state
from tests.modules.perception.slam.rooms import around, driven, half_circle, ring

DATA = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[3] / "shared" / "data") / "slam"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Half a lap around a block, as arrays; the true poses beside it as relations and as a CARMEN log."""
    folder = tmp_path_factory.mktemp("slam")
    true = around(8.0, 0.2, laps=0.5)
    sweeps = list(driven(ring(5.5, 2.5), true, half_circle(181)))
    ranges = np.array([np.minimum(sweep.ranges, 81.83).round(2) for sweep in sweeps], dtype=np.float32)
    odometry = np.array([(s.X_OB.x, s.X_OB.y, s.X_OB.theta) for s in sweeps])
    np.savez(folder / "drive.npz", ranges=ranges, pose=odometry)
    poses = np.array([(p.x, p.y, p.theta) for p in true])
    first = np.arange(0, len(true) - 10, 5)
    relations = np.column_stack((first, first + 10, between(poses[first], poses[first + 10])))
    np.savetxt(folder / "relations.txt", relations, fmt="%d %d %.5f %.5f %.6f", header="i j dx dy dtheta")
    lines = []
    for k, ((x, y, theta), row) in enumerate(zip(poses, ranges, strict=True)):
        place = f"{x:.4f} {y:.4f} {theta:.5f}"
        readings = " ".join(f"{value:.3f}" for value in row)
        lines.append(f"FLASER {len(row)} {readings} {place} {place} {0.2 * k + 1:.3f} host {0.2 * k + 1:.3f}")
    (folder / "true.log").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "drive.npz"


def test_a_log_becomes_a_map_and_figures(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "made" / "here"
    relations, reference = log.parent / "relations.txt", log.parent / "true.log"
    arguments = ["--relations", str(relations), "--reference", str(reference), "--out", str(out), "--json"]
    assert main(["slam", str(log), *arguments]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["intact"] == "yes"
    assert result["relations"]["mean_m"] < 0.02
    assert result["relations"]["gross"] == 0
    assert result["reference"]["scans"] == result["scans"] == result["taken"]
    assert result["reference"]["rmse_m"] < 0.1
    grid = read_map(out / "map.yaml")
    assert (grid.cells == 100).sum() > 200
    assert (grid.cells == 0).sum() > 5 * (grid.cells == 100).sum()
    assert (out / "map.png").read_bytes().startswith(b"\x89PNG")
    assert len(read_state(out / "graph.npz").keyframes) == result["keyframes"]
    trajectory = np.loadtxt(out / "trajectory.tum")
    assert trajectory.shape == (result["taken"], 8)
    assert len((out / "trajectory.csv").read_text().splitlines()) == result["taken"] + 1
    assert [Path(path).name for path in result["written"]][:3] == ["map.yaml", "map.pgm", "map.png"]


def test_a_carmen_log_is_mapped_and_fewer_scans_are_taken(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["slam", str(log.parent / "true.log"), "--phi", "3"]) == 0
    said = capsys.readouterr().out
    count = len(np.load(log)["ranges"])
    assert f"{-(-count // 3)} of {count} (φ = 3)" in said
    assert "intact     yes" in said


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere.npz"], "there is no file nowhere.npz"),
        (["{log}", "--relations", "{log}"], "cannot be read"),
        (["{folder}/bad.txt"], "no log this program can read"),
        (["{folder}/bad.txt"], ", and arrays (.npz)"),
        (["{log}", "--relations", "{folder}/bad.txt"], "bad.txt:1"),
        (["{log}", "--relations", "{folder}/far.txt"], "names scan 99999"),
        (["{log}", "--reference", "{folder}/bad.txt"], "--reference"),
        (["{folder}/other.npz"], "has no array ranges and no array pose; it has x"),
        (["{folder}/shape.npz"], "must be (N, B) numbers"),
        (["{folder}/blind.npz"], "has no scan with odometry to it that shows anything"),
        (["{folder}/times.npz"], "`stamp` must be times in s, every one a finite number"),
        (["{log}", "--out", "{log}"], "--out: {log} is a file"),
        (["{folder}/true.log", "--range-max", "5"], "--range-max is for .npz"),
        (["{folder}/true.log", "--scans", "left"], "no such channel 'left'; it has scan"),
    ],
)
def test_mistakes_are_reported_in_a_sentence(
    log: Path, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = log.parent
    (folder / "bad.txt").write_text("this is nothing\n")
    (folder / "far.txt").write_text("0 99999 0 0 0\n")
    np.savez(folder / "other.npz", x=np.zeros(3))
    np.savez(folder / "shape.npz", ranges=np.zeros((3, 180)), pose=np.zeros((2, 3)))
    np.savez(folder / "blind.npz", ranges=np.full((9, 180), np.inf), pose=np.zeros((9, 3)))
    np.savez(folder / "times.npz", ranges=np.ones((3, 180)), pose=np.zeros((3, 3)), stamp=np.array(["a", "b", "c"]))
    names = {"log": str(log), "folder": str(folder)}
    assert main(["slam", *(argument.format(**names) for argument in arguments)]) == 2
    captured = capsys.readouterr()
    assert said.format(**names) in captured.err
    assert "Traceback" not in captured.err


def test_a_log_that_shows_nothing_at_first_is_mapped_from_where_it_does(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with np.load(log) as whole:
        ranges, poses = whole["ranges"].copy(), whole["pose"]
    ranges[:5] = np.inf
    np.savez(tmp_path / "late.npz", ranges=ranges, pose=poses)
    assert main(["slam", str(tmp_path / "late.npz"), "--relations", str(log.parent / "relations.txt"), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["intact"] == "yes"
    assert result["relations"]["mean_m"] < 0.02


def test_a_log_that_was_cut_off_says_so(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    packed = gzip.compress((log.parent / "true.log").read_bytes())
    (tmp_path / "cut.log.gz").write_bytes(packed[: len(packed) // 2])
    assert main(["slam", str(tmp_path / "cut.log.gz")]) == 0
    assert "ends in the middle of its packed text" in capsys.readouterr().out


def rewritten(log: Path, to: Path, stamp: Callable[[int], float], reading: Callable[[int, str], str]) -> Path:
    """The CARMEN log beside ``log`` with other stamps and readings, by number of the line and of the ray."""
    lines = []
    for k, words in enumerate(line.split() for line in (log.parent / "true.log").read_text().splitlines()):
        words[2:183] = [reading(ray, word) for ray, word in enumerate(words[2:183])]
        words[-3] = words[-1] = f"{stamp(k):.3f}"
        lines.append(" ".join(words))
    to.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return to


@pytest.mark.parametrize(
    ("stamp", "reading", "said"),
    [
        (lambda k: 0.0, lambda ray, word: word, "times of this log cannot be used"),
        (lambda k: 0.2 * k - 0.4 if k < 9 else 4294967295.0, lambda ray, word: word, "5 scans a second are assumed"),
        (lambda k: 0.2 * k, lambda ray, word: word, ""),
        (lambda k: 50.0 + 0.2 * k - 3.0 * (k % 50 == 20), lambda ray, word: word, "stamps that go back: "),
        (
            lambda k: 1.0 + 0.2 * k,
            lambda ray, word: "nan" if ray % 9 == 4 else word,
            "readings (11.0 %) are no distance",
        ),
    ],
    ids=["no times", "wrapped", "from 0 on", "going back", "no numbers"],
)
def test_a_log_with_odd_times_or_readings_is_mapped_all_the_same(
    log: Path,
    tmp_path: Path,
    stamp: Callable[[int], float],
    reading: Callable[[int, str], str],
    said: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    odd = rewritten(log, tmp_path / "odd.log", stamp, reading)
    reference = rewritten(log, tmp_path / "reference.log", stamp, reading)
    arguments = ["--relations", str(log.parent / "relations.txt"), "--reference", str(reference), "--json"]
    assert main(["slam", str(odd), *arguments]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["scans"] == result["taken"] == result["reference"]["scans"] == len(np.load(log)["ranges"])
    assert result["relations"]["gross"] == 0
    assert result["relations"]["mean_m"] < 0.02
    assert any(said in note for note in [*result["notes"], ""])


def test_stamps_of_arrays_that_go_back_are_said(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with np.load(log) as whole:
        ranges, poses = whole["ranges"].copy(), whole["pose"]
    ranges[:, 7] = np.nan
    stamps = 0.2 * np.arange(len(ranges))
    stamps[30:32] -= 5.0
    np.savez(tmp_path / "back.npz", ranges=ranges, pose=poses, stamp=stamps)
    assert main(["slam", str(tmp_path / "back.npz"), "--json"]) == 0
    notes = " ".join(json.loads(capsys.readouterr().out)["notes"])
    assert "stamps that go back: 1 (the first is number 30; by 4.80 s at most)" in notes
    assert "are no distance (no number, or too near)" in notes


@pytest.mark.slow
def test_the_intel_lab_is_mapped_to_millimetres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The beginning of the public log; all of it in ``python -m benchmarks slam``."""
    if not (DATA / "intel.npz").is_file():
        pytest.skip(f"the public laser logs are not there: {DATA} (set HBBA_REFERENCE_DATA)")
    rows = 1200
    with np.load(DATA / "intel.npz") as whole:
        np.savez(tmp_path / "intel.npz", ranges=whole["ranges"][:rows], pose=whole["pose"][:rows])
    relations = np.loadtxt(DATA / "intel.relations.txt")
    np.savetxt(tmp_path / "relations.txt", relations[relations[:, 1] < rows], fmt="%d %d %.6f %.6f %.7f %d")
    assert main(["slam", str(tmp_path / "intel.npz"), "--relations", str(tmp_path / "relations.txt"), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["relations"]["relations"] > 80
    assert result["relations"]["gross"] == 0
    assert result["relations"]["mean_m"] < 0.008
    assert result["relations"]["mean_deg"] < 0.2


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("FLASER 3 1 2 x 0 0 0 0 0 0 1.1 h 1.1", "line 2: 'x' found where a number should be"),
        ("FLASER 3 1 2 3 0 0 0 y 0 0 1.1 h 1.1", "line 2: 'y' found where a number should be"),
    ],
)
def test_a_word_in_a_line_of_numbers_is_reported_with_its_line(
    tmp_path: Path, line: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "c.log"
    log.write_text(f"ODOM 0 0 0 0 0 0 1.0 h 1.0\n{line}\n")
    assert main(["slam", str(log)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"hbba slam: {log}: has no laser scans")
    assert words in said
