"""The robot's model in a recording, as viewers find it."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

from app.logs.manifest import AttachedFile, Manifest
from app.logs.mcap.open_file import McapFile
from app.logs.mcap.reader import McapLog
from app.logs.ros.encoder import Encoder
from app.logs.ros.robot_description import robot_description
from app.messages import Odometry
from tests.logs.mcap.mcap_files import BEGIN, CHANNELS, drive

URDF = '<robot name="IRL-1 ✓"><link name="base_link"/></robot>'


def write(path: Path, manifest: Manifest) -> Path:
    file = McapFile(path, Encoder(CHANNELS), manifest, BEGIN)
    for logged in drive(1.0):
        if isinstance(logged.message, Odometry):
            file.write(logged.at, logged.channel, logged.message)
    file.close()
    return path


def test_a_viewer_finds_the_model_once_and_our_reader_does_not_take_it_for_a_channel(tmp_path: Path) -> None:
    manifest = Manifest((AttachedFile("robots/irl1.urdf", "", URDF.encode()),))
    path = write(tmp_path / "drive.mcap", manifest)
    with AnyReader([path]) as reader:
        models = [
            (stamp, vars(reader.deserialize(data, connection.msgtype))["data"])
            for connection, stamp, data in reader.messages()
            if connection.topic == "/robot_description"
        ]
    assert models == [(int(BEGIN * 1_000_000_000), URDF)]
    log = McapLog(path)
    assert set(log.info.channels) == {"odometry"}
    assert not log.info.ignored
    log.close()


@pytest.mark.parametrize("data", [b"\xff\xfe", None])
def test_without_a_model_that_is_text_there_is_none(data: bytes | None) -> None:
    files = () if data is None else (AttachedFile("robot.urdf", "", data),)
    assert robot_description(Manifest(files), 0) is None
