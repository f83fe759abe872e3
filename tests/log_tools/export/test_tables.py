"""CSV and WAV."""

from __future__ import annotations

import csv
import json
import math
import os
import resource
import wave
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.log_tools.export.exporter import Wish, export
from app.logs.log import LogError, Logged
from app.messages import (
    Audio,
    Divisors,
    Exploitation,
    JointState,
    Landmark,
    Landmarks,
    LaserScan,
    LoadReport,
    LogLine,
    ModuleReport,
    Odometry,
    SeparatedSound,
    Twist,
    read_only,
)
from tests.log_tools.export.fakes import MemoryLog

BEGIN = 1_790_000_000.125


def table(folder: Path, channel: str) -> list[dict[str, str]]:
    with (folder / f"{channel}.csv").open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_nested_fields_become_columns_with_their_units(tmp_path: Path) -> None:
    odometry = [Logged(BEGIN + k, "odometry", Odometry(BEGIN + k, Pose2(0.1 * k, 2, -0.5), 0.3, 0.1)) for k in range(3)]
    driving = [Logged(BEGIN + 1, "who", Exploitation(BEGIN + 1, None, Twist(BEGIN, 0.1, 0.2)))]
    export(MemoryLog([*odometry, *driving]), Wish("csv", tmp_path))
    rows = table(tmp_path, "odometry")
    pose, twist = ["X_OB.x_m", "X_OB.y_m", "X_OB.theta_rad"], ["linear_mps", "angular_radps", "lateral_mps"]
    assert list(rows[0]) == ["stamp_s", *pose, *twist]
    assert [float(row["X_OB.x_m"]) for row in rows] == [0.0, 0.1, 0.2]
    assert float(rows[2]["stamp_s"]) == BEGIN + 2
    (row,) = table(tmp_path, "who")
    assert row == {
        "stamp_s": str(BEGIN + 1),
        "behavior": "",
        "twist.stamp_s": str(BEGIN),
        "twist.linear_mps": "0.1",
        "twist.angular_radps": "0.2",
        "twist.lateral_mps": "0.0",
        "limited": "",
        "group": "base",
        "outdone": "[]",
    }


def test_a_scan_is_a_row_and_every_ray_is_exact(tmp_path: Path) -> None:
    ranges = np.array([1.1, np.inf, 29.123456, 0.06], np.float32)
    scan = LaserScan(
        BEGIN, "laser", read_only(ranges), read_only(ranges), -1.5, 0.5, 0.06, 30.0, 0.025,
        Pose3.from_translation_rpy((0.1, 0.2, 0.3), (0, 0, math.pi / 2)),
    )  # fmt: skip
    export(MemoryLog([Logged(BEGIN, "scan", scan)]), Wish("csv", tmp_path))
    (row,) = table(tmp_path, "scan")
    back = np.array([float(row[f"ranges_m.{k}"]) for k in range(4)], np.float32)
    np.testing.assert_array_equal(back, ranges)
    assert row["angle_min_rad"] == "-1.5"
    assert [float(row[f"X_BL.{part}"]) for part in ("x_m", "y_m", "z_m")] == [0.1, 0.2, 0.3]
    assert float(row["X_BL.qw"]) == pytest.approx(math.sqrt(0.5))
    assert list(row)[-8:] == [f"{name}.{k}" for name in ("ranges_m", "intensities") for k in range(4)]


def load(stamp: float, **cpu: float) -> LoadReport:
    """Of modules that take ``cpu``."""
    reports = [ModuleReport(name, name, "running", each, None, None, 0, None, (), ()) for name, each in cpu.items()]
    return LoadReport(stamp, 1.0, 20.0, None, tuple(reports))


