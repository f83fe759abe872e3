"""Cutting: the piece holds exactly the records of its time, as they were, and begins with the state that stood then."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from mcap.reader import SeekingReader
from mcap.writer import Writer

from app.log_tools.cut import CutReport, cut
from app.logs.log import LogError, Logged
from app.logs.manifest import YAML, AttachedFile, Manifest
from app.logs.mcap.reader import McapLog
from app.logs.stamps import SECOND, to_ns
from app.messages import Desire, Desires, ModuleRecord, Source, TimelineEvent
from app.runtime.channel_table import ChannelSpec
from tests.logs.mcap.mcap_files import BEGIN, CHANNELS, drive, write_log

Records = list[tuple[str, int, int, bytes]]

TABLE = {
    **CHANNELS,
    "workspace": ChannelSpec(type="Desires", latched=True),
    "module_states": ChannelSpec(type="ModuleRecord", latched=True),
    "events": ChannelSpec(type="TimelineEvent"),
}
MANIFEST = Manifest((AttachedFile("lab.yaml", YAML, b"robot: robot.yaml\n"),), {"program": "lab.yaml", "robot": "IRL"})


def desires(at: float, *ids: str) -> Logged:
    wanted = (Desire(each, "GoTo", 1.0, 1.0, False, {}, Source("operator", "a"), at, at + 60) for each in ids)
    return Logged(at, "workspace", Desires(at, tuple(wanted)))


def module(at: float, name: str, status: str) -> Logged:
    return Logged(at, "module_states", ModuleRecord(at, name, status, 0, ""))


def event(at: float, text: str) -> Logged:
    return Logged(at, "events", TimelineEvent(1, at, "desire", "a", text))


STATES = [
    module(BEGIN + 0.01, "Kinect", "running"),
    module(BEGIN + 0.02, "Teleop", "starting"),
    module(BEGIN + 0.03, "Teleop", "running"),
    desires(BEGIN + 0.10, "a"),
    event(BEGIN + 0.10, "a was added"),
    desires(BEGIN + 0.50, "a", "b"),
    desires(BEGIN + 1.50, "b"),
    module(BEGIN + 1.60, "Kinect", "failed"),
]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    messages = sorted([*drive(2.0), *STATES], key=lambda logged: logged.at)
    return write_log(tmp_path_factory.mktemp("cut") / "whole.mcap", messages, TABLE, MANIFEST)


def records(path: Path, topics: Sequence[str] | None = None) -> Records:
    with path.open("rb") as stream:
        found = SeekingReader(stream, validate_crcs=True).iter_messages(topics)
        return [(channel.topic, each.log_time, each.publish_time, each.data) for _, channel, each in found]


def state(path: Path, channel: str) -> list[Logged]:
    opened = McapLog(path)
    try:
        return list(opened.messages(channels=[channel]))
    finally:
        opened.close()


def test_a_piece_has_the_records_of_its_time_as_they_were(log: Path, tmp_path: Path) -> None:
    begin, end = BEGIN + 0.7, BEGIN + 1.3
    report = cut(log, tmp_path / "piece.mcap", begin, end)
    expected = [record for record in records(log) if to_ns(begin) <= record[1] <= to_ns(end)]
    assert report.messages == len(expected) > 100
    got = records(tmp_path / "piece.mcap")
    assert got[report.standing :] == expected
    assert report == CutReport(
        tmp_path / "piece.mcap", begin, end, len(expected), report.standing, (tmp_path / "piece.mcap").stat().st_size
    )


def test_it_begins_with_the_state_that_stood(log: Path, tmp_path: Path) -> None:
    begin = BEGIN + 0.7
    out = tmp_path / "piece.mcap"
    assert cut(log, out, begin, BEGIN + 1.3).standing == 3
    (workspace,) = state(out, "workspace")
    assert workspace.at == pytest.approx(begin, abs=1e-6)
    assert [desire.id for desire in workspace.message.desires] == ["a", "b"]
    # Its capture is when it came to be, not when the piece begins.
    assert workspace.message.stamp == pytest.approx(BEGIN + 0.5, abs=1e-6)
    assert [(each.message.module, each.message.status) for each in state(out, "module_states")] == [
        ("Kinect", "running"),
        ("Teleop", "running"),
    ]


def test_what_happened_before_is_no_state(log: Path, tmp_path: Path) -> None:
    cut(log, tmp_path / "piece.mcap", BEGIN + 0.7, BEGIN + 1.3)
    assert state(tmp_path / "piece.mcap", "events") == []
    assert records(log, ["/events"]) != []


def test_files_and_facts_come_along(log: Path, tmp_path: Path) -> None:
    cut(log, tmp_path / "piece.mcap", BEGIN + 1)
    opened = McapLog(tmp_path / "piece.mcap")
    assert opened.manifest == MANIFEST
    assert opened.info.channels.keys() == TABLE.keys()
    assert opened.info.channels["scan"].rate_hz == 40
    opened.close()


def test_only_the_channels_named_with_all_their_topics(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "piece.mcap"
    cut(log, out, channels=["kinect", "workspace"])
    opened = McapLog(out)
    assert opened.info.channels.keys() == {"kinect", "workspace"}
    (first, *_), whole = opened.messages(channels=["kinect"]), drive(2.0)
    assert first.message.depth is not None
    assert opened.info.channels["kinect"].count == sum(logged.channel == "kinect" for logged in whole)
    opened.close()


def test_the_whole_log_is_the_same_log(log: Path, tmp_path: Path) -> None:
    assert cut(log, tmp_path / "piece.mcap").standing == 0
    assert records(tmp_path / "piece.mcap") == records(log)


def test_an_unknown_channel_is_named_with_those_there_are(log: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"no channel laser; there are .*joints.*kinect.*scan"):
        cut(log, tmp_path / "piece.mcap", channels=["laser", "scan"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("begin", "end"), [(BEGIN + 5, None), (None, BEGIN - 5), (BEGIN + 1.5, BEGIN + 1)])
def test_times_outside_are_refused(log: Path, tmp_path: Path, begin: float | None, end: float | None) -> None:
    with pytest.raises(LogError, match=r"nothing lies between .* lasts \d\.\d+ s"):
        cut(log, tmp_path / "piece.mcap", begin, end)


def test_a_log_that_ends_in_the_middle_is_sent_to_repair(log: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(log.read_bytes()[:-500])
    with pytest.raises(LogError, match=r"hbba log repair"):
        cut(broken, tmp_path / "piece.mcap")


def test_damage_met_on_the_way_leaves_no_half_file(log: Path, tmp_path: Path) -> None:
    data = bytearray(log.read_bytes())
    data[len(data) // 2] ^= 0xFF
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data)
    with pytest.raises(LogError, match=r"is damaged .*hbba log repair"):
        cut(broken, tmp_path / "piece.mcap")
    assert [each.name for each in tmp_path.iterdir()] == ["broken.mcap"]


def test_nothing_is_overwritten_unasked_and_never_the_log_itself(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "piece.mcap"
    out.write_bytes(b"mine")
    with pytest.raises(LogError, match="exists already"):
        cut(log, out)
    assert out.read_bytes() == b"mine"
    cut(log, out, force=True)
    before = out.read_bytes()
    with pytest.raises(LogError, match="into itself"):
        cut(out, out, force=True)
    assert out.read_bytes() == before


def test_latched_topics_of_other_programs_are_states(tmp_path: Path) -> None:
    source = tmp_path / "ros.mcap"
    with source.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "rosbag2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
        latched = {"offered_qos_profiles": "- history: 1\n  durability: 1\n"}
        volatile = {"offered_qos_profiles": "- history: 1\n  durability: 2\n"}
        topics = [
            writer.register_channel(name, "cdr", schema, metadata)
            for name, metadata in (("/map", latched), ("/chatter", volatile), ("/tf_static", {}))
        ]
        for index in range(10):
            for topic in topics:
                writer.add_message(topic, index * SECOND, f"{topic} {index}".encode(), index * SECOND)
        writer.finish()
    report = cut(source, tmp_path / "piece.mcap", 5.0, 6.0)
    assert (report.messages, report.standing) == (6, 6)
    standing = records(tmp_path / "piece.mcap")[:6]
    assert {(topic, at) for topic, at, _, _ in standing} == {("/map", 5 * SECOND), ("/tf_static", 5 * SECOND)}
    assert [data for topic, _, _, data in standing if topic == "/map"] == [b"1 4"]


def test_a_file_that_is_mcap_by_name_alone_is_refused(tmp_path: Path) -> None:
    (tmp_path / "noise.mcap").write_bytes(bytes(range(256)))
    with pytest.raises(LogError, match=r"noise\.mcap: is not MCAP inside, and only MCAP files can be cut"):
        cut(tmp_path / "noise.mcap", tmp_path / "piece.mcap")
