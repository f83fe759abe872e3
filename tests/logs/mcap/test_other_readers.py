"""Other programs read our recordings, by what the file itself says of its types, and agree on what is in them."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from app.logs.log import Logged
from app.logs.stamps import to_ns
from app.messages import Message
from tests.logs.mcap.mcap_files import BEGIN, drive, spec, write_log
from tests.logs.ros.messages import message_classes, sequences

EVERY_TOPIC_OF_A_DRIVE = {
    "/joints", "/kinect/camera_info", "/kinect/color/compressed", "/kinect/depth", "/kinect/info", "/link_status",
    "/odometry", "/scan", "/scan/info", "/scan/points", "/tf",
}  # fmt: skip


def with_mcap_ros2(path: Path) -> list[tuple[str, int, Any]]:
    """Topic, log time and message of every record, decoded by mcap-ros2-support."""
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        decoded = list(reader.iter_decoded_messages())
        assert reader.get_header().profile == "ros2"
    return [(channel.topic, message.log_time, made) for _, channel, message, made in decoded]


def with_rosbags(path: Path) -> list[tuple[str, int, Any]]:
    """The same by rosbags, which knows no type but those the file defines."""
    with AnyReader([path]) as reader:
        return [
            (connection.topic, at, reader.deserialize(data, connection.msgtype))
            for connection, at, data in reader.messages()
        ]


def agree(a: Any, b: Any) -> bool:
    """Whether what two decoders made is equal in every field, whatever classes they use."""
    if isinstance(a, bytes | str | bool | int | float):
        return bool(a == b or (a != a and b != b)) if not isinstance(a, bytes) else a == bytes(b)
    if isinstance(a, list | tuple | np.ndarray):
        if isinstance(b, np.ndarray):
            return np.array_equal(np.asarray(a, b.dtype), b, equal_nan=b.dtype.kind == "f")
        return len(a) == len(b) and all(agree(x, y) for x, y in zip(a, b, strict=True))
    names = [field.name for field in fields(b) if not field.name.startswith("__") and not field.name.isupper()]
    return all(agree(getattr(a, name.rstrip("_")), getattr(b, name)) for name in names)


def assert_agreement(path: Path) -> list[tuple[str, int, Any]]:
    """Both readers find the same; returns it."""
    one, other = with_mcap_ros2(path), with_rosbags(path)
    assert [entry[:2] for entry in one] == [entry[:2] for entry in other]
    for (topic, at, a), (_, _, b) in zip(one, other, strict=True):
        assert agree(a, b), f"{topic} at {at}"
    return other


# One class at a time: where one example has all of them, most are refused as too large, and drawn again.
@pytest.mark.slow
@pytest.mark.parametrize("cls", message_classes(), ids=lambda cls: cls.__name__)
@settings(max_examples=1, deadline=None, phases=[Phase.generate], suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_every_topic_of_every_class_is_read_alike(
    cls: type[Message], data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    channel = cls.__name__.lower()
    messages = data.draw(sequences(cls, min_size=2, max_size=2))
    logged = [Logged(BEGIN, channel, message) for message in messages]
    path = write_log(tmp_path_factory.mktemp("log") / "log.mcap", logged, {channel: spec(cls.__name__)})
    assert {topic.split("/")[1] for topic, _, _ in assert_agreement(path)} - {"tf"} == {channel}


def test_a_whole_drive_is_read_alike_with_every_topic(tmp_path: Path) -> None:
    messages = drive(0.5)
    found = assert_agreement(write_log(tmp_path / "drive.mcap", messages))
    assert {topic for topic, _, _ in found} == EVERY_TOPIC_OF_A_DRIVE
    assert {at for _, at, _ in found} == {to_ns(logged.at) for logged in messages}