def test_values_that_have_names_stand_in_columns_of_these_names(tmp_path: Path) -> None:
    log = MemoryLog(
        [
            Logged(BEGIN, "joints", JointState(BEGIN, ("pan", "tilt"), (0.5, -0.25))),
            Logged(BEGIN, "load", load(BEGIN, Kinect=12.0)),
            Logged(BEGIN + 1, "load", load(BEGIN + 1, Kinect=13.0, Teleop=1.0)),
            Logged(BEGIN, "divisors", Divisors(BEGIN, ("A.images", "B.scan"), (2.0, math.inf))),
        ]
    )
    export(log, Wish("csv", tmp_path))
    (joints,) = table(tmp_path, "joints")
    assert joints == {"stamp_s": str(BEGIN), "positions.pan": "0.5", "positions.tilt": "-0.25"}
    assert [
        (row["modules.Kinect.cpu_percent"], row["modules.Teleop.cpu_percent"]) for row in table(tmp_path, "load")
    ] == [
        ("12.0", ""),
        ("13.0", "1.0"),
    ]
    (divisors,) = table(tmp_path, "divisors")
    assert float(divisors["divisors.B.scan"]) == math.inf


def test_lists_are_json_and_words_stay_words(tmp_path: Path) -> None:
    landmark = Landmark("DOCK-1", (1.0, 2.0, 0.5), 0.02, 7, BEGIN, BEGIN + 1)
    line = LogLine(BEGIN, 30, "hbba", 'said "stop", and\nleft: é')
    log = MemoryLog([Logged(BEGIN, "landmarks", Landmarks(BEGIN, (landmark,))), Logged(BEGIN, "log", line)])
    export(log, Wish("csv", tmp_path))
    (row,) = table(tmp_path, "landmarks")
    assert json.loads(row["landmarks"])[0]["p_FQ"] == [1.0, 2.0, 0.5]
    assert table(tmp_path, "log")[0]["text"] == line.text


def test_a_channel_that_cannot_be_written_so_is_refused_with_those_that_can(tmp_path: Path) -> None:
    log = MemoryLog([Logged(BEGIN, "odometry", Odometry(BEGIN, Pose2(), 0, 0))])
    with pytest.raises(LogError, match=r"no channel scan; there are odometry"):
        export(log, Wish("csv", tmp_path, channels=["scan"]))
    with pytest.raises(LogError, match=r"nothing that mp4 could hold"):
        export(log, Wish("mp4", tmp_path))
    with pytest.raises(LogError, match=r"the log has no sound"):
        export(log, Wish("wav", tmp_path))


# --- Sound -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Sound:
    """A message as a microphone would give."""

    stamp: float
    samples: NDArray[np.int16]
    rate: int


def sounds(lost: frozenset[int] = frozenset(), pieces: int = 50) -> tuple[MemoryLog, NDArray[np.int16]]:
    """Two channels of tone at 16 kHz in pieces of 20 ms that come with some jitter; and the whole of it."""
    rate, length = 16_000, 320
    time = np.arange(pieces * length) / rate
    whole = (8000 * np.sin(2 * np.pi * np.array([[440.0], [660.0]]) * time)).T.astype(np.int16)
    jitter = np.random.default_rng(3).uniform(-0.003, 0.003, pieces)
    log = MemoryLog(
        [
            Logged(BEGIN + 0.02 * k, "microphone", Sound(BEGIN + 0.02 * k + (jitter[k] if k else 0), piece, rate))
            for k, piece in enumerate(np.split(whole, pieces))
            if k not in lost
        ]
    )
    return log, whole


def heard(path: Path) -> tuple[int, NDArray[np.int16]]:
    with wave.open(str(path)) as sound:
        data = np.frombuffer(sound.readframes(sound.getnframes()), "<i2")
        return sound.getframerate(), data.reshape(-1, sound.getnchannels())


def test_sound_comes_back_sample_for_sample(tmp_path: Path) -> None:
    log, whole = sounds()
    export(log, Wish("wav", tmp_path))
    with pytest.raises(LogError, match="leave --every away"):
        export(log, Wish("wav", tmp_path, every=2, force=True))
    rate, samples = heard(tmp_path / "microphone.wav")
    assert rate == 16_000
    np.testing.assert_array_equal(samples, whole)


def test_what_is_missing_is_silence_so_that_the_time_stays_true(tmp_path: Path) -> None:
    log, whole = sounds(lost=frozenset(range(10, 20)))
    (line,) = export(log, Wish("wav", tmp_path)).lines()
    assert "0.2 s of it silence" in line
    _, samples = heard(tmp_path / "microphone.wav")
    assert len(samples) == pytest.approx(len(whole), abs=0.004 * 16_000)
    np.testing.assert_array_equal(samples[: 10 * 320], whole[: 10 * 320])
    assert not samples[10 * 320 : 19 * 320].any()
    tail = samples[-30 * 320 :]
    np.testing.assert_array_equal(tail, whole[-30 * 320 :])


