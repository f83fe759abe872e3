"""CARMEN logs: small ones written here, and the public ones of Intel's lab and Freiburg's building 079."""

from __future__ import annotations

import gzip
import math
import os
import tracemalloc
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.logs.importers import carmen
from app.logs.importers.carmen_lines import KINDS, CarmenOdometry, CarmenScan, Param, parse
from app.logs.log import Log, LogError
from app.logs.open import open_log
from app.messages import LaserScan, Odometry

DATA = Path(os.environ.get("HBBA_REFERENCE_DATA") or Path(__file__).parents[4] / "shared" / "data") / "slam"

SMALL = """\
# CARMEN Logfile
# message formats defined : PARAM SYNC ODOM FLASER RLASER
PARAM robot_frontlaser_offset 0.25 host 0.0
PARAM robot_rearlaser_offset 0.15 host 0.0
SYNC begin 1000.0 host 0.0
ODOM 0 0 0 0.1 0.02 0 1000.0 host 0.0
FLASER 3 1 2 81.91 1.25 0.5 0 1 0.5 0 1000.1 host 0.11
RLASER 5 1 2 3 4 5 0 0 0.3 0 0 0.3 1000.15 host 0.16
ODOM 1 2 0.5 0.2 0 0 1000.2 host 0.2
ODOM 1 2 0.5 0.2 0 0 7.2 host 0.2
ODOM 1 2 half 0.2 0 0 1000.3 host 0.3
FLASER 3 1 2 1000.3 host 0.3
FLASER 3 1 x 2 1.25 0.5 0 1 0.5 0 1000.3 host 0.31
FLASER 3 4 5 6 0 0 0 0 0 0 1000.4 host 0.4
"""


def small(folder: Path, text: str = SMALL, *, packed: bool = False, name: str = "a") -> Path:
    path = folder / name
    path.write_bytes(gzip.compress(text.encode()) if packed else text.encode())
    return path


