"""Reading recordings back: what was written, from any moment, whichever part of the file is missing."""

from __future__ import annotations

import logging
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.stream_reader import breakup_chunk
from mcap.writer import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from app.base.geometry import FisheyeModel
from app.log_tools.export.exporter import Wish, export
from app.logs import layout as mcap_layout
from app.logs.log import Log, LogError, Logged
from app.logs.manifest import YAML, AttachedFile, Manifest
from app.logs.mcap.reader import McapLog
from app.logs.ros import typestore
from app.logs.ros.generated import generated
from app.logs.stamps import to_ns
from app.messages import Desire, Desires, Exploitation, Image, Source, TeleopCommand, Twist
from tests.logs.mcap.mcap_files import BEGIN, CHANNELS, drive, spec, write_log
from tests.logs.ros.messages import same


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Logged]]:
    """A drive of three seconds in chunks of about a fifth of one, and what went into it."""
    messages = drive(3.0)
    manifest = Manifest((AttachedFile("robots/body.yaml", YAML, b"name: body\n"),), {"robot": "body", "commit": ""})
    return write_log(tmp_path_factory.mktemp("logs") / "drive.mcap", messages, manifest=manifest), messages


def assert_same(read: list[Logged], written: list[Logged]) -> None:
    """Equal to the last bit, but for JPEG's colours and the last digit of headings."""
    assert [(r.at, r.channel) for r in read] == [(w.at, w.channel) for w in written]
    for r, w in zip(read, written, strict=True):
        back = r.message
        if isinstance(back, Image):
            assert np.abs(back.color.astype(int) - w.message.color).max() <= 8
            back = replace(back, color=w.message.color)
        if r.channel == "odometry":
            assert abs(back.X_OB.theta - w.message.X_OB.theta) < 1e-12
            back = replace(back, X_OB=w.message.X_OB)
        assert same(back, w.message)


def test_a_log_gives_back_what_was_recorded_in_order(recorded: tuple[Path, list[Logged]]) -> None:
    path, written = recorded
    log: Log = McapLog(path)
    assert_same(list(log.messages()), written)
    log.close()


def test_a_fisheyes_images_come_back_beside_a_pinholes(tmp_path: Path) -> None:
    lens = FisheyeModel.from_fov(64, 48, math.pi, math.pi)
    written = [logged for logged in drive(0.5) if logged.channel == "kinect"]
    for logged in tuple(written):
        seen = replace(logged.message, frame="panorama_optical_frame", depth=None, camera=lens)
        written.append(Logged(logged.at, "panorama", seen))
    path = write_log(tmp_path / "both.mcap", written, CHANNELS | {"panorama": spec("Image", 10)})
    log = McapLog(path)
    assert log.info.ignored == {}
    assert log.info.channels["panorama"].count == len(written) / 2
    assert_same(list(log.messages(channels=["panorama"])), [w for w in written if w.channel == "panorama"])
    assert_same(list(log.messages(channels=["kinect"])), [w for w in written if w.channel == "kinect"])
    export(log, Wish("png", tmp_path / "out", channels=["panorama"]))
    assert len(list((tmp_path / "out" / "panorama").iterdir())) == len(written) / 2
    export(log, Wish("mp4", tmp_path / "out", channels=["panorama"]))
    assert (tmp_path / "out" / "panorama.mp4").stat().st_size > 1000
    log.close()