def test_a_change_of_rate_is_said(tmp_path: Path) -> None:
    log, _ = sounds(pieces=3)
    log.content.append(Logged(BEGIN + 1, "microphone", Sound(BEGIN + 1, np.zeros((10, 1), np.int16), 8000)))
    with pytest.raises(LogError, match="changes from 2 channels at 16000 Hz to 1 at 8000 Hz"):
        export(log, Wish("wav", tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_more_than_the_format_holds_is_said_before_it_is_written(tmp_path: Path) -> None:
    log, _ = sounds(pieces=3)
    later = BEGIN + 24 * 3600.0
    log.content.append(Logged(later, "microphone", Sound(later, np.zeros((10, 2), np.int16), 16_000)))
    with pytest.raises(LogError, match=r"4 GB .* no more than 1118 minutes apart"):
        export(log, Wish("wav", tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_eight_channels_of_the_microphones_come_back_sample_for_sample(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    whole = rng.integers(-32768, 32767, (20 * 512, 8)).astype(np.int16)
    log = MemoryLog(
        [
            Logged(BEGIN + k * 512 / 48_000, "microphones", Audio(BEGIN + k * 512 / 48_000, "torso_link", piece, 48_000,
                                                                  k * 512, np.zeros((8, 3))))
            for k, piece in enumerate(np.split(whole, 20))
        ]
    )  # fmt: skip
    (line,) = export(log, Wish("wav", tmp_path)).lines()
    assert "8 channels at 48000 Hz" in line
    rate, samples = heard(tmp_path / "microphones.wav")
    assert rate == 48_000
    np.testing.assert_array_equal(samples, whole)


def test_each_separated_source_has_a_file_of_its_own_that_lasts_as_long_as_it(tmp_path: Path) -> None:
    rate, length = 16_000, 320
    pieces = []
    for k, tracks in enumerate([(3,), (3, 12), (12, 3), (), (12,)]):
        samples = np.tile([100 * track + k for track in tracks], (length, 1))
        stamp = BEGIN + 0.02 * k
        pieces.append(
            Logged(stamp, "separated_voices", SeparatedSound(stamp, tracks, samples.astype(np.int16), rate, k * length))
        )
    lines = export(MemoryLog(pieces), Wish("wav", tmp_path)).lines()
    assert len(lines) == 2
    assert "1 channel at 16000 Hz" in lines[0]
    _, third = heard(tmp_path / "separated_voices" / "track-003.wav")
    _, twelfth = heard(tmp_path / "separated_voices" / "track-012.wav")
    assert third[::length, 0].tolist() == [300, 301, 302]
    assert twelfth[::length, 0].tolist() == [1201, 1202, 1204]


def test_hours_of_sources_need_few_open_files_and_numbers_used_again_are_others(tmp_path: Path) -> None:
    def piece(stamp: float, track: int) -> Logged:
        samples = np.full((160, 1), track, np.int16)
        return Logged(stamp, "separated_voices", SeparatedSound(stamp, (track,), samples, 16_000, 0))

    many = [piece(BEGIN + 5.0 * k, k + 1) for k in range(80)]
    log = MemoryLog([*many, piece(BEGIN + 3600.0, 1)])
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (len(os.listdir("/dev/fd")) + 20, before[1]))
    try:
        export(log, Wish("wav", tmp_path))
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
    folder = tmp_path / "separated_voices"
    assert len(list(folder.iterdir())) == 81
    for name in ("track-001.wav", "track-001-2.wav"):
        assert len(heard(folder / name)[1]) == 160, "an hour of silence between them is nobody's"


def test_separated_sound_without_a_source_leaves_no_file(tmp_path: Path) -> None:
    nobody = SeparatedSound(BEGIN, (), np.zeros((320, 0), np.int16), 16_000, 0)
    export(MemoryLog([Logged(BEGIN, "separated_voices", nobody)]), Wish("wav", tmp_path))
    assert list((tmp_path / "separated_voices").iterdir()) == []