@pytest.mark.parametrize("packed", [False, True])
def test_each_line_becomes_its_message(tmp_path: Path, packed: bool) -> None:
    log = open_log(small(tmp_path, packed=packed))
    messages = list(log.messages())
    assert [(m.channel, round(m.at, 3)) for m in messages] == [
        ("odometry", 1000.0),
        ("odometry", 1000.11),
        ("scan", 1000.11),
        ("odometry", 1000.16),
        ("rear_scan", 1000.16),
        ("odometry", 1000.2),
        ("odometry", 1000.4),
        ("scan", 1000.4),
    ]
    first, at_scan, scan, _, rear, *_ = (m.message for m in messages)
    assert first == Odometry(1000.0, Pose2(), 0.1, 0.02)
    assert at_scan == Odometry(1000.1, Pose2(1, 0.5, 0), 0.1, 0.02)
    assert isinstance(scan, LaserScan)
    assert scan.stamp == 1000.1
    np.testing.assert_array_equal(scan.ranges, np.array([1, 2, math.inf], np.float32))
    assert (scan.angle_min, scan.angle_increment) == pytest.approx((-math.pi / 2, math.pi / 2))
    np.testing.assert_allclose(scan.X_BL.translation, [0.25, 0, 0])  # from the two poses of its line
    np.testing.assert_allclose(rear.X_BL.translation, [-0.15, 0, 0], atol=1e-12)  # from the parameter
    np.testing.assert_allclose(rear.X_BL.rotation @ [1, 0, 0], [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(messages[-1].message.X_BL.translation, [0.25, 0, 0])
    info = log.info
    assert (info.format, info.begin, info.end) == ("CARMEN", 1000.0, pytest.approx(1000.4))
    assert {name: channel.count for name, channel in info.channels.items()} == {
        "odometry": 5, "scan": 2, "rear_scan": 1,
    }  # fmt: skip
    assert log.manifest.facts == {"stream.hokuyo": "scan", "stream.odometry": "odometry"}


def test_damage_is_counted_and_does_not_stop_the_reading(tmp_path: Path) -> None:
    ignored = open_log(small(tmp_path)).info.ignored
    assert ignored["malformed lines"].startswith("3: line 11: ")
    assert ignored["ODOM without a time"].startswith("1 lines")
    assert ignored["SYNC"].startswith("1 lines")


def test_a_log_cut_off_in_the_middle_is_read_to_there(tmp_path: Path) -> None:
    lines = "".join(f"ODOM {i} 0 {math.sin(i)} 0 0 0 {1000 + i / 10} host {i / 10}\n" for i in range(20000))
    path = small(tmp_path, lines, packed=True)
    path.write_bytes(path.read_bytes()[:-40000])
    log = open_log(path)
    assert "end of the file" in log.info.ignored
    read = list(log.messages())
    assert 1000 < len(read) == log.info.channels["odometry"].count < 20000


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", ["FLASER 900000", "PARAM name", "ODD", ""])
def test_a_line_of_megabytes_is_passed_over(kind: str, packed: bool, tmp_path: Path) -> None:
    plain = open_log(small(tmp_path, name="plain"))
    head, rest = SMALL.split("RLASER 5", 1)
    text = head + kind + " 1.5" * 1_500_000 + "\nRLASER 5" + rest
    log = open_log(small(tmp_path, text, packed=packed))
    assert [(m.channel, m.at) for m in log.messages()] == [(m.channel, m.at) for m in plain.messages()]
    assert all(len(words) < 300 for words in (*log.info.ignored, *log.info.ignored.values()))


def test_a_packed_line_that_never_ends_is_given_up(tmp_path: Path) -> None:
    path = small(tmp_path, SMALL * 6 + "FLASER 180 " + "1 " * 60_000_000 + "\n" + SMALL, packed=True)
    assert path.stat().st_size < 1_000_000
    tracemalloc.start()
    log = open_log(path)
    count = sum(1 for _ in log.messages())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert count == 6 * 9  # the line without a time too: times that start again six times cannot be used
    assert "has a line of more than 64 MB, so it is no log" in log.info.ignored["end of the file"]
    assert peak < 30_000_000


def test_names_without_end_are_not_all_remembered(tmp_path: Path) -> None:
    names = "".join(f"X{number} 1 2\nPARAM p{number} {number} host 0.0\n" for number in range(5_000))
    ignored = open_log(small(tmp_path, SMALL + names)).info.ignored
    assert len(ignored) < 1_100
    assert int(ignored["others"].split()[0]) > 3_900


def test_reading_may_begin_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(carmen, "_MARK_EVERY", 1 << 17)
    ray = " ".join(["1.5"] * 180)
    lines = "".join(
        f"FLASER 180 {ray} {i} 0 0 {i} 0 0 {1000 + i / 10} host {i / 10}\n"
        f"ODOM {i} 0 0 0 0 0 {1000 + i / 10} host {i / 10}\n"
        for i in range(1000)
    )
    log = open_log(small(tmp_path, lines))
    scans = [m.at for m in log.messages(channels={"scan"})]
    for begin in (999.0, 1000.0, 1000.05, 1023.4, 1099.9, 1500.0):
        assert [m.at for m in log.messages(begin, {"scan"})] == [at for at in scans if at >= begin]


def test_the_new_messages_say_their_angles_themselves(tmp_path: Path) -> None:
    text = (
        "# CARMEN Logfile\n"
        "ROBOTLASER1 0 -0.5 1.0 0.25 50.0 0.01 1 5 1 2 3 50 4 5 9 8 7 6 5 "
        "1 2 0.5 1 2 0.5 0.3 0.1 0 0 0 1000.0 host 0.0\n"
        "RAWLASER1 0 -0.5 1.0 0.25 50.0 0.01 0 5 1 2 3 50 4 0 1000.0 host 0.0\n"
    )
    log = open_log(small(tmp_path, text))
    odometry, scan = (m.message for m in log.messages())
    assert odometry == Odometry(1000.0, Pose2(1, 2, 0.5), 0.3, 0.1)
    np.testing.assert_array_equal(scan.ranges, np.array([1, 2, 3, math.inf, 4], np.float32))
    np.testing.assert_array_equal(scan.intensities, np.array([9, 8, 7, 6, 5], np.float32))
    assert (scan.angle_min, scan.angle_increment, scan.range_max) == (-0.5, 0.25, 50.0)
    assert "RAWLASER1" in log.info.ignored


@pytest.mark.parametrize("name", ["intel-corrected.log.gz", "freiburg-079-corrected.log.gz"])
def test_the_public_logs_say_what_their_text_says(name: str) -> None:
    path = DATA / name
    if not path.is_file():
        pytest.skip(f"the public laser logs are not there: {DATA} (set HBBA_REFERENCE_DATA)")
    with gzip.open(path, "rt") as file:
        rows = [line.split() for line in file if line.startswith(("ODOM", "FLASER"))]
    scans = [row for row in rows if row[0] == "FLASER"]
    # GMapping wrote the corrected pose once more after each scan, with whatever stood in its memory as the time.
    timed = [row for before, row in zip([[""], *rows], rows, strict=False) if before[0] != "FLASER"]
    path_of = [(float(r[-6]), float(r[-5])) if r[0] == "FLASER" else (float(r[1]), float(r[2])) for r in timed]
    length = sum(math.dist(a, b) for a, b in pairwise(path_of))

    log = open_log(path)
    messages = list(log.messages())
    read = [m.message for m in messages if m.channel == "scan"]
    assert len(read) == len(scans) == log.info.channels["scan"].count
    assert (read[0].stamp, read[-1].stamp) == (float(scans[0][-1]), float(scans[-1][-1]))
    rays = int(scans[0][1])
    for message, row in zip(read[::97], scans[::97], strict=True):
        raw = np.array(row[2 : 2 + rays], np.float32)
        np.testing.assert_array_equal(message.ranges, np.where(raw < 80, raw, np.inf))
        assert message.angle_min == pytest.approx(math.radians(-90))
        assert message.angle_increment == pytest.approx(math.radians(180 / rays))
    odometry = [m.message for m in messages if m.channel == "odometry"]
    assert len(odometry) == len(timed) == log.info.channels["odometry"].count
    driven = sum(math.dist((a.X_OB.x, a.X_OB.y), (b.X_OB.x, b.X_OB.y)) for a, b in pairwise(odometry))
    assert driven == pytest.approx(length, rel=1e-9)
    assert "malformed lines" not in log.info.ignored


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("ODOM 1 2 3 0 0 0", "cut off|numbers"),
        ("ODOM 1 2 nan 0 0 0 1 host 1", "finite"),
        ("FLASER two 1 2 0 0 0 0 0 0 1 host 1", "number of readings"),
        ("FLASER 400 1 2 0 0 0 0 0 0 1 host 1", "ranges"),
        ("ROBOTLASER1 0 -1 2 0.5 50 0 0 5 1 2 3", "could not|ranges|cut off"),
        ("PARAM alone", "value"),
    ],
)
def test_a_bad_line_says_what_is_wrong(line: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        parse(line)


def test_lines_are_recognised_by_their_names() -> None:
    assert parse("NEFF 12.5") is None
    assert parse("") is None
    assert parse("PARAM a b host 0") == Param("a", "b")
    assert isinstance(parse("ODOM 1 2 3 0 0 0 1 host 1"), CarmenOdometry)
    assert isinstance(parse("FLASER 1 2 0 0 0 0 0 0 1 host 1"), CarmenScan)


def flaser(at: float, x: float = 0.0, readings: str = "1 2 3") -> str:
    return f"FLASER {len(readings.split())} {readings} {x} 0 0 {x} 0 0 {at} host {at}\n"


def stamps_of(log: Log, channel: str = "scan") -> list[float]:
    return [round(logged.message.stamp, 3) for logged in log.messages(channels={channel})]


@pytest.mark.parametrize(
    "stamps",
    [
        [0.0] * 60,
        [1000.0] * 60,
        [*(-0.4 + 0.004 * k for k in range(10)), *(4294967295.6 + 1e-4 * k for k in range(50))],
        [1000.0 if k % 2 else 5e8 + k for k in range(60)],
    ],
    ids=["all 0", "all alike", "wrapped", "to and fro"],
)
def test_a_log_whose_times_cannot_be_used_is_read_in_its_order(tmp_path: Path, stamps: list[float]) -> None:
    lines = "".join(f"ODOM {k} 0 0 0 0 0 {at} host {at}\n{flaser(at, k)}" for k, at in enumerate(stamps))
    log = open_log(small(tmp_path, lines))
    assert not log.info.timed
    assert any("times of this log cannot be used" in note and "5 scans a second" in note for note in log.info.notes)
    assert log.info.channels["scan"].count == 60
    assert stamps_of(log) == [round(0.2 * k + 0.1, 3) for k in range(60)]
    order = [(m.channel, m.message.X_OB.x) for m in log.messages() if m.channel == "odometry"]
    assert [x for _, x in order] == [k for k in range(60) for _ in range(2)]


def test_such_a_log_can_be_read_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(carmen, "_MARK_EVERY", 1 << 10)
    log = open_log(small(tmp_path, "".join(flaser(0.0, k) for k in range(200))))
    every = stamps_of(log)
    for begin in (0.0, 3.3, 20.0):
        assert [round(m.at, 3) for m in log.messages(begin, {"scan"})] == [at for at in every if at >= begin]


def test_the_first_scan_may_have_the_time_0(tmp_path: Path) -> None:
    lines = "".join(f"ODOM 0 0 0 0 0 0 {at} host {at}\n{flaser(at)}" for at in (0.0, 0.2, 0.4, 0.6))
    log = open_log(small(tmp_path, lines))
    assert log.info.timed
    assert log.info.notes == ()
    assert stamps_of(log) == [0.0, 0.2, 0.4, 0.6]


def test_stamps_that_go_back_are_said_and_put_in_their_place(tmp_path: Path) -> None:
    stamps = [1000 + 0.2 * k for k in range(50)]
    stamps[20] -= 3.0
    log = open_log(small(tmp_path, "".join(flaser(round(at, 3), k) for k, at in enumerate(stamps))))
    assert stamps_of(log) == [round(1000 + 0.2 * k, 3) for k in range(50)]
    assert stamps_of(log, "odometry") == stamps_of(log)
    (note,) = log.info.notes
    assert note.startswith("stamps that go back: 1 (the first in line 21; by 2.80 s at most)")


def test_a_reading_that_is_no_number_says_nothing_and_its_scan_stays(tmp_path: Path) -> None:
    log = open_log(small(tmp_path, flaser(1.0, readings="1 nan inf -2 -inf 3") + flaser(1.2, readings="1 1 1 1 1 1")))
    scan = next(m.message for m in log.messages(channels={"scan"}))
    np.testing.assert_array_equal(scan.ranges, np.array([1, 0, np.inf, 0, 0, 3], np.float32))
    assert "malformed lines" not in log.info.ignored
    assert log.info.notes == ("FLASER: 3 readings are no distance (no number, or below 0): they say nothing",)


def test_a_pile_of_readings_at_the_far_end_is_nothing_seen(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    ranges = rng.uniform(1.0, 30.0, (300, 180))
    ranges[rng.random(ranges.shape) < 0.0127] = 0.0
    ranges = np.where(ranges == 0.0, rng.uniform(50.5, 51.2, ranges.shape), ranges).round(2)
    lines = (flaser(1000 + 0.2 * k, readings=" ".join(map(str, row))) for k, row in enumerate(ranges))
    log = open_log(small(tmp_path, "".join(lines)))
    read = np.array([m.message.ranges for m in log.messages(channels={"scan"})])
    np.testing.assert_array_equal(np.isinf(read), ranges > 40.0)
    assert any("FLASER: readings from 50.5 m on" in note for note in log.info.notes)


def test_a_log_without_a_message_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no line of a laser or of odometry"):
        open_log(small(tmp_path, "# CARMEN Logfile\nPARAM a b host 0\n"))


@given(
    st.lists(
        st.sampled_from([*sorted(KINDS), "0", "1", "3", "-1", "0.5", "nan", "inf", "1e400", "x", "99999999999"]),
        max_size=25,
    )
)
def test_no_line_does_worse_than_being_refused(words: list[str]) -> None:
    with suppress(ValueError):
        parse(" ".join(words))