def test_info_and_manifest_are_read_without_its_messages(
    recorded: tuple[Path, list[Logged]], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, written = recorded

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("messages were read")

    monkeypatch.setattr("app.logs.mcap.reader.SeekingReader.iter_messages", refuse)
    log = McapLog(path)
    info = log.info
    assert (info.format, info.path, info.bytes) == ("HBBA MCAP", path, path.stat().st_size)
    assert (info.begin, info.end) == (written[0].at, written[-1].at)
    assert {name: (c.message_type.__name__, c.count, c.rate_hz) for name, c in info.channels.items()} == {
        name: (row.message, sum(w.channel == name for w in written), row.rate_hz) for name, row in CHANNELS.items()
    }
    assert info.ignored == {}
    assert log.manifest.files == (AttachedFile("robots/body.yaml", YAML, b"name: body\n"),)
    assert log.manifest.facts == {"robot": "body", "commit": ""}
    log.close()


@pytest.mark.parametrize("begin", [0.0, 1.0, 1.7034, 2.99, 5.0])
@pytest.mark.parametrize("channels", [None, ["kinect"], ["odometry", "scan"], []])
def test_reading_begins_anywhere_with_any_channels(
    recorded: tuple[Path, list[Logged]], begin: float, channels: list[str] | None
) -> None:
    path, written = recorded
    log = McapLog(path)
    wanted = [w for w in written if w.at >= BEGIN + begin and (channels is None or w.channel in channels)]
    assert_same(list(log.messages(BEGIN + begin, channels)), wanted)
    log.close()


def test_begin_is_the_arrival_of_the_first_message_when_it_is_exactly_that(
    recorded: tuple[Path, list[Logged]],
) -> None:
    path, written = recorded
    log = McapLog(path)
    for first in written[100:110]:
        assert next(iter(log.messages(first.at))).at == first.at
    log.close()


def test_seeking_leaves_out_what_lies_before(
    recorded: tuple[Path, list[Logged]], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _ = recorded
    log = McapLog(path)
    read = 0
    real = breakup_chunk

    def counted(*args: Any, **keywords: Any) -> object:
        nonlocal read
        read += 1
        return real(*args, **keywords)

    monkeypatch.setattr("mcap.reader.breakup_chunk", counted)
    list(log.messages(BEGIN + 2.9))
    late = read
    list(log.messages())
    assert late <= 2 < (read - late) / 5
    log.close()


def test_iterators_of_one_log_do_not_disturb_each_other(recorded: tuple[Path, list[Logged]]) -> None:
    path, written = recorded
    log = McapLog(path)
    pairs = list(zip(log.messages(), log.messages(), strict=True))
    assert [a.at for a, _ in pairs] == [b.at for _, b in pairs] == [w.at for w in written]
    log.close()


def test_an_image_whose_depth_was_lost_is_left_out_and_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    lost = drive(1.0)
    third = [w.message for w in lost if w.channel == "kinect"][2]
    path = write_log(
        tmp_path / "lost.mcap",
        lost,
        keep=lambda record: not (record.topic == "/kinect/depth" and record.stamp_ns == to_ns(third.stamp)),
    )
    log = McapLog(path)
    with caplog.at_level(logging.WARNING):
        images = list(log.messages(channels=["kinect"]))
    assert [i.message.stamp for i in images] == [
        w.message.stamp for w in lost if w.channel == "kinect" and w.message is not third
    ]
    assert "messages of kinect" in caplog.text
    log.close()


def test_an_image_whose_last_record_is_missing_does_not_spoil_the_next(tmp_path: Path) -> None:
    messages = drive(1.0)
    stamps = [w.message.stamp for w in messages if w.channel == "kinect"]
    path = write_log(
        tmp_path / "lost.mcap",
        messages,
        keep=lambda record: not (record.topic == "/kinect/info" and record.stamp_ns == to_ns(stamps[4])),
    )
    log = McapLog(path)
    assert [i.message.stamp for i in log.messages(channels=["kinect"])] == stamps[:4] + stamps[5:]
    log.close()


def _foreign(writer: Writer) -> None:
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
    channel = writer.register_channel("/chatter", "cdr", schema)
    writer.add_message(channel, to_ns(BEGIN), b"\0\1\0\0\2\0\0\0a\0", 0)


def _unknown_class(writer: Writer) -> None:
    schema = writer.register_schema("hbba_msgs/msg/Smell", "ros2msg", b"builtin_interfaces/Time stamp\nfloat64 ppm")
    metadata = {mcap_layout.CHANNEL: "nose", mcap_layout.MESSAGE: "Smell"}
    channel = writer.register_channel("/nose", "cdr", schema, metadata)
    writer.add_message(channel, to_ns(BEGIN), b"\0\1\0\0" + bytes(16), 0)


def _changed_fields(writer: Writer) -> None:
    text = b"builtin_interfaces/Time stamp\nhbba_msgs/Pose2 x_wb\nfloat64 linear_mps\nfloat64 mood\n"
    text += b"=" * 80 + b"\nMSG: hbba_msgs/Pose2\nfloat64 x\nfloat64 y\nfloat64 theta\n"
    schema = writer.register_schema("hbba_msgs/msg/GroundTruth", "ros2msg", text)
    metadata = {mcap_layout.CHANNEL: "truth", mcap_layout.MESSAGE: "GroundTruth"}
    channel = writer.register_channel("/truth", "cdr", schema, metadata)
    writer.add_message(channel, to_ns(BEGIN), b"\0\1\0\0" + bytes(48), 0)


def _damaged_definition(writer: Writer) -> None:
    schema = writer.register_schema("hbba_msgs/msg/GroundTruth", "ros2msg", b"float64 \xc3\xa9 = = x\n")
    metadata = {mcap_layout.CHANNEL: "truth", mcap_layout.MESSAGE: "GroundTruth"}
    writer.register_channel("/truth", "cdr", schema, metadata)


def _other_type(writer: Writer) -> None:
    schema = writer.register_schema("geometry_msgs/msg/Twist", "ros2msg", b"")
    metadata = {mcap_layout.CHANNEL: "speed", mcap_layout.MESSAGE: "Odometry"}
    writer.register_channel("/speed", "cdr", schema, metadata)


def _other_part(writer: Writer) -> None:
    metadata = {mcap_layout.CHANNEL: "eye", mcap_layout.MESSAGE: "Image", mcap_layout.PART: "infrared"}
    writer.register_channel("/eye/infrared", "cdr", 0, metadata)


@pytest.mark.parametrize(
    ("extra", "topic", "reason"),
    [
        (_foreign, "/chatter", "another program"),
        (_unknown_class, "/nose", "no message 'Smell'"),
        (_other_type, "/speed", "keeps that part of Odometry as nav_msgs/msg/Odometry, not geometry_msgs/msg/Twist"),
        (_other_part, "/eye/infrared", "Image has no part 'infrared'"),
        (_changed_fields, "/truth", "GroundTruth has changed since: GroundTruth no longer has mood"),
        (_damaged_definition, "/truth", "GroundTruth has changed since: its definition cannot be read"),
    ],
)
def test_what_this_program_cannot_read_is_ignored_and_said(
    tmp_path: Path, extra: object, topic: str, reason: str
) -> None:
    messages = drive(0.2)
    log = McapLog(write_log(tmp_path / "log.mcap", messages, extra=extra))  # type: ignore[arg-type]
    assert list(log.info.ignored) == [topic]
    assert reason in log.info.ignored[topic]
    assert_same(list(log.messages()), messages)
    log.close()


def _older(writer: Writer, fields: str, values: tuple[Any, ...]) -> None:
    """An TeleopCommand as a program wrote it whose class had these fields after its stamp."""
    kind, text = "hbba_msgs/msg/TeleopCommand", f"builtin_interfaces/Time stamp\n{fields}"
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(text, kind))
    stamp = store.types["builtin_interfaces/msg/Time"](int(BEGIN), 0)
    data = bytes(store.serialize_cdr(store.types[kind](stamp, *values), kind))
    schema = writer.register_schema(kind, "ros2msg", store.generate_msgdef(kind, ros_version=2)[0].encode())
    metadata = {mcap_layout.CHANNEL: "teleop_command", mcap_layout.MESSAGE: "TeleopCommand"}
    channel = writer.register_channel("/teleop_command", "cdr", schema, metadata)
    writer.add_message(channel, to_ns(int(BEGIN)), data, 0)


def test_fields_that_came_later_have_their_defaults(tmp_path: Path) -> None:
    fields = "string operator\nint64 sequence\nbool held\nfloat64 linear\nfloat64 angular"
    path = write_log(tmp_path / "log.mcap", [], extra=lambda w: _older(w, fields, ("ada", 7, True, 0.5, -0.25)))
    log = McapLog(path)
    (drive,) = log.messages()
    assert drive.message == TeleopCommand(float(int(BEGIN)), "ada", 7, True, 0.5, -0.25, override=False)
    assert log.info.ignored == {}
    log.close()


def test_so_have_fields_that_came_later_within_a_field(tmp_path: Path) -> None:
    """An Exploitation from before twists had a sideways part."""

    def older(writer: Writer) -> None:
        kind = "hbba_msgs/msg/Exploitation"
        twist = "builtin_interfaces/Time stamp\nfloat64 linear_mps\nfloat64 angular_radps"
        text = (
            "builtin_interfaces/Time stamp\nbool has_behavior\nstring behavior\nhbba_msgs/Twist twist\nstring limited"
        )
        store = get_typestore(Stores.ROS2_HUMBLE)
        store.register(get_types_from_msg(twist, "hbba_msgs/msg/Twist"))
        store.register(get_types_from_msg(text, kind))
        stamp = store.types["builtin_interfaces/msg/Time"](int(BEGIN), 0)
        moves = store.types["hbba_msgs/msg/Twist"](stamp, 0.5, -0.25)
        data = bytes(store.serialize_cdr(store.types[kind](stamp, True, "Teleop", moves, "slowed"), kind))
        schema = writer.register_schema(kind, "ros2msg", store.generate_msgdef(kind, ros_version=2)[0].encode())
        metadata = {mcap_layout.CHANNEL: "exploitation", mcap_layout.MESSAGE: "Exploitation"}
        writer.add_message(
            writer.register_channel("/exploitation", "cdr", schema, metadata), to_ns(int(BEGIN)), data, 0
        )

    log = McapLog(write_log(tmp_path / "log.mcap", [], extra=older))
    (exploitation,) = log.messages()
    at = float(int(BEGIN))
    assert exploitation.message == Exploitation(at, "Teleop", Twist(at, 0.5, -0.25, 0.0), "slowed", group="base")
    assert log.info.ignored == {}
    log.close()


def test_so_have_those_of_what_is_a_struct(tmp_path: Path) -> None:
    """Desires from before emotions raised them."""
    kind = "hbba_msgs/msg/Desires"
    desire = Desire("d-1", "GoTo", 4.0, 2.0, False, {"x": 1.0}, Source("operator", "ada"), BEGIN)
    written = Desires(BEGIN, (desire,), exploited=("d-1",))
    today = generated(Desires).to_ros(written)

    def older(writer: Writer) -> None:
        text = re.sub(r"^.* (has_)?modulation\n", "", typestore.definition(kind), flags=re.MULTILINE)
        store = get_typestore(Stores.ROS2_HUMBLE)
        store.register({name: fields for name, fields in get_types_from_msg(text, kind).items() if "hbba" in name})
        data = bytes(store.serialize_cdr(_as_of(store, today), kind))
        schema = writer.register_schema(kind, "ros2msg", store.generate_msgdef(kind, ros_version=2)[0].encode())
        metadata = {mcap_layout.CHANNEL: "workspace", mcap_layout.MESSAGE: "Desires"}
        writer.add_message(writer.register_channel("/workspace", "cdr", schema, metadata), to_ns(BEGIN), data, 0)

    log = McapLog(write_log(tmp_path / "log.mcap", [], extra=older))
    assert log.info.ignored == {}
    (desires,) = log.messages()
    assert desires.message == written
    log.close()


def _as_of(store: Typestore, value: Any) -> Any:
    """A rosbags object as one of the types of ``store``, which may have fewer fields."""
    if isinstance(value, list):
        return [_as_of(store, each) for each in value]
    if not hasattr(value, "__msgtype__"):
        return value
    names = [name for name, _ in store.fielddefs[value.__msgtype__][1]]
    return store.types[value.__msgtype__](*[_as_of(store, getattr(value, name)) for name in names])


@pytest.mark.parametrize(
    ("fields", "values"),
    [
        ("string operator\nint64 sequence\nbool held", ("ada", 7, True)),  # what was missing then has no default
        ("string operator\nint64 sequence\nbool held\nfloat64 angular\nfloat64 linear", ("ada", 7, True, 0.5, 0.2)),
    ],
)
def test_fields_that_are_missing_otherwise_are_not_made_up(
    tmp_path: Path, fields: str, values: tuple[object, ...]
) -> None:
    log = McapLog(write_log(tmp_path / "log.mcap", [], extra=lambda writer: _older(writer, fields, values)))
    assert list(log.messages()) == []
    assert "TeleopCommand has changed since" in log.info.ignored["/teleop_command"]
    log.close()


def test_a_channel_without_its_main_topic_is_ignored_and_said(tmp_path: Path) -> None:
    path = write_log(tmp_path / "log.mcap", drive(0.2), keep=lambda record: record.topic != "/kinect/info")
    log = McapLog(path)
    assert set(log.info.ignored) == {"/kinect/color/compressed", "/kinect/depth"}
    assert "/kinect/info" in log.info.ignored["/kinect/depth"]
    assert "kinect" not in log.info.channels
    log.close()


def test_a_recording_may_be_empty(tmp_path: Path) -> None:
    log = McapLog(write_log(tmp_path / "empty.mcap", []))
    assert list(log.messages()) == []
    assert (log.info.channels, log.info.duration_s) == ({}, 0.0)
    log.close()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
def test_a_file_without_an_end_says_what_makes_it_readable(
    recorded: tuple[Path, list[Logged]], tmp_path: Path, share: float
) -> None:
    data = recorded[0].read_bytes()
    path = tmp_path / "killed.mcap"
    path.write_bytes(data[: max(int(share * len(data)), 8)])
    with pytest.raises(LogError, match=r"hbba log repair .*killed\.mcap"):
        McapLog(path)


def test_a_damaged_chunk_is_said_with_its_place_and_what_helps(
    recorded: tuple[Path, list[Logged]], tmp_path: Path
) -> None:
    data = bytearray(recorded[0].read_bytes())
    middle = len(data) // 2
    data[middle : middle + 200] = bytes(200)
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    log = McapLog(path)
    with pytest.raises(
        LogError, match=r"damaged\.mcap is damaged: .* from 0:0\d\.\d cannot be read\. `hbba log repair"
    ):
        list(log.messages())
    log.close()


def test_what_is_no_recording_is_refused_in_words(tmp_path: Path) -> None:
    text = tmp_path / "notes.txt"
    text.write_text("some notes")
    with pytest.raises(LogError, match="no MCAP file"):
        McapLog(text)
    empty = tmp_path / "empty"
    empty.write_bytes(b"")
    with pytest.raises(LogError, match="no MCAP file"):
        McapLog(empty)
    with pytest.raises(LogError, match="cannot be read"):
        McapLog(tmp_path / "absent.mcap")
    with pytest.raises(LogError, match="no recording of this program"):
        McapLog(write_log(tmp_path / "other.mcap", [], extra=_foreign, library="other 1.0"))


def test_a_channel_that_the_log_does_not_have_is_a_mistake(recorded: tuple[Path, list[Logged]]) -> None:
    log = McapLog(recorded[0])
    with pytest.raises(KeyError):
        log.messages(channels=["sonar"])
    log.close()


def test_rates_are_known_where_the_table_had_them(tmp_path: Path) -> None:
    messages = [m for m in drive(0.1) if m.channel == "odometry"]
    log = McapLog(write_log(tmp_path / "log.mcap", messages, {"odometry": spec("Odometry")}))
    assert log.info.channels["odometry"].rate_hz is None
    log.close()
