"""The stream that recording is measured on has the rates it says, and both writers write all of it."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

from app.logs.mcap.reader import McapLog
from app.messages import JointState
from benchmarks.recording import Arrived, at_full_rates, ours, rosbags, thinned
from tests.logs.mcap.disks import BEGIN, image, odometry


@pytest.fixture
def stream() -> list[Arrived]:
    """Half a second of a body whose camera is slow."""
    sparse: list[Arrived] = [(BEGIN + i / 50, "odometry", odometry(BEGIN + i / 50)) for i in range(25)]
    sparse += [(BEGIN + 0.1, "kinect", image(BEGIN)), (BEGIN + 0.3, "kinect", image(BEGIN, seed=1))]
    sparse += [(BEGIN + 0.2, "joints", JointState(BEGIN, ("pan",), (0.1,)))]
    return at_full_rates(sparse, 2)


def counts(stream: list[Arrived]) -> dict[str, int]:
    return {name: sum(channel == name for _, channel, _ in stream) for name in ("kinect", "odometry", "joints")}


def test_every_channel_has_the_rate_of_its_table(stream: list[Arrived]) -> None:
    assert counts(stream) == {"kinect": 30, "odometry": 200, "joints": 60}
    assert [at for at, _, _ in stream] == sorted(at for at, _, _ in stream)
    assert stream[-1][0] - stream[0][0] == pytest.approx(2, abs=0.05)


def test_only_pictures_and_scans_are_thinned(stream: list[Arrived]) -> None:
    assert counts(thinned(stream, 4)) == {"kinect": 7, "odometry": 200, "joints": 60}


def test_both_write_the_whole_stream(stream: list[Arrived], tmp_path: Path) -> None:
    assert all(figure > 0 for figure in ours(stream, tmp_path / "ours.mcap"))
    assert all(figure > 0 for figure in rosbags(stream, tmp_path / "peer"))
    log = McapLog(tmp_path / "ours.mcap")
    assert {name: channel.count for name, channel in log.info.channels.items()} == counts(stream)
    log.close()
    with AnyReader([tmp_path / "peer"]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == {
            "/kinect/color": 30, "/kinect/depth": 30, "/odometry": 200, "/joints": 60,
        }  # fmt: skip
